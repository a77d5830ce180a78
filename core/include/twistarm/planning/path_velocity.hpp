// The greatest velocity along a path: x = ṡ² on a grid, with rows a x0 + b x1 ≤ 1 for the ends of each interval.
//
// Two passes. Backwards: the greatest x from which the end can still be reached. Forwards: the greatest next x below
// that. Pham & Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE T-RO
// 34(3) (2018). interval_limits.hpp makes rows that hold on whole intervals.
#pragma once

#include "../numeric/elementary.hpp"

TWISTARM_BEGIN

/// The rows of one interval, `count` of them.
template <class T> struct velocity_rows {
    const T *a, *b;
    int count;
};

namespace detail {
/// Newton's steps to a corner of a convex region; a handful are needed.
constexpr int most_velocity_cuts = 64;

/// The lowest part of x0 that one step goes down to. Anything lower would be the rounding of a start that is much too
/// large.
template <class T> constexpr T longest_velocity_cut = T(sizeof(T) == 8 ? 1e-10 : 1e-4);

/// Every step goes down at least to this part. If a row is nearly vertical, Newton's step is lost in rounding.
template <class T> constexpr T shortest_velocity_cut = T(1) - T(sizeof(T) == 8 ? 1e-13 : 1e-6);

/// A bound of x1 at some x0, and how it changes with x0.
template <class T> struct bound_of_next {
    T value, slope;
};

/// The least upper bound of x1 at x0, at most `end`, and the greatest lower bound, at least 0.
template <class T>
void next_bounds(const velocity_rows<T>& rows, T x0, T end, bound_of_next<T>& upper, bound_of_next<T>& lower) {
    upper = {end, T(0)};
    lower = {T(0), T(0)};
    for (int r = 0; r < rows.count; ++r) {
        const T b = rows.b[r], room = T(1) - rows.a[r] * x0;
        if (b > T(0)) {
            if (room < upper.value * b) upper = {room / b, -rows.a[r] / b};
        } else if (b < T(0)) {
            if (room < lower.value * b) lower = {room / b, -rows.a[r] / b};
        }
    }
}

/// The greatest x0 in [0, most] for which some x1 in [0, end] keeps the rows; x0 = 0 always has one. The interval of x1
/// is concave in x0. From a start that is too large, Newton's method descends to its zero without passing it.
template <class T> T largest_start(const velocity_rows<T>& rows, T end, T most) {
    T x0 = most;
    for (int r = 0; r < rows.count; ++r)
        if (rows.b[r] == T(0) && rows.a[r] * x0 > T(1)) x0 = T(1) / rows.a[r];
    for (int step = 0; step < most_velocity_cuts; ++step) {
        bound_of_next<T> upper, lower;
        next_bounds(rows, x0, end, upper, lower);
        if (upper.value >= lower.value || upper.slope >= lower.slope) break;
        const T newton = x0 + (upper.value - lower.value) / (lower.slope - upper.slope);
        x0 = clamped(newton, longest_velocity_cut<T> * x0, shortest_velocity_cut<T> * x0);
    }
    return x0 > T(0) ? x0 : T(0);
}
}  // namespace detail

/// x at `count` + 1 grid points, 0 at both ends and at most `most`. rows_of(i) are those of interval i.
template <class T, class Rows> void path_velocity(int count, Rows& rows_of, T most, T* x) {
    x[0] = x[count] = T(0);
    for (int i = count - 1; i > 0; --i) x[i] = detail::largest_start(rows_of(i), x[i + 1], most);
    for (int i = 0; i < count; ++i) {
        detail::bound_of_next<T> upper, lower;
        detail::next_bounds(rows_of(i), x[i], x[i + 1], upper, lower);
        x[i + 1] = upper.value > T(0) ? upper.value : T(0);
    }
}

TWISTARM_END
