// Chain.reachable: several threads take chunks of targets.
#include <algorithm>
#include <new>
#include <vector>

#include "chain.hpp"
#include "questions.hpp"
#include "sharing.hpp"

namespace bindings {

namespace {

class ReachableWork final : public SharedWork {
public:
    ReachableWork(const Engine& engine, const Query& query, const Questions& asked, std::size_t n,
         const std::vector<std::size_t>& chunks, bool* converged, double* theta)
        : SharedWork(query.stopped, query.clock), engine_(engine), query_(query), asked_(asked), n_(n), chunks_(chunks),
          converged_(converged), theta_(theta) {
        query_.stopped = [](const void* self) { return static_cast<const ReachableWork*>(self)->stopped(); };
        query_.clock = this;
    }

private:
    void do_blocks() override {
        for (std::size_t c; (c = next_.fetch_add(1)) + 1 < chunks_.size() && !stopped();) {
            const std::size_t begin = chunks_[c], count = chunks_[c + 1] - begin;
            const Question first = asked_.at(begin);
            engine_.find_reachable(query_, {first.numbers, first.theta0, count, converged_ + begin, theta_ + begin * n_});
            count_done(count);
        }
    }

    const Engine& engine_;
    Query query_;
    const Questions& asked_;
    std::size_t n_;
    const std::vector<std::size_t>& chunks_;
    bool* converged_;
    double* theta_;
    std::atomic<std::size_t> next_{0};
};

// Where each chunk of `count` targets begins, and the end. False for what is not plainly right.
bool read_chunks(nb::handle given, std::size_t count, std::vector<std::size_t>& chunks) {
    const Numbers begins(given);
    if (!begins.plain() || begins.dimensions() != 1 || begins.size() == 0) return false;
    for (std::size_t i = 0; i < begins.size(); ++i) {
        const double at = begins.data()[i];
        if (!(at >= 0.0 && at <= static_cast<double>(count))) return false;
        chunks.push_back(static_cast<std::size_t>(at));
    }
    return std::is_sorted(chunks.begin(), chunks.end()) && chunks.front() == 0 && chunks.back() == count;
}

}  // namespace

nb::object Chain::reachable(nb::handle kind, nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                            nb::handle orientation_tolerance, nb::handle restarts, nb::handle seed, nb::handle chunks,
                            nb::handle threads, nb::handle progress) const {
    Settings settings;
    Questions asked;
    std::vector<std::size_t> begins;
    std::uint64_t workers;
    if (!settings.read(kind, position_tolerance, orientation_tolerance, restarts, seed, nb::none()) ||
        !is_threads(threads, workers) || !(progress.is_none() || PyCallable_Check(progress.ptr())) ||
        !asked.read_targets(numbers, settings.query.kind) || !Numbers(theta0).is(n_) ||
        !asked.read_thetas(theta0, n_, asked.theta0) || !is_start(asked.theta0.at(0), n_) ||
        !read_chunks(chunks, asked.count, begins))
        return not_plain();
    const nb::object converged = NumPy::get().empty(nb::int_(asked.count), NumPy::get().truth());
    const nb::object theta = NumPy::get().empty(nb::make_tuple(asked.count, n_));
    if (asked.count > 0) {
        const Deadline never(Deadline::none);
        settings.query.stopped = &Deadline::passed;
        settings.query.clock = &never;
        ReachableWork work(*engine_, settings.query, asked, n_, begins, memory<bool>(converged), memory(theta));
        share(work, static_cast<int>(std::min<std::size_t>(workers, begins.size() - 1)), asked.count, progress);
        if (work.out_of_memory()) throw std::bad_alloc();
    }
    return nb::make_tuple(converged, theta);
}

}  // namespace bindings
