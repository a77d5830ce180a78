// Motion limits of joints and motors, and rates from which the arm can always stop inside them.
#pragma once

#include "chain.hpp"

TWISTARM_BEGIN

/// Limits of the rows x = C θ + c: first the motors, then each coordinate. Infinite without a limit.
template <class T, int N> struct motion_limits {
    static constexpr int most_rows = 2 * most_joints;
    int motors, coordinates;
    T C[most_joints][capacity(N)], c[most_joints];
    T lower[most_rows], upper[most_rows], velocity[most_rows], acceleration[most_rows];

    int rows() const { return motors + coordinates; }
    T rate(int row, const T* theta_dot) const {
        if (row >= motors) return theta_dot[row - motors];
        T sum = T(0);
        for (int k = 0; k < coordinates; ++k) sum += C[row][k] * theta_dot[k];
        return sum;
    }
    T place(int row, const T* theta) const { return rate(row, theta) + (row < motors ? c[row] : T(0)); }
};

namespace detail {
/// A slower row stands still: it meets no limit. In a row that others keep at rest, rounding is not a motion.
template <class T> constexpr T still = T(sizeof(T) == 8 ? 1e-12 : 1e-6);

/// What a product of two roundings may be beyond its bound.
template <class T> constexpr T rounded = T(sizeof(T) == 8 ? 1.0 + 1e-9 : 1.0 + 1e-5);

template <class T> constexpr T infinite = static_cast<T>(__builtin_inf());

/// The time until the first row meets a position limit from x + time · x_dot, and that row.
template <class T> struct meeting {
    T time;
    int row;
};

template <class T, int N, class Place, class Rate>
meeting<T> first_hit(const motion_limits<T, N>& limits, const Place& place, const Rate& rate) {
    meeting<T> first{infinite<T>, -1};
    for (int r = 0; r < limits.rows(); ++r) {
        const T v = rate(r), x = place(r);
        if (!(absolute(v) > still<T>)) continue;
        const T time = greatest(v > T(0) ? limits.upper[r] - x : x - limits.lower[r], T(0)) / absolute(v);
        if (time < first.time) first = {time, r};
    }
    return first;
}
}  // namespace detail

/// How long a straight stop from these rates takes [s]: all joints slow in proportion.
template <class T, int N> T stopping_time(const motion_limits<T, N>& limits, const T* theta_dot) {
    T longest = T(0);
    for (int r = 0; r < limits.rows(); ++r)
        longest = greatest(longest, absolute(limits.rate(r, theta_dot)) / limits.acceleration[r]);
    return longest;
}

/// The share of the rates that keeps every velocity limit, 1 at most, and the row that decides.
template <class T, int N> T velocity_share(const motion_limits<T, N>& limits, const T* theta_dot, int& row) {
    T most = T(0);
    row = 0;
    for (int r = 0; r < limits.rows(); ++r) {
        const T used = absolute(limits.rate(r, theta_dot)) / limits.velocity[r];
        if (used > most) {
            most = used;
            row = r;
        }
    }
    return T(1) / greatest(most, T(1));
}

namespace detail {
/// Whether, after dt + T/2 at these rates, every row is inside its position limits or no farther outside than now.
template <class T, int N>
bool is_safe(const motion_limits<T, N>& limits, const T* theta, const T* theta_dot, T dt, T stop) {
    for (int r = 0; r < limits.rows(); ++r) {
        const T x = limits.place(r, theta), v = limits.rate(r, theta_dot), then = x + (dt + T(0.5) * stop) * v;
        if (!(absolute(v) > still<T>)) continue;
        if (!(then <= greatest(limits.upper[r], x) && then >= least(limits.lower[r], x))) return false;
    }
    return true;
}

/// Scales the rates down to the velocity and position limits: s dt + s² T/2 ≤ t, with t the time until a limit. Returns
/// the row of that position limit, −1 for none.
template <class T, int N> int slow_down(const motion_limits<T, N>& limits, const T* theta, T dt, T* rates) {
    const int n = limits.coordinates;
    int row;
    T scale = velocity_share(limits, rates, row);
    const T stop = stopping_time(limits, rates);
    const meeting<T> hit = first_hit<T>(
        limits, [&](int r) { return limits.place(r, theta); }, [&](int r) { return limits.rate(r, rates); });
    const bool ends = scale * (dt + T(0.5) * scale * stop) > hit.time;
    if (ends) scale = T(2) * hit.time / (dt + sqrt(dt * dt + T(2) * stop * hit.time));
    for (int k = 0; k < n; ++k) rates[k] *= scale;
    return ends ? hit.row : -1;
}

/// The speed s nearest to 1 at which the accelerations allow s · rates after `before`; −1 where they allow none.
template <class T, int N>
T speed_in_reach(const motion_limits<T, N>& limits, const T* before, T dt, const T* rates) {
    T slowest = T(0), fastest = infinite<T>;
    for (int r = 0; r < limits.rows(); ++r) {
        const T now = limits.rate(r, before), ahead = limits.rate(r, rates), room = limits.acceleration[r] * dt;
        if (!(absolute(ahead) > still<T>)) {
            if (absolute(now) > room) return T(-1);
            continue;
        }
        slowest = greatest(slowest, now / ahead - room / absolute(ahead));
        fastest = least(fastest, least(now / ahead + room / absolute(ahead), limits.velocity[r] / absolute(ahead)));
    }
    if (slowest > fastest) return T(-1);
    const T speed = least(greatest(T(1), slowest), fastest);
    // Rows that stand still beside the others may not be carried beyond their accelerations by a large speed.
    for (int r = 0; r < limits.rows(); ++r)
        if (absolute(speed * limits.rate(r, rates) - limits.rate(r, before)) > limits.acceleration[r] * dt * rounded<T>)
            return T(-1);
    return speed;
}

/// As much of the rates as is safe, the rest the straight stop from `before`, which is safe; and the limiting row.
///
/// Between two courses no stop takes longer than the longer of theirs. Where the straight stop would not be safe were it to
/// take as long, nothing is mixed in.
template <class T, int N>
int stop_partly(const motion_limits<T, N>& limits, const T* theta, const T* before, T dt, T* rates) {
    const int n = limits.coordinates;
    const T stop = stopping_time(limits, before);
    const T left = stop > dt ? T(1) - dt / stop : T(0);
    T slow[capacity(N)] = {}, change[capacity(N)] = {};
    for (int k = 0; k < n; ++k) {
        slow[k] = left * before[k];
        change[k] = rates[k] - slow[k];
    }
    const T longer = greatest(stopping_time(limits, slow), stopping_time(limits, rates)), time = dt + T(0.5) * longer;
    const meeting<T> hit = first_hit<T>(
        limits, [&](int r) { return limits.place(r, theta) + time * limits.rate(r, slow); },
        [&](int r) { return time * limits.rate(r, change); });
    const T share = is_safe(limits, theta, slow, dt, longer) ? least(hit.time, T(1)) : T(0);
    for (int k = 0; k < n; ++k) rates[k] = slow[k] + share * change[k];
    return hit.row;
}
}  // namespace detail

/// Replaces `rates` by what may be commanded for the next dt after `before`. Returns the row whose position limit slows
/// it, −1 for none.
///
/// The result is the same motion at another speed if that suffices, otherwise as much of the change as the
/// accelerations allow. A motion is safe if the arm could still stop along it. With T the stopping time, no row may
/// meet its position limit within dt + T/2 at its present speed. Slowing by dt/T in each next step keeps this true.
template <class T, int N>
int keep_within(const motion_limits<T, N>& limits, const T* theta, const T* before, T dt, T* rates) {
    const int n = limits.coordinates;
    const int slowed = detail::slow_down(limits, theta, dt, rates);
    T change[capacity(N)] = {};
    for (int k = 0; k < n; ++k) change[k] = rates[k] - before[k];
    const T most = stopping_time(limits, change) / dt;
    if (!(most > T(1))) return slowed;
    const T speed = detail::speed_in_reach(limits, before, dt, rates);
    for (int k = 0; k < n; ++k) rates[k] = speed < T(0) ? before[k] + change[k] / most : speed * rates[k];
    if (detail::is_safe(limits, theta, rates, dt, stopping_time(limits, rates))) return slowed;
    return detail::stop_partly(limits, theta, before, dt, rates);
}

TWISTARM_END
