// Problems of inverse kinematics that have an answer, and the judge of answers: plain forward kinematics.
#pragma once

#include "arms.hpp"
#include "twistarm/ik/ranges.hpp"
#include "twistarm/ik/searches.hpp"

namespace tests {
using twistarm::capacity;
using twistarm::dynamic;
using twistarm::target;
using twistarm::target_kind;

/// A target of a kind that the pose g reaches.
template <class T> target<T> drawn_target(generator& random, target_kind kind, const matrix& g) {
    const auto goal = to_frame<T>(g);
    if (kind == target_kind::pose) return twistarm::pose_target(goal);
    if (kind == target_kind::position) return twistarm::position_target(goal.p);
    if (kind == target_kind::approach) {
        const T axis[3] = {T(0.6), T(0), T(0.8)};
        T direction[3];
        twistarm::rotate(goal, axis, direction);
        return twistarm::approach_target(goal.p, direction, axis);
    }
    T tolerance[6];
    for (T& component : tolerance)
        component = static_cast<T>(random.uniform() < 0.3 ? 0 : (random.uniform() < 0.5 ? 0.02 : INFINITY));
    return twistarm::task_target(goal, tolerance, random.uniform() < 0.5);
}

/// Targets for an arm, each reached by some configuration inside the limits, and where to start.
///
/// Of the coordinates some are bounded on a side or both by less, some by more than a turn, one in five not at all, and
/// one in five has equal limits.
template <class T, int Count> struct problems {
    double lower[most_joints], upper[most_joints], start_lower[most_joints], start_upper[most_joints];
    target<T> asked[Count];
    T theta0[Count * most_joints];
    int n;

    problems(generator& random, const drawn_arm& arm, target_kind kind) : n(arm.coordinates) {
        for (int k = 0; k < n; ++k) draw_limits(random, k);
        for (int t = 0; t < Count; ++t) {
            double theta[most_joints];
            for (int k = 0; k < n; ++k) {
                theta[k] = random.between(start_lower[k], start_upper[k]);
                theta0[t * n + k] = static_cast<T>(random.between(start_lower[k], start_upper[k]));
            }
            asked[t] = drawn_target<T>(random, kind, arm.fk(theta));
        }
    }

    template <int N, int M> twistarm::ranges<T, N> ranges(const twistarm::chain<T, N, M>& arm) const {
        return twistarm::ranges_of(arm, lower, upper, start_lower, start_upper);
    }

private:
    void draw_limits(generator& random, int k) {
        const double kind = random.uniform();
        start_lower[k] = random.uniform() < 0.3 ? -4 : -1.5;
        start_upper[k] = random.uniform() < 0.3 ? 4 : 1.2;
        if (kind < 0.2) start_lower[k] = start_upper[k] = 0.4;
        lower[k] = kind < 0.4 && kind >= 0.2 ? -INFINITY : start_lower[k];
        upper[k] = kind < 0.4 && kind >= 0.3 ? INFINITY : start_upper[k];
    }
};

/// Whether theta lies in the limits, however they were passed on.
template <class T, int Count> bool inside(const problems<T, Count>& given, const T* theta) {
    for (int k = 0; k < given.n; ++k)
        if (!(theta[k] >= static_cast<T>(given.lower[k]) && theta[k] <= static_cast<T>(given.upper[k]))) return false;
    return true;
}

/// What a solution says of itself against plain forward kinematics; `slack` is the rounding between the two.
template <class T, int N, int Count>
void judge(const drawn_arm& arm, const problems<T, Count>& given, int t, const twistarm::solution<T, N>& found,
           double tolerance, double slack) {
    const misses off = missed(given.asked[t], arm.fk(found.theta));
    CHECK(inside(given, found.theta), "target %d leaves the limits", t);
    CHECK(std::fabs(static_cast<double>(off.position) - static_cast<double>(found.position_error)) < slack,
          "target %d: position %g, said %g", t, static_cast<double>(off.position),
          static_cast<double>(found.position_error));
    CHECK(std::fabs(static_cast<double>(off.orientation) - static_cast<double>(found.orientation_error)) < slack,
          "target %d: orientation %g, said %g", t, static_cast<double>(off.orientation),
          static_cast<double>(found.orientation_error));
    if (!found.converged) return;
    CHECK(static_cast<double>(std::fmax(off.position, off.orientation)) <= tolerance + slack,
          "target %d, n = %d: off by %g and %g", t, given.n, static_cast<double>(off.position),
          static_cast<double>(off.orientation));
}
}  // namespace tests
