// Chain.solve_batch: several threads take blocks of targets.
#include <algorithm>
#include <new>

#include "answer.hpp"
#include "chain.hpp"
#include "questions.hpp"
#include "sharing.hpp"

namespace bindings {

namespace {

class BatchWork final : public SharedWork {
public:
    BatchWork(const Engine& engine, const Query& query, const Questions& asked, std::size_t n, char* records)
        : SharedWork(query.stopped, query.clock), engine_(engine), query_(query), asked_(asked), n_(n), records_(records) {
        query_.stopped = [](const void* self) { return static_cast<const BatchWork*>(self)->stopped(); };
        query_.clock = this;
    }

    // Fills the blocks that no thread has begun.
    void ask_the_rest() { ask(std::min(next_.load(), asked_.count), asked_.count); }

private:
    void do_blocks() override {
        Batch targets{asked_.at(0), asked_.theta0.step, asked_.posture.step, nullptr, nullptr, this};
        targets.store = [](void* self, std::size_t t, const Answer& answer) {
            static_cast<BatchWork*>(self)->store(t, answer);
        };
        targets.goes_on = [](void* self) { return !static_cast<BatchWork*>(self)->stopped(); };
        for (;;) {
            const std::size_t begin = next_.fetch_add(block), end = std::min(begin + block, asked_.count);
            if (begin >= asked_.count) return;
            ask(begin, end);
            if (stopped()) return;
            engine_.solve(query_, targets, begin, end);
        }
    }

    void ask(std::size_t begin, std::size_t end) const {
        for (std::size_t t = begin; t < end; ++t) record(t).ask(query_, asked_.at(t), n_);
    }

    Record& record(std::size_t t) const { return *reinterpret_cast<Record*>(records_ + t * Record::size(n_)); }

    void store(std::size_t t, const Answer& answer) {
        record(t).answer(answer, n_);
        count_done(1);
    }

    const Engine& engine_;
    Query query_;
    const Questions& asked_;
    std::size_t n_;
    char* records_;
    std::atomic<std::size_t> next_{0};
};

}  // namespace

bool Chain::solve_batch(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                        nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed,
                        nb::handle max_time, nb::handle posture, nb::handle threads, nb::handle progress,
                        nb::handle records) const {
    Settings settings;
    Questions asked;
    std::uint64_t workers;
    if (!settings.read(kind, position_tolerance, orientation_tolerance, restarts, seed, max_time) ||
        !is_threads(threads, workers) || !(progress.is_none() || PyCallable_Check(progress.ptr())) ||
        !asked.read_targets(numbers, settings.query.kind) || !asked.read_thetas(theta0, n_, asked.theta0) ||
        !is_start(asked.theta0.at(0), asked.theta0.count) ||
        (!posture.is_none() && (!asked.read_thetas(posture, n_, asked.posture) || !Numbers(posture).finite())))
        return false;
    Query& query = settings.query;
    require(NumPy::get().is_array(records) && nb::cast<std::size_t>(records.attr("nbytes")) == asked.count * Record::size(n_),
            "records have another size");
    if (asked.count == 0) return true;
    const int busy = static_cast<int>(std::min<std::size_t>(workers, (asked.count + block - 1) / block));
    const bool alone = busy == 1 && progress.is_none();
    Watch watch(settings.seconds);
    const Deadline deadline(settings.seconds);
    query.stopped = alone ? &Watch::passed : static_cast<bool (*)(const void*)>(&Deadline::passed);
    query.clock = alone ? static_cast<const void*>(&watch) : &deadline;
    BatchWork work(*engine_, query, asked, n_, memory<char>(records));
    if (alone) {
        work.run();
        watch.end();
    } else {
        share(work, busy, asked.count, progress);
    }
    if (work.out_of_memory()) throw std::bad_alloc();
    work.ask_the_rest();
    return true;
}

}  // namespace bindings
