// Nearest configuration to the start, among those that are equally near to a target.
//
// A target beyond the reach leaves joints free: a stretched arm may roll, and a wrist may turn about the held point. An
// arm that follows such a target would jump between these configurations.
#pragma once

#include "branch.hpp"
#include "minima.hpp"
#include "posture.hpp"

TWISTARM_BEGIN

namespace detail {
/// What f₃ = ½ ‖θ − θ₀‖² counts beside the rotation's f while a configuration is drawn to θ₀, and beside nothing.
template <class T> constexpr T departure_beside_rotation = T(1e-2);
template <class T> constexpr T departure_alone = T(1);
/// The first ε, and the weight that draws a configuration to θ₀. f₃ is then dropped, so that the rotation reaches its
/// minimum.
template <class T> constexpr T drawn_from = T(1e-3);
template <class T> constexpr descent_settings<T> drawing = {last_epsilon<T>, T(0), 60, true};
template <class T> constexpr descent_settings<T> letting_go = {last_epsilon<T>, T(0), 20, true};
/// Only starts this near to the target are drawn to θ₀: their f₁ over the least, plus this much [m²].
template <class T> constexpr T drawn_share = T(1.2);
template <class T> constexpr T drawn_excess = T(1e-4);
/// A configuration that is this much farther [rad] than the nearest counts as equally near. Boxes about θ₀ grow by this
/// width.
template <class T> constexpr T as_near = T(1e-4);
template <class T> constexpr T nearest_box_growth = T(3);
/// Two distances [m] with a smaller difference are equal: the position's tolerance, at most the default one.
template <class T> constexpr T usual_tolerance = T(1e-6);
template <class T> T as_far(const search_settings<T>& settings) {
    return least(settings.position_tolerance, usual_tolerance<T>);
}
/// Of the position's tolerance what may be given for the rotation between one minimum and another.
template <class T> constexpr T given_for_rotation = T(0.1);

/// Of the starts that came near, those nearest to θ₀ (n,), at most `most`, nearest first. Returns how many.
template <class T, int N>
int nearest_starts(const ranges<T, N>& range, int n, const field_of_starts<T, N>& field, const T* theta0,
                   T least_position, int most, int* chosen) {
    T departures[most_starts];
    int count = 0;
    for (int i = 0; i < field.count; ++i) {
        if (field.position[i] > drawn_share<T> * least_position + drawn_excess<T>) continue;
        T wrapped[capacity(N)];
        for (int k = 0; k < n; ++k) wrapped[k] = field.theta[i * n + k];
        wrap_near(range, n, theta0, wrapped);
        const T departure = squared_distance(wrapped, theta0, n);
        int at = count < most ? count++ : most;
        for (; at > 0 && departure < departures[at - 1]; --at)
            if (at < most) {
                departures[at] = departures[at - 1];
                chosen[at] = chosen[at - 1];
            }
        if (at == most) continue;
        departures[at] = departure;
        chosen[at] = i;
    }
    return count;
}

/// Draws θ₀ (n,), the best known minimum and the starts nearest to θ₀ to θ₀ along configurations that are equally near:
/// minima of f₁ + ε (f₂ + ν f₃), then without f₃. Limits hold, since a joint past one would come back by a turn.
/// `drawn` has room for one configuration per lane. Returns their number.
template <class V, class T, int N, int M, class Stopped>
int draw_to(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range, const T* theta0,
            const minimum<T, N>& best, const field_of_starts<T, N>& field, Stopped& stopped, minimum<T, N>* drawn) {
    constexpr int lane_count = number<V>::lanes;
    const int n = objective.arm.coordinates();
    const ranges<T, N> held = without_turning(range, n);
    int start[lane_count] = {-1, -2};
    const int count = 2 + nearest_starts(range, n, field, theta0, T(0.5) * best.distance * best.distance,
                                         lane_count - 2, start + 2);
    descent_lanes<V, N> lanes;
    for (int l = 0; l < lane_count; ++l) {
        const T* from = l == 0 || l >= count ? theta0 : l == 1 ? best.at.theta : field.theta + start[l] * n;
        T wrapped[capacity(N)];
        for (int k = 0; k < n; ++k) wrapped[k] = from[k];
        wrap_near(range, n, theta0, wrapped);
        for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], l, wrapped[k]);
    }
    const bool turns = objective.kind != target_kind::position;
    two_levels<V, T, N, M> near_start = objective;
    near_start.near = theta0;
    near_start.nu = turns ? departure_beside_rotation<T> : departure_alone<T>;
    lanes.epsilon = V(drawn_from<T>);
    descend(near_start, held, drawing<T>, lanes, stopped);
    if (turns) descend(objective, held, letting_go<T>, lanes, stopped);
    come_to_rest(objective, held, start, count, lanes, stopped, drawn);
    return count;
}

/// Of the minima (count,) that are as near to the target as the nearest, within the tolerances, the one nearest to θ₀
/// (n,). The minima are wrapped near it.
template <class T, int N, int M>
const minimum<T, N>& nearest_to(const chain<T, N, M>& arm, const ranges<T, N>& range,
                                const search_settings<T>& settings, const target<T>& asked, const T* theta0,
                                minimum<T, N>* minima, int count) {
    constexpr T infinite = static_cast<T>(__builtin_inf());
    T away[3 * most_finalists], angle[3 * most_finalists];
    T least_away = infinite, least_value = infinite, least_departure = infinite;
    for (int i = 0; i < count; ++i) {
        wrap_near(range, arm.coordinates(), theta0, minima[i].at.theta);
        const target_errors<T> errors = errors_at(asked, forward(arm, minima[i].at.theta));
        away[i] = errors.position;
        angle[i] = errors.orientation;
        least_away = least(least_away, away[i]);
    }
    int best = 0;
    for (int i = 0; i < count; ++i) {
        const T value = T(0.5) * away[i] * away[i] + last_epsilon<T> * minima[i].rotation;
        if (away[i] > least_away + given_for_rotation<T> * as_far(settings) || value >= least_value) continue;
        least_value = value;
        best = i;
    }
    const nearest_configuration<T, N> nearest = minima[best].at;
    const T most_angle = angle[best] + least(settings.orientation_tolerance, usual_tolerance<T>);
    for (int i = 0; i < count; ++i) {
        if (away[i] > least_away + as_far(settings) || angle[i] > most_angle) continue;
        if (nearest.position_stationary && !minima[i].at.position_stationary) continue;
        if (nearest.rotation_stationary && !minima[i].at.rotation_stationary) continue;
        const T departure = squared_distance(minima[i].at.theta, theta0, arm.coordinates());
        if (departure >= least_departure) continue;
        least_departure = departure;
        best = i;
    }
    return minima[best];
}
}  // namespace detail

/// Replaces a nearest configuration that is far from θ₀ (n,) by one in a box about θ₀ that is as near to the target,
/// within the position's tolerance and `as_near` of the rotation. Descents from θ₀ and from points of the box search
/// for it.
template <class T, int N, int M, class Stopped>
void keep_near(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, Stopped& stopped, solution<T, N>& found) {
    using V = pack<T, searches_in_group>;
    const int n = arm.coordinates();
    two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked))};
    for (T half = detail::other_branch<T>; half < detail::largest_difference(found.theta, theta0, n) && !stopped();
         half *= detail::nearest_box_growth<T>) {
        const ranges<T, N> box = detail::box_about(range, n, theta0, half);
        descent_lanes<V, N> lanes;
        for (int k = 0; k < n; ++k) lanes.theta[k] = V(theta0[k]);
        for (int l = 1; l < searches_in_group; ++l) {
            T start[capacity(N)];
            random_start(box, n, 0, l, start);
            for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], l, start[k]);
        }
        objective.near = theta0;
        objective.nu = asked.kind != target_kind::position ? detail::departure_beside_rotation<T>
                                                           : detail::departure_alone<T>;
        lanes.epsilon = V(detail::drawn_from<T>);
        descend(objective, box, detail::drawing<T>, lanes, stopped);
        objective.near = nullptr;
        descend(objective, box, detail::letting_go<T>, lanes, stopped);
        const solution<T, N> nearest = found;
        for (int l = 0; l < searches_in_group; ++l) {
            solution<T, N> drawn = nearest;
            for (int k = 0; k < n; ++k) drawn.theta[k] = lane(lanes.theta[k], l);
            judge(arm, box, settings, asked, theta0, drawn);
            if (drawn.position_error <= nearest.position_error + detail::as_far(settings) &&
                drawn.orientation_error <= nearest.orientation_error + detail::as_near<T> &&
                detail::largest_difference(drawn.theta, theta0, n) < detail::largest_difference(found.theta, theta0, n))
                found = drawn;
        }
    }
}

TWISTARM_END
