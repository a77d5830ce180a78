#include "closed_form.hpp"

#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstdlib>
#include <cstdint>
#include <mutex>
#include <new>
#include <utility>
#include <vector>

#include "questions.hpp"
#include "sharing.hpp"

namespace bindings {

namespace {

constexpr std::size_t axis_numbers = 7;

std::vector<int> whole_numbers(const Numbers& values, std::size_t most) {
    std::vector<int> all;
    for (std::size_t i = 0; i < values.size(); ++i) {
        require(values.data()[i] >= -1.0 && values.data()[i] < static_cast<double>(most), "an index is out of range");
        all.push_back(static_cast<int>(values.data()[i]));
    }
    return all;
}

// Tolerances of a call, and whether they are plainly right.
struct Tolerances {
    double position, orientation;
    bool read(nb::handle position_tolerance, nb::handle orientation_tolerance) {
        return tolerance(position_tolerance, position) && tolerance(orientation_tolerance, orientation);
    }
};

// Every configuration of one target for each value of held joints: those inside first, by distance.
class Gathered {
public:
    explicit Gathered(std::size_t n) : n_(n) {}

    void add(const Configurations& found) {
        for (int i = 0; i < found.count; ++i) {
            const std::size_t at = rows_.size() / (2 * n_);
            rows_.insert(rows_.end(), found.rows + static_cast<std::size_t>(i) * 2 * n_,
                         found.rows + static_cast<std::size_t>(i + 1) * 2 * n_);
            (i < found.inside ? inside_ : outside_).push_back({found.distance[i], at});
        }
        hits_ += found.count > 0;
        left_ += found.left;
        families_ += found.families;
    }

    // The answer of `ClosedForm::solve`.
    nb::object result() {
        const nb::object rows = NumPy::get().empty(nb::make_tuple(inside_.size() + outside_.size(), 2, n_));
        double* sorted = memory(rows);
        std::stable_sort(inside_.begin(), inside_.end(), [](const Place& a, const Place& b) { return a.distance < b.distance; });
        for (const auto* places : {&inside_, &outside_})
            for (const Place& place : *places) sorted = std::copy_n(rows_.data() + place.at * 2 * n_, 2 * n_, sorted);
        make_read_only(rows);
        return nb::make_tuple(rows, inside_.size(), hits_, left_, families_);
    }

private:
    struct Place {
        double distance;
        std::size_t at;
    };
    std::size_t n_;
    int hits_ = 0, left_ = 0, families_ = 0;
    std::vector<double> rows_;
    std::vector<Place> inside_, outside_;
};

// Collects rows from blocks that end in any order and keeps the order of the blocks. A batch touches its result once,
// so a copy or fresh pages would cost too much. The buffer has the size that the blocks so far suggest, and is not
// trimmed. The allocator can use a freed buffer for the next batch.
class OrderedRows {
public:
    explicit OrderedRows(std::size_t blocks) : waiting_(blocks), there_(blocks, false) {}
    OrderedRows(const OrderedRows&) = delete;
    OrderedRows& operator=(const OrderedRows&) = delete;
    ~OrderedRows() { std::free(all_); }

    void add(std::size_t block, const std::vector<double>& rows) {
        const std::lock_guard<std::mutex> guard(mutex_);
        if (block != next_) {
            waiting_[block] = rows;
            there_[block] = true;
            return;
        }
        write(rows);
        for (++next_; next_ < there_.size() && there_[next_]; ++next_) write(std::exchange(waiting_[next_], {}));
    }

    // All rows (r, 2, n), in the memory where they are.
    nb::object array(std::size_t n) {
        if (all_ == nullptr) make_room(1);
        const nb::capsule owner(all_, [](void* all) noexcept { std::free(all); });
        double* const all = std::exchange(all_, nullptr);
        return nb::cast(nb::ndarray<nb::numpy, double, nb::ndim<3>>(all, {size_ / (2 * n), 2, n}, owner));
    }

private:
    void write(const std::vector<double>& rows) {
        const std::size_t size = size_ + rows.size();
        if (size > room_) make_room(size * there_.size() / (next_ + 1) * 9 / 8);
        std::copy(rows.begin(), rows.end(), all_ + size_);
        size_ = size;
    }

    void make_room(std::size_t room) {
        double* const larger = static_cast<double*>(std::realloc(all_, room * sizeof(double)));
        if (larger == nullptr) throw std::bad_alloc();
        all_ = larger;
        room_ = room;
    }

    std::mutex mutex_;
    std::vector<std::vector<double>> waiting_;
    std::vector<bool> there_;
    std::size_t next_ = 0, size_ = 0, room_ = 0;
    double* all_ = nullptr;
};

// A batch, in blocks that threads take.
class ConfigurationsWork final : public SharedWork {
public:
    ConfigurationsWork(const ClosedFormEngine& engine, const Questions& asked, const Tolerances& tolerances, std::size_t n,
         bool (*over)(const void* clock), const void* clock)
        : SharedWork(over, clock), engine_(engine), asked_(asked), tolerances_(tolerances), n_(n),
          blocks_((asked.count + block - 1) / block), found_(blocks_), counts_(asked.count), inside_(asked.count), families_(asked.count) {}

    nb::object result() {
        const auto as_array = [&](const std::vector<int>& values) {
            nb::object array = NumPy::get().empty(nb::int_(asked_.count), NumPy::get().whole());
            std::copy(values.begin(), values.end(), memory<std::int64_t>(array));
            return array;
        };
        return nb::make_tuple(found_.array(n_), as_array(counts_), as_array(inside_), as_array(families_));
    }

private:
    void do_blocks() override {
        Configurations found;
        std::vector<double> rows;
        for (std::size_t b; (b = next_.fetch_add(1)) < blocks_;) {
            rows.clear();
            const std::size_t end = std::min((b + 1) * block, asked_.count);
            for (std::size_t t = b * block; t < end && !stopped(); ++t) {
                const Question question = asked_.at(t);
                engine_.solve(question.numbers, question.theta0, nullptr, tolerances_.position, tolerances_.orientation, found);
                rows.insert(rows.end(), found.rows, found.rows + static_cast<std::size_t>(found.count) * 2 * n_);
                counts_[t] = found.count;
                inside_[t] = found.inside;
                families_[t] = found.families;
            }
            found_.add(b, rows);
        }
    }

    const ClosedFormEngine& engine_;
    const Questions& asked_;
    Tolerances tolerances_;
    std::size_t n_;
    const std::size_t blocks_;
    OrderedRows found_;
    std::vector<int> counts_, inside_, families_;
    std::atomic<std::size_t> next_{0};
};

}  // namespace

ClosedForm::ClosedForm(nb::object chain, int kind, int first, int last, int keeps, nb::handle axes, nb::handle joint,
                       nb::handle kept, nb::handle held, nb::handle held_axes, nb::handle rate, nb::handle home,
                       nb::handle idle)
    : chain_(std::move(chain)), kind_(kind) {
    const Chain* const arm = nb::cast<const Chain*>(chain_);
    n_ = arm->n();
    const Numbers lines(axes), which(joint), alone(kept), still(held), held_lines(held_axes), rates(rate), g(home), free(idle);
    require(still.plain() && still.dimensions() == 1 && still.size() <= n_, "held must be float64 (h,)");
    held_count_ = still.size();
    require(lines.plain() && lines.dimensions() == 2 && lines.shape(1) == axis_numbers && lines.shape(0) >= 1 &&
                lines.shape(0) <= 6, "axes must be float64 (k, 7)");
    const std::size_t count = lines.shape(0);
    require(which.is(count) && alone.is(4) && held_lines.is(held_count_, axis_numbers) && rates.is(n_) && g.is(4, 4) &&
                free.is(n_), "an array has another shape");
    require(lines.finite() && alone.finite() && held_lines.finite() && rates.finite() && g.finite(),
            "a family's numbers are finite");
    require(kind >= 0 && kind < 3, "a closed form is of a pose, a position or an approach");
    const int all = static_cast<int>(count);
    require(0 <= first && first < last && last <= all, "a group is a part of the joints");
    require(keeps == 0 ? last - first == all : (keeps == 1 || keeps == 2) && last - first <= 3 && all - (last - first) <= 3,
            "a group has one to three joints, and no more stand beside it");
    const std::vector<int> joints = whole_numbers(which, n_), held_joints = whole_numbers(still, n_);
    std::uint64_t idle_bits = 0;
    for (std::size_t k = 0; k < n_; ++k) {
        if (free.data()[k] != 0.0) idle_bits |= std::uint64_t{1} << k;
        const auto at = static_cast<int>(k);
        require(std::count(joints.begin(), joints.end(), at) + std::count(held_joints.begin(), held_joints.end(), at) == 1,
                "each joint is solved for or held");
        require(rates.data()[k] != 0.0, "a rate is not zero");
    }
    require(std::is_sorted(held_joints.begin(), held_joints.end()), "held joints stand base to tip");
    engine_.reset(arm->engine().closed_form({kind, static_cast<int>(count), first, last, keeps, lines.data(), alone.data(),
                                             joints.data(), static_cast<int>(held_count_), held_joints.data(),
                                             held_lines.data(), rates.data(), g.data(), idle_bits}));
}

nb::object ClosedForm::solve(nb::handle numbers, nb::handle theta0, nb::handle held, nb::handle position_tolerance,
                             nb::handle orientation_tolerance) const {
    const Numbers given_start(theta0), values(held);
    const bool stays = held.is_none();
    Tolerances tolerances;
    double asked[most_numbers], start[most_joints];
    if (!tolerances.read(position_tolerance, orientation_tolerance) || !read_target(numbers, kind_, asked) ||
        !given_start.is(n_) || !is_start(given_start.data(), n_) ||
        !(stays || (values.plain() && values.dimensions() == 2 && values.is(values.shape(0), held_count_) && values.finite())))
        return not_plain();
    given_start.copy_to(start);
    std::vector<double> tried(stays ? 0 : values.size());
    if (!stays) values.copy_to(tried.data());
    const std::size_t tries = stays ? 1 : values.shape(0);
    Gathered all(n_);
    const auto solve_each = [&] {
        Configurations found;
        for (std::size_t i = 0; i < tries; ++i) {
            const double* const at = stays ? nullptr : tried.data() + i * held_count_;
            engine_->solve(asked, start, at, tolerances.position, tolerances.orientation, found);
            all.add(found);
        }
    };
    // One configuration takes less time than the lock.
    stays ? solve_each() : without_lock(solve_each);
    return all.result();
}

nb::object ClosedForm::verify(nb::handle numbers, nb::handle theta0, nb::handle candidates, nb::handle position_tolerance,
                              nb::handle orientation_tolerance) const {
    const Numbers start(theta0), rows(candidates);
    Tolerances tolerances;
    double asked[most_numbers];
    if (!tolerances.read(position_tolerance, orientation_tolerance) || !read_target(numbers, kind_, asked) || !start.is(n_) ||
        !is_start(start.data(), n_) || !rows.plain() || rows.dimensions() != 2 || !rows.is(rows.shape(0), n_) || !rows.finite())
        return not_plain();
    Gathered all(n_);
    Configurations found;
    engine_->verify(asked, start.data(), rows.data(), rows.shape(0), tolerances.position, tolerances.orientation, found);
    all.add(found);
    return all.result();
}

nb::object ClosedForm::candidates(nb::handle numbers, nb::handle theta0, nb::handle held, nb::handle slack) const {
    const Numbers start(theta0), values(held);
    double asked[most_numbers], allowed, list[most_candidates * most_joints];
    if (!read_target(numbers, kind_, asked) || !start.is(n_) || !is_start(start.data(), n_) ||
        !values.is(held_count_) || !real(slack, allowed))
        return not_plain();
    std::vector<double> rows;
    unsigned open = 0;
    for (int nth = 0; nth == 0 || open != 0; ++nth) {
        const int count = engine_->candidates(asked, start.data(), values.data(), allowed, nth, open, list);
        rows.insert(rows.end(), list, list + static_cast<std::size_t>(count) * n_);
    }
    nb::object found = NumPy::get().empty(nb::make_tuple(rows.size() / n_, n_));
    std::copy(rows.begin(), rows.end(), memory(found));
    return found;
}

nb::object ClosedForm::solve_batch(nb::handle numbers, nb::handle theta0, nb::handle position_tolerance,
                                   nb::handle orientation_tolerance, nb::handle threads) const {
    Tolerances tolerances;
    Questions asked;
    std::uint64_t workers;
    if (!tolerances.read(position_tolerance, orientation_tolerance) || !is_threads(threads, workers) ||
        !asked.read_targets(numbers, kind_) || !asked.read_thetas(theta0, n_, asked.theta0) || !is_start(asked.theta0.at(0), asked.theta0.count))
        return not_plain();
    const std::size_t busy = std::min<std::size_t>(workers, (asked.count + block - 1) / block);
    const bool alone = busy <= 1;
    Watch watch(Deadline::none);
    const Deadline never(Deadline::none);
    const auto over = static_cast<bool (*)(const void*)>(&Deadline::passed);
    ConfigurationsWork work(*engine_, asked, tolerances, n_, alone ? &Watch::passed : over,
              alone ? static_cast<const void*>(&watch) : &never);
    if (alone) {
        work.run();
        watch.end();
    } else {
        share(work, static_cast<int>(busy), asked.count, nb::none());
    }
    if (work.out_of_memory()) throw std::bad_alloc();
    return work.result();
}

}  // namespace bindings
