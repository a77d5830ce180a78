// Branch of solutions on which the arm stands, kept where some configuration near θ₀ meets the target.
#pragma once

#include "unlimited.hpp"

TWISTARM_BEGIN

namespace detail {
/// A target this near to the tool at θ₀ [m, rad] is a step of a motion. Its nearest branch is found.
template <class T> constexpr T near_position = T(0.02);
template <class T> constexpr T near_orientation = T(0.05235987755982988731);
/// An answer that moves a coordinate by more than this [rad, m] is not near θ₀.
template <class T> constexpr T other_branch = T(0.2);
/// The box about θ₀ that is searched grows by this, from `other_branch` on.
template <class T> constexpr T box_growth = T(1.3);
/// Where a first step is longer than this [rad, m], no box about θ₀ of `other_branch` is searched.
template <class T> constexpr T far_step = T(0.5);
/// Added to the λ of that step. Near a singular configuration the target may be reached without the long step that J
/// demands.
template <class T> constexpr T damping_of_first_step = T(5e-3);
/// Iterations and stalls of a search in a box: many coordinates stand at its sides.
constexpr int iterations_in_box = 40, stalls_in_box = 8;
/// Searches in a box wider than the first, which holds as many as there are lanes.
constexpr int starts_in_wide_box = 48;

/// The ranges with every coordinate held to its limits: past them it would come back by a turn.
template <class T, int N> ranges<T, N> without_turning(ranges<T, N> range, int n) {
    for (int k = 0; k < n; ++k) range.turns[k] = false;
    range.all_turn = false;
    return range;
}

/// What of the ranges is no farther than `half` [rad, m] from θ₀ (n,), which lies in them.
template <class T, int N> ranges<T, N> box_about(const ranges<T, N>& range, int n, const T* theta0, T half) {
    ranges<T, N> box = without_turning(range, n);
    for (int k = 0; k < n; ++k) {
        box.periodic[k] = false;
        box.lower[k] = box.start_lower[k] = greatest(range.lower[k], theta0[k] - half);
        box.upper[k] = box.start_upper[k] = least(range.upper[k], theta0[k] + half);
    }
    return box;
}

template <class T> T largest_difference(const T* a, const T* b, int n) {
    T largest = T(0);
    for (int k = 0; k < n; ++k) largest = greatest(largest, absolute(a[k] - b[k]));
    return largest;
}

/// Whether the tool at θ₀ is within a distance [m], an angle [rad] and the tolerances of the target.
template <class T, int N>
bool begins_within(const solution<T, N>& found, const search_settings<T>& settings, target_kind kind, T distance,
                   T angle) {
    distance += settings.position_tolerance;
    angle += settings.orientation_tolerance;
    // A chord is (2 sin(φ/2))² ≤ φ² (1 − φ²/12 + φ⁴/360).
    const T squared = angle * angle;
    const T chord = kind == target_kind::task ? T(1) : T(1) - squared / T(12) + squared * squared / T(360);
    return found.start_error.position <= distance * distance &&
           (angle >= T(3.14159265358979323846) || found.start_error.rotation <= squared * chord);
}

/// Whether a damped step from θ₀ toward the target is so short that the box of `other_branch` about θ₀ may hold an
/// answer.
template <target_kind Kind, class T, int N, int M>
bool may_be_reached_near(const chain<T, N, M>& arm, const search_settings<T>& settings, const target<T>& asked,
                     const T* theta0) {
    const int n = arm.coordinates();
    const aim<T> aims = aim_at(arm, asked);
    frame<T> g;
    column<T> columns[capacity(N)];
    residual<T, N, rows_of(Kind)> at;
    walk_with_columns(arm, aims.base, aims.tip, theta0, g, columns);
    residual_of<Kind, N>(g, columns, n, aims, sqrt(settings.rotation_weight), at);
    T error = at.position_squared + settings.rotation_weight * at.rotation_squared, d[capacity(N)];
    if (settings.to_edge) error = allow_tolerances<Kind>(settings, at, n);
    free_step(at, settings.damping * error + damping_of_first_step<T>, n, d);
    T longest = T(0);
    for (int k = 0; k < n; ++k) longest = greatest(longest, absolute(d[k]));
    return longest <= far_step<T>;
}

/// The configuration nearest to θ₀ (n,) that searches find in the box of this half width, from θ₀ and from points of
/// the box. Returns false for none.
template <class T, int N, int M, class Stopped>
bool meet_in_box(const chain<T, N, M>& arm, const ranges<T, N>& range, search_settings<T> settings,
                 const target<T>& asked, const T* theta0, T half, Stopped& stopped, solution<T, N>& found) {
    const int n = arm.coordinates();
    const ranges<T, N> box = box_about(range, n, theta0, half);
    settings.iterations = iterations_in_box;
    settings.stalls = stalls_in_box;
    if (!settings.to_edge) {  // only what meets the target itself, as the answer does
        settings.position_tolerance = least(settings.position_tolerance, exact_error<T>);
        settings.orientation_tolerance = least(settings.orientation_tolerance, exact_error<T>);
    }
    searched<T, N> set;
    set.count = half > other_branch<T> ? starts_in_wide_box : searches_in_group;
    for (int k = 0; k < n; ++k) set.theta[k] = theta0[k];
    for (int i = 1; i < set.count; ++i) random_start(box, n, 0, i, set.theta + i * n);
    const int count = search_from_each(arm, box, settings, asked, searches_in_group, stopped, set);
    solution<T, N> best = found, next = found;
    T least_difference = static_cast<T>(__builtin_inf());
    for (int r = 0; r < count; ++r) {
        for (int k = 0; k < n; ++k) next.theta[k] = set.theta[r * n + k];
        if (!judge(arm, box, settings, asked, theta0, next)) continue;
        const T difference = largest_difference(next.theta, theta0, n);
        if (difference >= least_difference) continue;
        least_difference = difference;
        best = next;
    }
    if (!settings.to_edge && best.converged) polish(arm, box, settings, asked, theta0, best);
    if (least_difference < largest_difference(found.theta, theta0, n)) found = best;
    return count > 0;
}
}  // namespace detail

/// Whether the target is near the tool at θ₀ (n,) although its nearest configuration is elsewhere. Near means within 2
/// cm of the position and, if the position is reached, within 3° of the rotation.
template <class T, int N, int M>
bool lies_elsewhere(const chain<T, N, M>& arm, const search_settings<T>& settings, const target<T>& asked,
                    const T* theta0, const solution<T, N>& nearest) {
    if (detail::largest_difference(nearest.theta, theta0, arm.coordinates()) <= detail::other_branch<T>) return false;
    const target_errors<T> errors = errors_at(asked, forward(arm, theta0));
    if (errors.position > nearest.position_error + detail::near_position<T>) return false;
    return nearest.position_error > settings.position_tolerance ||
           errors.orientation <= nearest.orientation_error + detail::near_orientation<T>;
}

/// Moves an answer that is not near θ₀ (n,), which is inside the limits, to a configuration near θ₀ that meets the
/// target, if there is one. For a target near the tool at θ₀, it searches growing boxes up to the answer for the
/// nearest branch. Returns whether the target is near and the answer is not.
template <class T, int N, int M, class Stopped>
bool keep_branch(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                 const target<T>& asked, const T* theta0, Stopped& stopped, solution<T, N>& found) {
    const int n = arm.coordinates();
    if (detail::largest_difference(found.theta, theta0, n) <= detail::other_branch<T>) return false;
    const bool near = detail::begins_within(found, settings, asked.kind, detail::near_position<T>,
                                            detail::near_orientation<T>);
    bool may_be = near;
    with_kind(asked, [&](auto kind) {
        may_be = may_be || detail::may_be_reached_near<kind()>(arm, settings, asked, theta0);
    });
    if (!may_be) return false;
    T half = detail::other_branch<T>;
    while (!detail::meet_in_box(arm, range, settings, asked, theta0, half, stopped, found) && near && !stopped()) {
        half *= detail::box_growth<T>;
        if (half >= detail::largest_difference(found.theta, theta0, n)) break;
    }
    return near && detail::largest_difference(found.theta, theta0, n) > detail::other_branch<T>;
}

TWISTARM_END
