// Work that one or more threads do until the time is up or the user presses Ctrl-C.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "clock.hpp"

namespace bindings {

constexpr std::size_t block = 256;  // targets that a thread takes at once

class SharedWork {
public:
    // Each working thread calls `over`.
    SharedWork(bool (*over)(const void* clock), const void* clock) : over_(over), clock_(clock) {}
    SharedWork(const SharedWork&) = delete;
    SharedWork& operator=(const SharedWork&) = delete;
    virtual ~SharedWork() = default;

    // One thread's share.
    void run();
    // Waits a little; whether `threads` of them have ended.
    bool ended(int threads);

    bool out_of_memory() const { return out_of_memory_.load(); }
    void stop() { stop_.store(true, std::memory_order_relaxed); }
    std::size_t done() const { return done_.load(std::memory_order_relaxed); }

protected:
    // Takes blocks until none are left.
    virtual void do_blocks() = 0;
    bool stopped() const { return stop_.load(std::memory_order_relaxed) || over_(clock_); }
    void count_done(std::size_t more) { done_.fetch_add(more, std::memory_order_relaxed); }

private:
    bool (*over_)(const void* clock);
    const void* clock_;
    std::atomic<std::size_t> done_{0};
    std::atomic<bool> stop_{false}, out_of_memory_{false};
    std::mutex mutex_;
    std::condition_variable ended_;
    int finished_ = 0;
};

// Does the work with this many threads and joins them before it returns, also after an exception. The caller's thread
// handles Ctrl-C and reports progress: None, or a function of the number done and `count`.
void share(SharedWork& work, int threads, std::size_t count, nanobind::handle progress);

}  // namespace bindings
