// A strictly convex quadratic within bounds and half-spaces: least ½ xᵀ H x − rᵀ x over lower ≤ x ≤ upper, A x ≤ b.
#pragma once

#include "ldl.hpp"

TWISTARM_BEGIN

/// Which bound each unknown stands at: −1 the lower, 1 the upper, 0 neither.
template <int Capacity> using sides = int[Capacity];

constexpr int most_half_spaces = 16;

/// The rows of A x ≤ b. on: those that x stands at, or is to be moved to because it is beyond.
template <class T, int Capacity> struct half_spaces {
    int count;
    T normal[most_half_spaces][Capacity], most[most_half_spaces];
    bool on[most_half_spaces];

    T along(int row, const T* x, int n) const {
        T sum = T(0);
        for (int k = 0; k < n; ++k) sum += normal[row][k] * x[k];
        return sum;
    }
};

namespace detail {
/// What is added to H's diagonal, of its largest element: so much rounding can take of a pivot.
template <class T> constexpr T pivot_rounding = T(sizeof(T) == 8 ? 1e-15 : 5e-7);

/// Solves H y = r for the unknowns at no bound. The others keep their value: y is x.
template <int Capacity, class T>
void solve_between(const T (&H)[Capacity][Capacity], const T* r, int n, const sides<Capacity>& at, const T* x, T* y) {
    int open[Capacity], count = 0;
    for (int a = 0; a < n; ++a) {
        y[a] = x[a];
        if (at[a] == 0) open[count++] = a;
    }
    T A[Capacity][Capacity], rest[Capacity], largest = T(0);
    for (int i = 0; i < count; ++i) largest = greatest(largest, H[open[i]][open[i]]);
    for (int i = 0; i < count; ++i) {
        rest[i] = r[open[i]];
        for (int b = 0; b < n; ++b)
            if (at[b] != 0) rest[i] -= H[open[i]][b] * x[b];
        for (int j = 0; j <= i; ++j) A[i][j] = H[open[i]][open[j]];
        A[i][i] += pivot_rounding<T> * largest;
    }
    solve_ldl(A, rest, count);
    for (int i = 0; i < count; ++i) y[open[i]] = rest[i];
}

/// How strongly the quadratic pulls the unknown off its bound; negative: it presses against it.
template <int Capacity, class T>
T pull_inward(const T (&H)[Capacity][Capacity], const T* r, int n, const sides<Capacity>& at, const T* x, int a) {
    T slope = -r[a];
    for (int b = 0; b < n; ++b) slope += H[a][b] * x[b];
    return at[a] < 0 ? -slope : slope;
}

/// Of the largest diagonal element: what is added to the system of the multipliers, so that parallel rows share one.
template <class T> constexpr T shared_pull = T(sizeof(T) == 8 ? 1e-9 : 1e-4);

/// The minimum y with the unknowns at no bound and on the rows that are `on`, and the rows' multipliers.
///
/// With y0 = H⁻¹ r and Z = H⁻¹ Aᵀ of the open unknowns: (A Z) μ = A y0 − b, y = y0 − Z μ.
template <int Capacity, class T>
void solve_on(const T (&H)[Capacity][Capacity], const T* r, int n, const half_spaces<T, Capacity>* rows,
              const sides<Capacity>& at, const T* x, T* y, T* multiplier) {
    constexpr int M = most_half_spaces;
    solve_between(H, r, n, at, x, y);
    if (rows == nullptr) return;
    int on[M], count = 0;
    for (int i = 0; i < rows->count; ++i) {
        multiplier[i] = T(0);
        if (rows->on[i]) on[count++] = i;
    }
    if (count == 0) return;
    T Z[M][Capacity], S[M][M], mu[M], largest = T(0), none[Capacity];
    for (int k = 0; k < n; ++k) none[k] = T(0);
    for (int i = 0; i < count; ++i) {
        solve_between(H, rows->normal[on[i]], n, at, none, Z[i]);
        mu[i] = rows->along(on[i], y, n) - rows->most[on[i]];
    }
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j <= i; ++j) S[i][j] = rows->along(on[i], Z[j], n);
        largest = greatest(largest, S[i][i]);
    }
    for (int i = 0; i < count; ++i) S[i][i] += shared_pull<T> * largest + T(1e-30);
    solve_ldl(S, mu, count);
    for (int i = 0; i < count; ++i) {
        multiplier[on[i]] = mu[i];
        for (int k = 0; k < n; ++k) y[k] -= mu[i] * Z[i][k];
    }
}
}  // namespace detail

/// Moves x within the bounds to the minimum of ½ xᵀ H x − rᵀ x, H positive definite. `at` and `rows` hold the bounds and
/// rows that x starts and ends at. Where none of x keeps all, bounds go first.
///
/// The active-set method: J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §16.5.
template <int Capacity, class T>
void least_within(const T (&H)[Capacity][Capacity], const T* r, const T* lower, const T* upper, int n,
                  sides<Capacity>& at, T* x, half_spaces<T, Capacity>* rows = nullptr) {
    const T rounding = T(sizeof(T) == 8 ? 1e-10 : 1e-5);
    const int count = rows == nullptr ? 0 : rows->count;
    T pull_of[most_half_spaces];
    for (int i = 0; i < count; ++i) rows->on[i] = rows->on[i] || rows->along(i, x, n) > rows->most[i] + rounding;
    for (int round = 0; round < 8 * (n + count); ++round) {
        T y[Capacity], share = T(1);
        detail::solve_on(H, r, n, rows, at, x, y, pull_of);
        int blocking = -1;  // an unknown, or n and more for a row
        for (int a = 0; a < n; ++a) {
            if (at[a] != 0 || (y[a] <= upper[a] && y[a] >= lower[a])) continue;
            const T room = (y[a] > upper[a] ? upper[a] : lower[a]) - x[a];
            const T reached = greatest(room / (y[a] - x[a]), T(0));
            if (blocking < 0 || reached < share) {
                share = reached;
                blocking = a;
            }
        }
        for (int i = 0; i < count; ++i) {
            const T then = rows->along(i, y, n);
            if (rows->on[i] || !(then > rows->most[i] + rounding * (T(1) + absolute(then)))) continue;
            const T now = rows->along(i, x, n), reached = greatest((rows->most[i] - now) / (then - now), T(0));
            if (blocking < 0 || reached < share) {
                share = reached;
                blocking = n + i;
            }
        }
        if (blocking >= 0) {
            for (int a = 0; a < n; ++a)
                if (at[a] == 0) x[a] = clamped(x[a] + share * (y[a] - x[a]), lower[a], upper[a]);
            if (blocking < n) {
                at[blocking] = y[blocking] > upper[blocking] ? 1 : -1;
                x[blocking] = at[blocking] > 0 ? upper[blocking] : lower[blocking];
            } else rows->on[blocking - n] = true;
            continue;
        }
        for (int a = 0; a < n; ++a) x[a] = y[a];
        int released = -1;
        T most = T(0);
        for (int a = 0; a < n; ++a) {
            if (at[a] == 0) continue;
            T by_rows = T(0);
            for (int i = 0; i < count; ++i) by_rows += pull_of[i] * rows->normal[i][a];
            const T pull = detail::pull_inward(H, r, n, at, x, a) + (at[a] < 0 ? -by_rows : by_rows) -
                           rounding * (absolute(r[a]) + absolute(by_rows));
            if (pull > most) {
                most = pull;
                released = a;
            }
        }
        for (int i = 0; i < count; ++i) {
            if (!rows->on[i]) continue;
            T size = T(0);
            for (int k = 0; k < n; ++k) size = greatest(size, absolute(rows->normal[i][k]));
            const T pull = -pull_of[i] * size - rounding;
            if (pull > most) {
                most = pull;
                released = n + i;
            }
        }
        if (released < 0) return;
        if (released < n) at[released] = 0;
        else rows->on[released - n] = false;
    }
}

TWISTARM_END
