// The nearest a target can be met: the least position error, and with the position held, the least rotation error.
#pragma once

#include "promising.hpp"
#include "searches.hpp"

TWISTARM_BEGIN

/// A configuration, and whether each of its errors is stationary there inside the limits.
template <class T, int N> struct nearest_configuration {
    T theta[capacity(N)];
    bool position_stationary, rotation_stationary;
};

namespace detail {
/// First every start a little way down; then the best of them, to where a radian counts 1e-9 of a squared metre, and
/// the slow ones among the last to where they settle; in the end the position alone, to rounding, with what does not
/// move it held in place.
template <class T> constexpr descent_settings<T> approaching = {T(1e-5), T(0), 10, false};
template <class T> constexpr descent_settings<T> following = {T(sizeof(T) == 8 ? 1e-9 : 1e-5), T(0), 14, true};
template <class T> constexpr descent_settings<T> finishing = {T(sizeof(T) == 8 ? 1e-9 : 1e-5), T(0), 40, true};
template <class T> constexpr descent_settings<T> settling = {T(sizeof(T) == 8 ? 1e-9 : 1e-5), T(0), 120, true};
template <class T> constexpr descent_settings<T> position_alone = {T(0), T(sizeof(T) == 8 ? 1e-9 : 1e-5), 6, true};

/// Two minima whose distances [m] differ by less are equally near: the rotation decides.
template <class T> constexpr T same_position = T(sizeof(T) == 8 ? 1e-8 : 1e-5);
/// A distance that the rotation's weight makes longer by less [m] is as short as without: so a stretched arm, which the
/// fourth derivative alone holds in some directions, keeps the rotation that it has there.
template <class T> constexpr T as_short = T(sizeof(T) == 8 ? 1e-9 : 1e-5);
/// A distance [m] below this is zero to the rounding of forward kinematics.
template <class T> constexpr T exact = T(sizeof(T) == 8 ? 1e-11 : 1e-6);
/// What another step may promise of distance [m], and of the rotation's f (some 1e-5 rad), where a point is stationary.
template <class T> constexpr T stationary = T(sizeof(T) == 8 ? 1e-9 : 1e-5);
template <class T> constexpr T rotation_stationary = T(sizeof(T) == 8 ? 1e-10 : 1e-3);

/// The starts `which` (count,) some way down. Returns how many had their turn before the time was up.
template <class V, class T, int N, int M, class Stopped>
int follow(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range, const descent_settings<T>& settings,
           const int* which, int count, field_of_starts<T, N>& field, Stopped& stopped) {
    constexpr int lane_count = number<V>::lanes;
    const int n = objective.arm.coordinates();
    for (int first = 0; first < count; first += lane_count) {
        const int left = count - first < lane_count ? count - first : lane_count;
        descent_lanes<V, N> lanes;
        gather(field, which + first, left, n, lanes);
        descend(objective, range, settings, lanes, stopped);
        scatter(lanes, which + first, left, n, field);
        if (stopped()) return first + left;
    }
    return count;
}

/// A minimum and how it was found.
template <class T, int N> struct minimum {
    nearest_configuration<T, N> at;
    T distance, rotation;  ///< [m], and the rotation's f
    int start;
};

/// Whether a is nearer than b.
template <class T, int N> bool is_nearer(const minimum<T, N>& a, const minimum<T, N>& b) {
    if (absolute(a.distance - b.distance) > same_position<T>) return a.distance < b.distance;
    return a.rotation < b.rotation;
}

/// Takes a lane back to where it was with a weight on the rotation, if its distance was as short there, and not zero
/// here.
template <class V, int N> void keep_rotation(const descent_lanes<V, N>& weighted, int n, descent_lanes<V, N>& lanes) {
    using T = scalar_of<V>;
    const V distance = sqrt(T(2) * lanes.position);
    const auto back = (sqrt(T(2) * weighted.position) <= distance + as_short<T>) & (distance > V(exact<T>));
    for (int k = 0; k < n; ++k) lanes.theta[k] = select(back, weighted.theta[k], lanes.theta[k]);
    lanes.position = select(back, weighted.position, lanes.position);
    lanes.rotation = select(back, weighted.rotation, lanes.rotation);
}

/// The starts `which` (count,), no more than there are lanes, to the end.
template <class V, class T, int N, int M, class Stopped>
void finish(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range, const descent_settings<T>& settings,
            const int* which, int count, field_of_starts<T, N>& field, Stopped& stopped, minimum<T, N>* minima) {
    const int n = objective.arm.coordinates();
    descent_lanes<V, N> lanes;
    gather(field, which, count, n, lanes);
    descend(objective, range, settings, lanes, stopped);
    scatter(lanes, which, count, n, field);
    const V rotation_promise = lanes.promise / lanes.epsilon;
    const descent_lanes<V, N> weighted = lanes;
    lanes.epsilon = V(T(0));
    descend(objective, range, position_alone<T>, lanes, stopped);
    keep_rotation(weighted, n, lanes);
    const V distance = sqrt(T(2) * lanes.position);
    for (int l = 0; l < count; ++l) {
        minimum<T, N>& now = minima[l];
        now.start = which[l];
        now.distance = lane(distance, l);
        now.rotation = lane(lanes.rotation, l);
        for (int k = 0; k < n; ++k) now.at.theta[k] = lane(lanes.theta[k], l);
        now.at.position_stationary =
            now.distance <= exact<T> || lane(lanes.promise, l) <= stationary<T> * now.distance;
        now.at.rotation_stationary =
            objective.kind == target_kind::position || lane(rotation_promise, l) <= rotation_stationary<T>;
    }
}

/// The nearest of the minima (count,); of two from one start the later.
template <class T, int N> const minimum<T, N>& nearest_of(const minimum<T, N>* minima, int count) {
    int best = 0;
    for (int i = 1; i < count; ++i)
        if (minima[i].start == minima[best].start || is_nearer(minima[i], minima[best])) best = i;
    return minima[best];
}

/// The starts whose minima are not settled but may come to be the nearest, in `which`. Returns how many they are.
template <class T, int N> int unsettled(const minimum<T, N>* minima, int count, int* which) {
    const minimum<T, N>& best = nearest_of(minima, count);
    int left = 0;
    for (int i = 0; i < count; ++i) {
        const bool settled = minima[i].at.position_stationary && minima[i].at.rotation_stationary;
        if (!settled && minima[i].distance <= best.distance + same_position<T>) which[left++] = minima[i].start;
    }
    return left;
}
}  // namespace detail

/// The best minimum that the starts lead to: the least distance, and among equals the least rotation error.
///
/// `field` holds the starts and is used up. The position is held by a weight that grows until 1e-9 m² stand against a
/// radian, and comes to its own least at the end.
template <class V, class T, int N, int M, class Stopped>
void nearest_from(const chain<T, N, M>& arm, const ranges<T, N>& range, const target<T>& asked,
                  detail::field_of_starts<T, N>& field, Stopped& stopped, nearest_configuration<T, N>& found) {
    static_assert(detail::most_finalists <= number<V>::lanes, "The finalists go side by side.");
    const two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked)),
                                           levels::nearest};
    const int n = arm.coordinates();
    int all[detail::most_starts], chosen[detail::most_followed], last[detail::most_finalists];
    detail::spread_out(range, n, field);
    for (int i = 0; i < field.count; ++i) all[i] = i;
    const int begun = detail::follow(objective, range, detail::approaching<T>, all, field.count, field, stopped);
    const int followed = detail::most_promising(field, all, begun, detail::most_followed, chosen);
    if (!stopped()) detail::follow(objective, range, detail::following<T>, chosen, followed, field, stopped);
    const int count = detail::most_promising(field, chosen, followed, detail::most_finalists, last);
    detail::minimum<T, N> minima[2 * detail::most_finalists];
    detail::finish(objective, range, detail::finishing<T>, last, count, field, stopped, minima);
    found = detail::nearest_of(minima, count).at;
    const int left = detail::unsettled(minima, count, last);
    if (left == 0 || stopped()) return;
    detail::finish(objective, range, detail::settling<T>, last, left, field, stopped, minima + count);
    found = detail::nearest_of(minima, count + left).at;
}

TWISTARM_END
