// Python's interpreter lock: let go, taken back, and what becomes of a thread that asks for it when the program is over.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <exception>
#include <thread>

namespace bindings {

// Calls something that may take the lock. Once the program is over Python ends a daemon thread that asks for it: before
// 3.14 by pthread_exit, whose unwinding of the stack would abort the whole program in the first destructor, or function
// of nanobind's, that lets nothing through. Such a thread rests here instead until it is gone with the program, which is
// what Python does from 3.14 on.
template <class Call> auto called(const Call& call) -> decltype(call()) {
    try {
        return call();
    } catch (const std::exception&) {  // Python's errors too
        throw;
    } catch (...) {
        for (;;) std::this_thread::sleep_for(std::chrono::hours(24));
    }
}

inline void take_lock(PyThreadState* state) {
    called([&] { PyEval_RestoreThread(state); });
}

// Does something that takes its time without the lock. No destructor takes it back.
template <class Work> void without_lock(const Work& work) {
    PyThreadState* const state = PyEval_SaveThread();
    try {
        work();
    } catch (...) {
        take_lock(state);
        throw;
    }
    take_lock(state);
}

}  // namespace bindings
