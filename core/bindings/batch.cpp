// Chain.solve_batch: blocks of targets, taken by as many threads as are asked for.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "answer.hpp"
#include "chain.hpp"
#include "clock.hpp"
#include "targets.hpp"

namespace bindings {

namespace {

constexpr std::size_t block = 256;  // enough that lanes left idle at its end do not count
constexpr std::uint64_t most_threads = 256;      // as in ik/batch.py
constexpr std::size_t most_targets = 1000000000;  // more is a mistake

// Numbers for each target, `step` apart, or the same for all; a copy of the caller's.
struct Each {
    std::unique_ptr<double[]> values;
    std::size_t count = 0, step = 0;

    double* make(std::size_t size) {
        values.reset(new double[size]);  // not set to 0 first: a million poses are 128 MB
        count = size;
        return values.get();
    }
    const double* at(std::size_t t) const { return values.get() + t * step; }
};

struct Questions {
    std::size_t count = 0;
    Each numbers, theta0, posture;

    Question at(std::size_t t) const {
        return {numbers.at(t), theta0.at(t), posture.count == 0 ? nullptr : posture.at(t)};
    }
};

// `over` of the query is asked in whichever thread works.
class Work {
public:
    Work(const Engine& engine, const Query& query, const Questions& asked, std::size_t n, double* rows)
        : engine_(engine), query_(query), over_(query.stopped), clock_(query.clock), asked_(asked), n_(n), rows_(rows) {
        query_.stopped = [](const void* self) { return static_cast<const Work*>(self)->stopped(); };
        query_.clock = this;
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

    // Blocks until there are none; one thread's share.
    void run() {
        try {
            solve_blocks();
        } catch (const std::bad_alloc&) {
            out_of_memory_.store(true);
            stop();
        }
        const std::lock_guard<std::mutex> guard(mutex_);
        ++finished_;
        ended_.notify_one();
    }

    // Waits a little; whether `threads` of them have ended.
    bool ended(int threads) {
        std::unique_lock<std::mutex> guard(mutex_);
        return ended_.wait_for(guard, patience, [&] { return finished_ == threads; });
    }

    // What was asked in blocks that nobody has begun.
    void ask_the_rest() { ask(std::min(next_.load(), asked_.count), asked_.count); }

    bool out_of_memory() const { return out_of_memory_.load(); }
    void stop() { stop_.store(true, std::memory_order_relaxed); }
    std::size_t done() const { return done_.load(std::memory_order_relaxed); }

private:
    void solve_blocks() {
        Batch targets{asked_.at(0), asked_.theta0.step, asked_.posture.step, nullptr, nullptr, this};
        targets.store = [](void* self, std::size_t t, const Answer& answer) {
            static_cast<Work*>(self)->store(t, answer);
        };
        targets.goes_on = [](void* self) { return !static_cast<Work*>(self)->stopped(); };
        for (;;) {
            const std::size_t begin = next_.fetch_add(block), end = std::min(begin + block, asked_.count);
            if (begin >= asked_.count) return;
            ask(begin, end);
            if (stopped()) return;
            engine_.solve(query_, targets, begin, end);
        }
    }

    void ask(std::size_t begin, std::size_t end) const {
        for (std::size_t t = begin; t < end; ++t) row(t).ask(query_, asked_.at(t));
    }

    bool stopped() const { return stop_.load(std::memory_order_relaxed) || over_(clock_); }

    Row row(std::size_t t) const { return {rows_ + t * Row::length(query_.kind, n_), n_}; }

    void store(std::size_t t, const Answer& answer) {
        row(t).answer(answer);
        done_.fetch_add(1, std::memory_order_relaxed);
    }

    const Engine& engine_;
    Query query_;
    bool (*over_)(const void* clock);
    const void* clock_;
    const Questions& asked_;
    std::size_t n_;
    double* rows_;
    std::atomic<std::size_t> next_{0}, done_{0};
    std::atomic<bool> stop_{false}, out_of_memory_{false};
    std::mutex mutex_;
    std::condition_variable ended_;
    int finished_ = 0;
};

// Threads that share the work, while the calling one hears Ctrl-C and reports progress. They are joined, whatever
// happens, before this returns; the last hand on the lock is that of the caller.
void share(Work& work, int threads, std::size_t count, nb::handle progress) {
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

// One configuration for all, or one for each.
bool read_thetas(nb::handle given, std::size_t count, std::size_t n, Each& thetas) {
    const std::size_t each[] = {count, n};
    if (row(given, n, thetas.make(n))) return true;
    thetas.step = n;
    return has_axes(given, 2) && numbers(given, each, 2, thetas.make(count * n));
}

bool read_targets(nb::handle given, int kind, Questions& asked) {
    const std::size_t width = numbers_of_kind[kind];
    // Before memory is asked for: whether it is so many of anything at all.
    if (!length(given, asked.count) || asked.count > most_targets || !has_axes(given, kind == 0 ? 3 : 2)) return false;
    const std::size_t poses[] = {asked.count, 4, 4}, others[] = {asked.count, width};
    double* const values = asked.numbers.make(asked.count * width);
    asked.numbers.step = width;
    if (!(kind == 0 ? numbers(given, poses, 3, values) : numbers(given, others, 2, values))) return false;
    for (std::size_t t = 0; t < asked.count; ++t)
        if (!is_target(kind, values + t * width)) return false;
    return true;
}

}  // namespace

nb::object Chain::solve_batch(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                              nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed,
                              nb::handle max_time, nb::handle posture, nb::handle threads, nb::handle progress) const {
    Settings settings;
    Questions asked;
    std::uint64_t workers;
    if (!settings.read(kind, position_tolerance, orientation_tolerance, restarts, seed, max_time) ||
        !whole(threads, workers) || workers < 1 || workers > most_threads ||
        !(progress.is_none() || PyCallable_Check(progress.ptr())) || !read_targets(numbers, settings.query.kind, asked) ||
        !read_thetas(theta0, asked.count, n_, asked.theta0) || !is_start(asked.theta0.at(0), asked.theta0.count) ||
        (!posture.is_none() && (!read_thetas(posture, asked.count, n_, asked.posture) ||
                                !is_finite(asked.posture.at(0), asked.posture.count))))
        return not_plain();
    Query& query = settings.query;
    nb::object rows = NumPy::get().empty(nb::make_tuple(asked.count, Row::length(query.kind, n_)));
    if (asked.count == 0) return rows;
    const int busy = static_cast<int>(std::min<std::size_t>(workers, (asked.count + block - 1) / block));
    const bool alone = busy == 1 && progress.is_none();
    Watch watch(settings.seconds);
    const Deadline deadline(settings.seconds);
    query.stopped = alone ? &Watch::passed : static_cast<bool (*)(const void*)>(&Deadline::passed);
    query.clock = alone ? static_cast<const void*>(&watch) : &deadline;
    Work work(*engine_, query, asked, n_, Array(rows).data());
    if (alone) {
        work.run();
        watch.end();
    } else {
        share(work, busy, asked.count, progress);
    }
    if (work.out_of_memory()) throw std::bad_alloc();
    work.ask_the_rest();
    return rows;
}

}  // namespace bindings
