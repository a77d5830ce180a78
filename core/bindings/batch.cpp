// Chain.solve_batch: blocks of targets, taken by as many threads as are asked for.
#include <nanobind/stl/string.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <new>
#include <thread>
#include <vector>

#include "answer.hpp"
#include "chain.hpp"
#include "clock.hpp"

namespace bindings {

namespace {

constexpr std::size_t block = 256;  // enough that lanes left idle at its end do not count
constexpr std::size_t few = 64;     // not worth a thread, if each takes
constexpr int few_searches = 1000;  // no more than these
constexpr auto patience = std::chrono::milliseconds(50);  // between two looks at Ctrl-C

// A row for each target: theta (n), unlimited (n), position error, orientation error, iterations, restarts, stop, flags.
constexpr std::size_t row_length(std::size_t n) { return 2 * n + 6; }
constexpr double not_finished = -1.0;  // in place of a stop, where the time was up before

class Work {
public:
    Work(const Engine& engine, const Query& query, const Batch& targets, std::size_t count, std::size_t n, double* rows)
        : engine_(engine), query_(query), targets_(targets), count_(count), n_(n), rows_(rows), written_(count) {
        targets_.store = [](void* self, std::size_t t, const Answer& answer) {
            static_cast<Work*>(self)->write(t, answer);
        };
        targets_.goes_on = [](void* self) { return !static_cast<Work*>(self)->stopped(); };
        targets_.owner = this;
    }

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

    bool out_of_memory() const { return out_of_memory_.load(); }
    // Marks the rows that nobody has written.
    void mark_unfinished() {
        for (std::size_t t = 0; t < count_; ++t)
            if (!written_[t]) rows_[t * row_length(n_) + 2 * n_ + 4] = not_finished;
    }
    void stop() { stop_.store(true, std::memory_order_relaxed); }
    std::size_t done() const { return done_.load(std::memory_order_relaxed); }

private:
    void solve_blocks() {
        for (;;) {
            const std::size_t begin = next_.fetch_add(block);
            if (begin >= count_ || stopped()) return;
            engine_.solve(query_, targets_, begin, begin + block < count_ ? begin + block : count_);
        }
    }

    bool stopped() const {
        return stop_.load(std::memory_order_relaxed) || query_.stopped(query_.clock);
    }

    void write(std::size_t t, const Answer& answer) {
        double* row = rows_ + t * row_length(n_);
        for (std::size_t k = 0; k < n_; ++k) {
            row[k] = answer.theta[k];
            row[n_ + k] = answer.has_unlimited ? answer.unlimited[k] : 0.0;
        }
        row += 2 * n_;
        row[0] = answer.position_error;
        row[1] = answer.orientation_error;
        row[2] = answer.iterations;
        row[3] = answer.restarts;
        row[4] = answer.stop;
        row[5] = answer.nearest + 2 * answer.has_unlimited + 4 * answer.other_branch + 8 * answer.start_moved;
        written_[t] = 1;
        done_.fetch_add(1, std::memory_order_relaxed);
    }

    const Engine& engine_;
    const Query& query_;
    Batch targets_;
    std::size_t count_, n_;
    double* rows_;
    std::vector<unsigned char> written_;
    std::atomic<std::size_t> next_{0}, done_{0};
    std::atomic<bool> stop_{false}, out_of_memory_{false};
    std::mutex mutex_;
    std::condition_variable ended_;
    int finished_ = 0;
};

// Threads that are joined whatever happens.
class Threads {
public:
    Threads(Work& work, int count) : work_(work) {
        try {
            for (int i = 0; i < count; ++i) threads_.emplace_back([&work] { work.run(); });
        } catch (...) {  // no thread to be had: those that run are joined before this is told
            join();
            throw;
        }
    }
    ~Threads() { join(); }
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;

private:
    void join() {
        work_.stop();
        const nb::gil_scoped_release released;
        for (std::thread& thread : threads_) thread.join();
    }

    Work& work_;
    std::vector<std::thread> threads_;
};

// The calling thread hears Ctrl-C and reports progress while the others work.
void oversee(Work& work, int threads, std::size_t count, nb::handle progress) {
    const Threads running(work, threads);
    for (bool ended = false; !ended;) {
        {
            const nb::gil_scoped_release released;
            ended = work.ended(threads);
        }
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (!progress.is_none()) progress(work.done(), count);
    }
}

bool is_one_or_each(const Numbers& thetas, std::size_t count, std::size_t n) {
    return (thetas.is(n) || thetas.is(count, n)) && thetas.finite();
}

}  // namespace

bool Chain::are_targets(int kind, nb::handle numbers) const {
    const Numbers targets(numbers);
    if (!targets.plain()) return false;
    for (std::size_t at = 0; at < targets.size(); at += numbers_of_kind[kind])
        if (!is_target(kind, targets.data() + at)) return false;
    return true;
}

nb::object Chain::solve_batch(int kind, nb::handle numbers, nb::handle theta0, double position_tolerance,
                              double orientation_tolerance, int restarts, std::uint64_t seed, double max_time,
                              nb::handle posture, int threads, nb::handle progress) const {
    const Numbers targets(numbers), start(theta0), preferred(posture.is_none() ? theta0 : posture);
    const std::size_t count = targets.plain() ? targets.size() / numbers_of_kind[kind] : 0;
    if (!targets.plain() || !is_one_or_each(start, count, n_) || !is_one_or_each(preferred, count, n_))
        return not_plain();
    nb::object rows = NumPy::get().empty(nb::make_tuple(count, row_length(n_)));
    if (count == 0) return rows;
    const Deadline deadline(max_time);
    const Query query{kind, position_tolerance, orientation_tolerance, restarts, seed, &Deadline::passed, &deadline};
    const Question first{targets.data(), start.data(), posture.is_none() ? nullptr : preferred.data()};
    const Batch batch{first, start.is(n_) ? 0 : n_, preferred.is(n_) ? 0 : n_, nullptr, nullptr, nullptr};
    Work work(*engine_, query, batch, count, n_, Numbers(rows).data());
    if (count <= few && restarts <= few_searches && progress.is_none()) {
        const nb::gil_scoped_release released;
        work.run();
    } else {
        const std::size_t blocks = (count + block - 1) / block;
        oversee(work, static_cast<std::size_t>(threads) < blocks ? threads : static_cast<int>(blocks), count, progress);
    }
    if (work.out_of_memory()) throw std::bad_alloc();
    work.mark_unfinished();
    return rows;
}

}  // namespace bindings
