// Python's interpreter lock: release it, take it back, and survive a request after the program has ended.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <exception>
#include <thread>

namespace bindings {

// Calls a function that may take the lock. After the end of the program, Python ends a daemon thread that requests the
// lock. Before 3.14 it uses pthread_exit, which unwinds the stack and aborts in the first noexcept function. Here such
// a thread sleeps until the process is gone, as Python does from 3.14 on.
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
