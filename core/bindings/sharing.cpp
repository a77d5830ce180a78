#include "sharing.hpp"

#include <new>
#include <thread>
#include <vector>

namespace bindings {

namespace nb = nanobind;

void SharedWork::run() {
    try {
        do_blocks();
    } catch (const std::bad_alloc&) {
        out_of_memory_.store(true);
        stop();
    }
    const std::lock_guard<std::mutex> guard(mutex_);
    ++finished_;
    ended_.notify_one();
}

bool SharedWork::ended(int threads) {
    std::unique_lock<std::mutex> guard(mutex_);
    return ended_.wait_for(guard, patience, [&] { return finished_ == threads; });
}

void share(SharedWork& work, int threads, std::size_t count, nb::handle progress) {
    std::vector<std::thread> running;
    const auto join = [&] {
        work.stop();
        without_lock([&] {
            for (std::thread& thread : running) thread.join();
        });
    };
    try {
        for (int i = 0; i < threads; ++i) running.emplace_back([&work] { work.run(); });
        for (bool ended = false; !ended;) {
            without_lock([&] { ended = work.ended(threads); });
            if (called([] { return PyErr_CheckSignals() != 0; })) throw nb::python_error();
            if (!progress.is_none()) called([&] { progress(work.done(), count); });
        }
    } catch (...) {
        join();
        throw;
    }
    join();
}

}  // namespace bindings
