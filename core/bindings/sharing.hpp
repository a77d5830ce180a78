// Work that one thread or several do, until the time is up or somebody has pressed Ctrl-C.
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "clock.hpp"

namespace bindings {

constexpr std::uint64_t most_threads = 256;  // as in ik/batch.py
constexpr std::size_t block = 256;           // targets that a thread takes at once

class SharedWork {
public:
    // `over` is asked in whichever thread works.
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
    // Blocks until there are none.
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

// Does the work with so many threads. They are joined, whatever happens, before this returns; the last hand on the lock is
// that of the caller, who hears Ctrl-C and reports progress (None, or called with what is done and `count`) meanwhile.
void share(SharedWork& work, int threads, std::size_t count, nanobind::handle progress);

}  // namespace bindings
