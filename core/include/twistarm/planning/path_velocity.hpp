// The greatest velocity along a path: x = ṡ² on a grid, with rows a x0 + b x1 ≤ 1 of the values at both ends of every
// interval.
//
// Two passes: backwards the greatest x from which the end can still be reached, forwards the greatest next x that is
// not above it. Pham & Pham, A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis, IEEE
// T-RO 34(3) (2018). Rows that hold on whole intervals are made by interval_limits.hpp.
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

/// No step goes farther down than to this part of x0: what is left would be the rounding of a start much too large.
template <class T> constexpr T longest_velocity_cut = T(sizeof(T) == 8 ? 1e-10 : 1e-4);

/// Every step goes down at least to this part: where a row is nearly upright, Newton's own is lost in rounding.
template <class T> constexpr T shortest_velocity_cut = T(1) - T(sizeof(T) == 8 ? 1e-13 : 1e-6);

/// A bound of x1 at some x0, and how it changes with x0.
template <class T> struct bound_of_next {
    T value, slope;
};

/// The least upper bound of x1 at x0, where it is at most `end`, and the greatest lower one, where it is at least 0.
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

/// The greatest x0 in [0, most] for which some x1 in [0, end] keeps the rows; x0 = 0 has one. The room for x1 is
/// concave in x0: from a start too large Newton's method comes down to its zero without passing it.
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

/// x of `count` + 1 grid points, 0 at both ends and at most `most`; rows_of(i) are those of interval i.
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
