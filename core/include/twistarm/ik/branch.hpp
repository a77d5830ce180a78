// Branch of solutions on which the arm stands, kept where a target is a small step away.
#pragma once

#include "descent.hpp"
#include "searches.hpp"

TWISTARM_BEGIN

namespace detail {
/// A target this near to the tool at θ₀ [m, rad] is a step of a motion, not a place to jump to.
template <class T> constexpr T near_position = T(0.01);
template <class T> constexpr T near_orientation = T(0.01745329251994329577);
/// An answer that moves a coordinate by more than this [rad, m] for such a step stands on another branch.
template <class T> constexpr T other_branch = T(0.2);
/// Steps so short that a search does not leave the branch on which it begins.
template <class T>
constexpr descent_settings<T> careful = {T(0), T(sizeof(T) == 8 ? 1e-7 : 1e-4), 60, true, T(0.05)};

/// The ranges with every coordinate held to its limits: past them it would come back by a turn.
template <class T, int N> ranges<T, N> without_turning(ranges<T, N> range, int n) {
    for (int k = 0; k < n; ++k) range.turns[k] = false;
    range.all_turn = false;
    return range;
}

template <class T> T largest_difference(const T* a, const T* b, int n) {
    T largest = T(0);
    for (int k = 0; k < n; ++k) largest = greatest(largest, absolute(a[k] - b[k]));
    return largest;
}
}  // namespace detail

/// Whether the nearest configuration to a target lies elsewhere than θ₀ (n,), though the tool is hardly farther from the
/// target at θ₀: within 1 cm of the position, and where the position is met within 1° of the rotation.
template <class T, int N, int M>
bool lies_elsewhere(const chain<T, N, M>& arm, const search_settings<T>& settings, const target<T>& asked,
                    const T* theta0, const solution<T, N>& nearest) {
    if (detail::largest_difference(nearest.theta, theta0, arm.coordinates()) <= detail::other_branch<T>) return false;
    const target_errors<T> errors = errors_at(asked, forward(arm, theta0));
    if (errors.position > nearest.position_error + detail::near_position<T>) return false;
    return nearest.position_error > settings.position_tolerance ||
           errors.orientation <= nearest.orientation_error + detail::near_orientation<T>;
}

/// Brings an answer back to the branch of θ₀ (n,), inside the limits, if the target is near there and the answer is
/// not. Returns whether the answer still stands on another.
template <class T, int N, int M, class Stopped>
bool keep_branch(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                 const target<T>& asked, const T* theta0, Stopped& stopped, solution<T, N>& found) {
    using V = pack<T, searches_in_group>;
    const int n = arm.coordinates();
    if (detail::largest_difference(found.theta, theta0, n) <= detail::other_branch<T>) return false;
    const target_errors<T> errors = errors_at(asked, forward(arm, theta0));
    if (errors.position > detail::near_position<T> || errors.orientation > detail::near_orientation<T>) return false;
    const two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked)), levels::met};
    descent_lanes<V, N> lanes;
    for (int k = 0; k < n; ++k) lanes.theta[k] = V(theta0[k]);
    lanes.epsilon = V(T(0));
    descend(objective, detail::without_turning(range, n), detail::careful<T>, lanes, stopped);
    solution<T, N> moved = found;
    for (int k = 0; k < n; ++k) moved.theta[k] = lane(lanes.theta[k], 0);
    if (judge(arm, range, settings, asked, theta0, moved) && detail::largest_difference(moved.theta, theta0, n) <
                                                                 detail::largest_difference(found.theta, theta0, n))
        found = moved;
    return detail::largest_difference(found.theta, theta0, n) > detail::other_branch<T>;
}

TWISTARM_END
