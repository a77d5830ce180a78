// Minima of the distance to a target, and of the rotation error among them. Several starts descend side by side.
#pragma once

#include "promising.hpp"

TWISTARM_BEGIN

/// A configuration, and whether each of its errors is stationary there inside the limits.
template <class T, int N> struct nearest_configuration {
    T theta[capacity(N)];
    bool position_stationary, rotation_stationary;
};

namespace detail {
/// The final weight of a radian beside a square metre. A smaller weight makes the valley of the position stiffer. This
/// one lengthens the distance by far less than any tolerance.
template <class T> constexpr T last_epsilon = T(sizeof(T) == 8 ? 1e-9 : 1e-5);

/// Every start first descends a little, then the best go on to the last weight. The best of these go to their minima,
/// and the slow ones among them until they converge. At the end the position alone is minimised to rounding, with all
/// that does not move it held.
template <class T> constexpr descent_settings<T> approaching = {T(1e-5), T(0), 10, false};
template <class T> constexpr descent_settings<T> following = {last_epsilon<T>, T(0), 20, true};
template <class T> constexpr descent_settings<T> finishing = {last_epsilon<T>, T(0), 40, true};
template <class T> constexpr descent_settings<T> refining = {last_epsilon<T>, T(0), 120, true};
template <class T> constexpr descent_settings<T> position_alone = {T(0), T(sizeof(T) == 8 ? 1e-9 : 1e-5), 6, true};

/// Two minima with a smaller difference in distance [m] are equally near; the rotation decides.
template <class T> constexpr T same_position = T(sizeof(T) == 8 ? 1e-8 : 1e-5);
/// If the rotation's weight lengthens the distance by less [m], the distance counts as unchanged. In some directions
/// only the fourth derivative holds a stretched arm; so it keeps its rotation there.
template <class T> constexpr T as_short = T(sizeof(T) == 8 ? 1e-9 : 1e-5);
/// A distance [m] below this is zero to the rounding of forward kinematics.
template <class T> constexpr T exact = T(sizeof(T) == 8 ? 1e-11 : 1e-6);
/// A point is stationary if another step promises less distance [m], and less of the rotation's f (about 1e-5 rad).
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
    int start;             ///< by its place in the field; below 0 one that is not of the field
};

/// Whether a is nearer than b.
template <class T, int N> bool is_nearer(const minimum<T, N>& a, const minimum<T, N>& b) {
    if (absolute(a.distance - b.distance) > same_position<T>) return a.distance < b.distance;
    return a.rotation < b.rotation;
}

/// Takes a lane back to its state with a weight on the rotation, if its distance was as short there and is not zero
/// here.
template <class V, int N> void keep_rotation(const descent_lanes<V, N>& weighted, int n, descent_lanes<V, N>& lanes) {
    using T = scalar_of<V>;
    const V distance = sqrt(T(2) * lanes.position);
    const auto back = (sqrt(T(2) * weighted.position) <= distance + as_short<T>) & (distance > V(exact<T>));
    for (int k = 0; k < n; ++k) lanes.theta[k] = select(back, weighted.theta[k], lanes.theta[k]);
    lanes.position = select(back, weighted.position, lanes.position);
    lanes.rotation = select(back, weighted.rotation, lanes.rotation);
}

/// The last of the way: to the least position error, to rounding, and what is known of it. `start` (count,) says where
/// the lanes began.
template <class V, class T, int N, int M, class Stopped>
void come_to_rest(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range, const int* start, int count,
                  descent_lanes<V, N>& lanes, Stopped& stopped, minimum<T, N>* minima) {
    const int n = objective.arm.coordinates();
    const V rotation_promise = lanes.promise / lanes.epsilon;
    const descent_lanes<V, N> weighted = lanes;
    lanes.epsilon = V(T(0));
    descend(objective, range, position_alone<T>, lanes, stopped);
    if (objective.kind != target_kind::position) keep_rotation(weighted, n, lanes);
    const V distance = sqrt(T(2) * lanes.position);
    for (int l = 0; l < count; ++l) {
        minimum<T, N>& now = minima[l];
        now.start = start[l];
        now.distance = lane(distance, l);
        now.rotation = lane(lanes.rotation, l);
        for (int k = 0; k < n; ++k) now.at.theta[k] = lane(lanes.theta[k], l);
        now.at.position_stationary =
            now.distance <= exact<T> || lane(lanes.promise, l) <= stationary<T> * now.distance;
        now.at.rotation_stationary =
            objective.kind == target_kind::position || lane(rotation_promise, l) <= rotation_stationary<T>;
    }
}

/// The starts `which` (count,), no more than there are lanes, to the end.
template <class V, class T, int N, int M, class Stopped>
void finish(const two_levels<V, T, N, M>& objective, const ranges<T, N>& range, const descent_settings<T>& settings,
            const int* which, int count, field_of_starts<T, N>& field, Stopped& stopped, minimum<T, N>* minima) {
    descent_lanes<V, N> lanes;
    gather(field, which, count, objective.arm.coordinates(), lanes);
    descend(objective, range, settings, lanes, stopped);
    scatter(lanes, which, count, objective.arm.coordinates(), field);
    come_to_rest(objective, range, which, count, lanes, stopped, minima);
}

/// The nearest of the minima (count,); of two from one start the later.
template <class T, int N> const minimum<T, N>& nearest_of(const minimum<T, N>* minima, int count) {
    int best = 0;
    for (int i = 1; i < count; ++i)
        if (minima[i].start == minima[best].start || is_nearer(minima[i], minima[best])) best = i;
    return minima[best];
}

/// Writes to `which` the starts that have not converged but may become the nearest, and returns their number.
template <class T, int N> int not_converged(const minimum<T, N>* minima, int count, int* which) {
    const minimum<T, N>& best = nearest_of(minima, count);
    int left = 0;
    for (int i = 0; i < count; ++i) {
        const bool converged = minima[i].at.position_stationary && minima[i].at.rotation_stationary;
        if (!converged && minima[i].distance <= best.distance + same_position<T>) which[left++] = minima[i].start;
    }
    return left;
}
}  // namespace detail

TWISTARM_END
