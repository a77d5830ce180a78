// Engines of one instruction set: a general one, and faster ones for arms with a fixed number of joints.
//
// This file is compiled several times, with different flags and a different TWISTARM_KERNELS. It must not use templates
// of the standard library: the program would share their code under one name, with this file's instructions in it.
#pragma once

#include "kernels.hpp"

#include "twistarm/closed_form/all_solutions.hpp"
#include "twistarm/ik/answer.hpp"
#include "twistarm/ik/batch.hpp"
#include "twistarm/ik/reachable.hpp"
#include "twistarm/ik/reaches.hpp"
#include "twistarm/kinematics/conversion.hpp"

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {
namespace engines {

using namespace bindings;  // its names, hidden by twistarm's where both have one

using general_chain = chain<double, dynamic, dynamic>;
using Reaches = reaches<double, dynamic>;

// -- forward kinematics ----------------------------------------------------------------------------------------------

template <class V> void write_pose(const frame<V>& g, int count, double* poses) {
    for (int l = 0; l < count; ++l, poses += 16) {
        for (int k = 0; k < 3; ++k) {
            poses[4 * k] = lane(g.x[k], l);
            poses[4 * k + 1] = lane(g.y[k], l);
            poses[4 * k + 2] = lane(g.z[k], l);
            poses[4 * k + 3] = lane(g.p[k], l);
            poses[12 + k] = 0.0;
        }
        poses[15] = 1.0;
    }
}

template <class V> void write_column(const column<V>& moved, int i, int n, int count, double* J) {
    for (int l = 0; l < count; ++l, J += 6 * n)
        for (int k = 0; k < 3; ++k) {
            J[k * n + i] = lane(moved.v[k], l);
            J[(k + 3) * n + i] = lane(moved.w[k], l);
        }
}

using some = pack<double, lanes_at_once<double>>;

// A register of configurations side by side; `count` of them are valid. A single one takes the same path, so its bits
// are the same as in a batch.
template <int N>
void several(const chain<double, N, N>& arm, const double* theta, int count, double* poses, double* spatial,
             double* body) {
    const int n = arm.coordinates();
    some x[capacity(N)];
    for (int i = 0; i < n; ++i) {
        x[i] = some(theta[i]);
        for (int l = 1; l < count; ++l) set_lane(x[i], l, theta[l * n + i]);
    }
    column<some> columns[capacity(N)];
    frame<some> g;
    if (body == nullptr && spatial == nullptr) g = forward(arm, x);
    else g = forward_with_columns(arm, x, columns);
    for (int i = 0; body != nullptr && i < n; ++i) write_column(body_column(g, columns[i]), i, n, count, body);
    for (int i = 0; spatial != nullptr && i < n; ++i) write_column(spatial_column(g, columns[i]), i, n, count, spatial);
    if (poses != nullptr) write_pose(g, count, poses);
}

template <int N>
void all(const chain<double, N, N>& arm, const double* theta, std::size_t count, double* poses, double* spatial,
         double* body) {
    constexpr std::size_t width = lanes_at_once<double>;
    const std::size_t n = static_cast<std::size_t>(arm.coordinates());
    for (std::size_t first = 0; first < count; first += width) {
        const int there = static_cast<int>(count - first < width ? count - first : width);
        several(arm, theta + first * n, there, poses != nullptr ? poses + first * 16 : nullptr,
                spatial != nullptr ? spatial + first * 6 * n : nullptr, body != nullptr ? body + first * 6 * n : nullptr);
    }
}

// -- inverse kinematics ----------------------------------------------------------------------------------------------

// An arm as a chain, and the numbers that it is from.
struct Model {
    general_chain arm;
    ArmNumbers numbers;
};

template <int N> ranges<double, N> ranges_from(const chain<double, N, N>& arm, const ArmNumbers& numbers) {
    return ranges_of(arm, numbers.lower, numbers.upper, numbers.start_lower, numbers.start_upper);
}

inline Reaches units_of(const Model& metres) {
    return reaches_of(metres.arm, metres.numbers.lower, metres.numbers.upper, metres.numbers.reach);
}

inline target<double> target_from(int kind, const double* numbers) {
    switch (static_cast<target_kind>(kind)) {
        case target_kind::position: return position_target(numbers);
        case target_kind::approach: return approach_target(numbers, numbers + 3, numbers + 6);
        case target_kind::task:
            return task_target(frame_from_rows<double>(numbers), numbers + 16, numbers[22] != 0.0);
        case target_kind::pose: break;
    }
    return pose_target(frame_from_rows<double>(numbers));
}

// When the time is up, for good.
struct Clock {
    const Query& query;
    bool up = false;
    bool operator()() { return up = up || query.stopped(query.clock); }
};

template <int N, int K> solution<double, K> resized(const solution<double, N>& found, int n) {
    solution<double, K> same;
    for (int k = 0; k < n; ++k) same.theta[k] = found.theta[k];
    same.position_error = found.position_error;
    same.orientation_error = found.orientation_error;
    same.iterations = found.iterations;
    same.restarts = found.restarts;
    same.converged = found.converged;
    same.start_error = found.start_error;
    return same;
}

// What comes after the searches. It is rare, so that one copy for chains of any size does for all.
class Conclusion {
public:
    Conclusion(const general_chain& arm, const ranges<double, dynamic>& range, const Reaches& reaches)
        : arm_(arm), range_(range), reaches_(reaches) {}

    const Reaches& reaches() const { return reaches_; }

    search_settings<double> settings(const Query& query) const {
        search_settings<double> settings;
        settings.position_tolerance = query.position_tolerance / reaches_.metres;
        settings.orientation_tolerance = query.orientation_tolerance;
        settings.searches = query.searches;
        return settings;
    }

    // The answer where `found` is all of it; else what it takes to make it so. `ends` as in `conclude`.
    template <int N>
    void operator()(const Query& query, const Question& question, const ranges<double, N>& within,
                    const solution<double, N>& found, const double* ends, Clock& stopped, Answer& answer) const {
        const int n = arm_.coordinates();
        double theta0[most_joints], start[most_joints] = {};
        reaches_.theta(question.theta0, theta0);
        for (int k = 0; k < n; ++k) start[k] = theta0[k];
        bring_inside(range_, n, start);
        answer.start_moved = false;
        for (int k = 0; k < n; ++k) answer.start_moved = answer.start_moved || start[k] != theta0[k];
        const bool open = is_open(found, within, settings(query), static_cast<target_kind>(query.kind), start, n);
        if (question.posture == nullptr && !open) return copy(found, answer);
        make(query, question, theta0, resized<N, dynamic>(found, n), ends, stopped, answer);
    }

    rotation_split<double> split(int kind, const double* numbers, const double* theta) const;

private:
    void make(const Query& query, const Question& question, const double* theta0,
              const solution<double, dynamic>& found, const double* ends, Clock& stopped, Answer& answer) const;

    template <int N> void copy(const solution<double, N>& found, Answer& answer) const {
        reaches_.back(found.theta, true, answer.theta);
        answer.position_error = found.position_error * reaches_.metres;
        answer.orientation_error = found.orientation_error;
        answer.iterations = found.iterations;
        answer.restarts = found.restarts;
        answer.stop = 0;
        answer.nearest = answer.has_unlimited = answer.other_branch = false;
    }

    const general_chain& arm_;
    const ranges<double, dynamic>& range_;
    const Reaches& reaches_;
};

// Memory for a while.
struct Room {
    explicit Room(std::size_t size) : first(new double[size]) {}
    ~Room() { delete[] first; }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    double* first;
};

// What `solve_batch` asks for and gives back.
template <int N> struct Job {
    const Query& query;
    const Batch& batch;
    const Conclusion& conclusion;
    const ranges<double, N>& range;
    std::size_t begin, end;
    int n;
    Clock clock;
    Room room;

    std::int64_t count() const { return static_cast<std::int64_t>(end - begin); }
    target<double> asked(std::int64_t t) const {
        return conclusion.reaches().asked(target_from(query.kind, question(t).numbers));
    }
    void start(std::int64_t t, double* theta) const { conclusion.reaches().theta(question(t).theta0, theta); }
    std::uint64_t seed(std::int64_t) const { return query.seed; }
    double* ends(int lane) { return room.first + static_cast<std::size_t>(lane * n) * most_ends; }
    void store(std::int64_t t, const solution<double, N>& found, const double* ends) {
        Answer answer;
        conclusion(query, question(t), range, found, ends, clock, answer);
        batch.store(batch.owner, at(t), answer);
    }
    bool goes_on(std::int64_t) const { return batch.goes_on(batch.owner); }

private:
    std::size_t at(std::int64_t t) const { return begin + static_cast<std::size_t>(t); }
    Question question(std::int64_t t) const {
        const Question& first = batch.first;
        return {first.numbers + at(t) * numbers_of_kind[query.kind],
                first.theta0 + at(t) * batch.start_step,
                first.posture != nullptr ? first.posture + at(t) * batch.posture_step : nullptr};
    }
};

template <target_kind Kind, int N>
void solve_targets(const chain<double, N, N>& arm, const ranges<double, N>& range, const Conclusion& conclusion,
                   const Query& query, const Batch& batch, std::size_t begin, std::size_t end) {
    Job<N> job{query, batch, conclusion, range, begin, end, arm.coordinates(), {query},
               Room(static_cast<std::size_t>(lanes_at_once<double> * arm.coordinates()) * most_ends)};
    solve_batch<Kind>(arm, range, conclusion.settings(query), job);
}

// What `find_reachable` asks for and gives back.
struct ChunkJob {
    const Query& query;
    const Chunk& chunk;
    const Reaches& reaches;
    Clock clock;

    std::int64_t count() const { return static_cast<std::int64_t>(chunk.count); }
    target<double> asked(std::int64_t t) const {
        const double* const numbers = chunk.numbers + static_cast<std::size_t>(t) * numbers_of_kind[query.kind];
        return reaches.asked(target_from(query.kind, numbers));
    }
    void store(std::int64_t t, const double* theta) {
        double* const row = chunk.theta + t * reaches.n;
        chunk.converged[t] = theta != nullptr;
        if (theta != nullptr) return reaches.back(theta, true, row);
        for (int k = 0; k < reaches.n; ++k) row[k] = __builtin_nan("");
    }
    bool operator()() { return clock(); }
};

template <target_kind Kind, int N>
void reach_targets(const chain<double, N, N>& arm, const ranges<double, N>& range, const Conclusion& conclusion,
                   const Query& query, const Chunk& chunk) {
    ChunkJob job{query, chunk, conclusion.reaches(), {query}};
    double theta0[most_joints];
    conclusion.reaches().theta(chunk.theta0, theta0);
    find_reachable<Kind>(arm, range, conclusion.settings(query), theta0, query.seed, job);
}

template <target_kind Kind, int N>
void solve_target(const chain<double, N, N>& arm, const ranges<double, N>& range, const Conclusion& conclusion,
                  const Query& query, const Question& question, Answer& answer) {
    solution<double, N> found{};
    double ends[most_ends * capacity(N)], theta0[most_joints];
    Clock clock{query};
    const Reaches& reaches = conclusion.reaches();
    solve_kind<Kind>(arm, range, conclusion.settings(query), reaches.asked(target_from(query.kind, question.numbers)),
                     reaches.theta(question.theta0, theta0), query.seed, found, ends, most_ends, clock);
    conclusion(query, question, range, found, ends, clock, answer);
}

// -- every configuration ---------------------------------------------------------------------------------------------

inline closed_form::joint_axis<double> axis_from(const double* numbers) {
    return {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}, numbers[6] != 0.0};
}

inline solved_arm<double, dynamic> solved_from(const FamilyNumbers& numbers, int n) {
    solved_arm<double, dynamic> solved{};
    fitted_family<double>& family = solved.family;
    family.count = numbers.count;
    family.first = numbers.first;
    family.last = numbers.last;
    family.keeps = static_cast<closed_form::keeps>(numbers.keeps);
    family.kept = {family.keeps == closed_form::keeps::plane, {numbers.kept[0], numbers.kept[1], numbers.kept[2]}, numbers.kept[3]};
    for (int i = 0; i < numbers.count; ++i) {
        family.axes[i] = axis_from(numbers.axes + 7 * i);
        solved.joint[i] = numbers.joint[i];
    }
    solved.held_count = numbers.held_count;
    for (int h = 0; h < numbers.held_count; ++h) {
        solved.held[h] = numbers.held[h];
        solved.held_axes[h] = axis_from(numbers.held_axes + 7 * h);
    }
    for (int k = 0; k < n; ++k) solved.rate[k] = numbers.rate[k];
    solved.home = frame_from_rows<double>(numbers.home);
    solved.idle = numbers.idle;
    return solved;
}

template <target_kind Kind> target_of<double, Kind> target_of_kind(const double* numbers) {
    target_of<double, Kind> asked;
    static_cast<target<double>&>(asked) = target_from(static_cast<int>(Kind), numbers);
    return asked;
}

// The closed form of an arm for one kind of target. Code of its own for a number of joints would gain nothing.
template <target_kind Kind> class ClosedForm final : public ClosedFormEngine {
public:
    ClosedForm(const general_chain& arm, const ranges<double, dynamic>& range, const FamilyNumbers& numbers)
        : arm_(arm), range_(range), solved_(solved_from(numbers, arm.coordinates())) {}

    void solve(const double* numbers, const double* near, const double* held, double position_tolerance,
               double orientation_tolerance, Configurations& found) const override {
        double values[most_joints];
        for (int h = 0; h < solved_.held_count; ++h) {
            const int k = solved_.held[h];
            values[h] = held != nullptr ? held[h] : clamped(near[k], range_.lower[k], range_.upper[k]);
        }
        configurations<double, dynamic> all;
        find_all(arm_, solved_, range_, target_of_kind<Kind>(numbers), near, values, position_tolerance,
                 orientation_tolerance, all);
        write(all, found);
    }

    void verify(const double* numbers, const double* near, const double* rows, std::size_t count,
                double position_tolerance, double orientation_tolerance, Configurations& found) const override {
        const auto n = static_cast<std::size_t>(arm_.coordinates());
        double held[most_joints];
        for (int h = 0; h < solved_.held_count && count != 0; ++h) held[h] = rows[solved_.held[h]];
        std::size_t used = 0;
        const auto next = [&](int, closed_form::candidate_list<double>& some) {
            for (; used < count && some.count < bindings::most_candidates; ++used) {
                closed_form::candidate<double> one{{}, 1};  // As if free to move: Newton's method has time to come from afar.
                for (int i = 0; i < solved_.family.count; ++i)
                    if (const int k = solved_.joint[i]; k >= 0) one.x[i] = rows[used * n + static_cast<std::size_t>(k)] * solved_.rate[k];
                some.add(one);
            }
            return used < count;
        };
        configurations<double, dynamic> all;
        find_among(arm_, solved_, range_, target_of_kind<Kind>(numbers), near, held, position_tolerance,
                   orientation_tolerance, next, all);
        write(all, found);
    }

    int candidates(const double* numbers, const double* near, const double* held, double slack, int nth, unsigned& open,
                   double* rows) const override {
        static_assert(closed_form::most_candidates == bindings::most_candidates, "a list fits into the rows");
        closed_form::candidate_list<double> found;
        closed_form::find_candidates(solved_, target_of_kind<Kind>(numbers), near, held, slack, open, nth, found);
        if (nth + 1 == closed_form::values_tried) open = 0;
        for (const auto& candidate : found) {
            for (int h = 0; h < solved_.held_count; ++h) rows[solved_.held[h]] = held[h];
            for (int i = 0; i < solved_.family.count; ++i)
                if (const int k = solved_.joint[i]; k >= 0) rows[k] = candidate.x[i] / solved_.rate[k];
            rows += arm_.coordinates();
        }
        return found.count;
    }

private:
    void write(const configurations<double, dynamic>& all, Configurations& found) const {
        const int n = arm_.coordinates();
        found.count = all.count;
        found.inside = all.inside;
        found.left = found.families = 0;
        for (int i = 0; i < all.count; ++i) {
            found.families += all.found[i].family;
            found.left += i >= all.inside && all.found[i].family;
            double* const row = found.rows + i * 2 * n;
            found.distance[i] = all.found[i].distance;
            for (int k = 0; k < n; ++k) {
                row[k] = all.found[i].theta[k];
                row[n + k] = (all.found[i].free >> k & 1U) != 0 ? 1.0 : 0.0;
            }
        }
    }

    const general_chain& arm_;
    const ranges<double, dynamic>& range_;
    const solved_arm<double, dynamic> solved_;
};

// -- one arm ---------------------------------------------------------------------------------------------------------

// Any arm.
class GeneralEngine : public Engine {
public:
    GeneralEngine(const Model& metres, const Model& in_reaches);
    void constants(Constants& out) const override;
    void kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                    double* body) const override;
    void solve(const Query& query, const Question& question, Answer& answer) const override;
    void solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const override;
    void find_reachable(const Query& query, const Chunk& chunk) const override;
    void split_rotation(int kind, const double* numbers, const double* theta, double* split) const override;
    ClosedFormEngine* closed_form(const FamilyNumbers& family) const override;

protected:
    const general_chain arm_;
    const ranges<double, dynamic> range_;
    const general_chain scaled_;  // in reaches, for inverse kinematics
    const ranges<double, dynamic> within_;
    const Reaches reaches_;
    const Conclusion conclusion_;
};

// The engine for an arm without coupling whose number of joints has code of its own, or null.
Engine* fixed_engine(const Model& metres, const Model& in_reaches);

}  // namespace engines

using engines::general_chain;
using one_race = pack<double, lanes_at_once<double, searches_in_round>>;

// The searches of an arm of any size: compiled with its engine, and called by what comes after them.
#define TWISTARM_SEARCHES_OF(declared, Kind)                                                                           \
    declared template void run_searches<one_race, Kind>(                                                               \
        const general_chain&, const ranges<double, dynamic>&, const search_settings<double>&,                          \
        lane_searches<one_race, dynamic>&, lane_starts<double, dynamic, number<one_race>::lanes>&,                     \
        search_owner<one_race, double, dynamic>&);                                                                     \
    declared template void polish_as<Kind>(const general_chain&, const ranges<double, dynamic>&,                       \
                                           const search_settings<double>&, const target<double>&, const double*,       \
                                           solution<double, dynamic>&);
#define TWISTARM_SEARCHES(declared)                                                                                    \
    TWISTARM_SEARCHES_OF(declared, target_kind::pose)                                                                  \
    TWISTARM_SEARCHES_OF(declared, target_kind::position)                                                              \
    TWISTARM_SEARCHES_OF(declared, target_kind::approach)                                                              \
    TWISTARM_SEARCHES_OF(declared, target_kind::task)

}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm
