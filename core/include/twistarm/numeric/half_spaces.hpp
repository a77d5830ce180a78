// A strictly convex quadratic within bounds and half-spaces: least ½ xᵀ H x − rᵀ x over lower ≤ x ≤ upper, A x ≤ b.
#pragma once

#include "box.hpp"

TWISTARM_BEGIN

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
/// Of the largest diagonal element: what is added to the system of the multipliers, so that parallel rows share one.
template <class T> constexpr T shared_pull = T(sizeof(T) == 8 ? 1e-9 : 1e-4);

/// The minimum y with the unknowns at no bound and on the rows that are `on`, and the rows' multipliers.
///
/// With y0 = H⁻¹ r and Z = H⁻¹ Aᵀ of the open unknowns: (A Z) μ = A y0 − b, y = y0 − Z μ.
template <int Capacity, class T>
void solve_on(const T (&H)[Capacity][Capacity], const T* r, int n, const half_spaces<T, Capacity>& rows,
              const sides<Capacity>& at, const T* x, T* y, T* multiplier) {
    constexpr int M = most_half_spaces;
    int on[M], count = 0;
    for (int i = 0; i < rows.count; ++i) {
        multiplier[i] = T(0);
        if (rows.on[i]) on[count++] = i;
    }
    solve_between(H, r, n, at, x, y);
    if (count == 0) return;
    T Z[M][Capacity], S[M][M], mu[M], largest = T(0), none[Capacity];
    for (int k = 0; k < n; ++k) none[k] = T(0);
    for (int i = 0; i < count; ++i) {
        solve_between(H, rows.normal[on[i]], n, at, none, Z[i]);
        mu[i] = rows.along(on[i], y, n) - rows.most[on[i]];
    }
    for (int i = 0; i < count; ++i) {
        for (int j = 0; j <= i; ++j) S[i][j] = rows.along(on[i], Z[j], n);
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

/// `least_in_box` with half-spaces, by the same active-set method. Where none of x keeps all, bounds go first.
template <int Capacity, class T>
void least_within(const T (&H)[Capacity][Capacity], const T* r, const T* lower, const T* upper, int n,
                  half_spaces<T, Capacity>& rows, sides<Capacity>& at, T* x) {
    const T rounding = T(sizeof(T) == 8 ? 1e-10 : 1e-5);
    T pull_of[most_half_spaces];
    for (int i = 0; i < rows.count; ++i) rows.on[i] = rows.on[i] || rows.along(i, x, n) > rows.most[i] + rounding;
    for (int round = 0; round < 8 * (n + rows.count); ++round) {
        T y[Capacity], share = T(1);
        detail::solve_on(H, r, n, rows, at, x, y, pull_of);
        int met = -1;  // an unknown, or n and more for a row
        for (int a = 0; a < n; ++a) {
            if (at[a] != 0 || (y[a] <= upper[a] && y[a] >= lower[a])) continue;
            const T room = (y[a] > upper[a] ? upper[a] : lower[a]) - x[a];
            const T reached = greatest(room / (y[a] - x[a]), T(0));
            if (met < 0 || reached < share) {
                share = reached;
                met = a;
            }
        }
        for (int i = 0; i < rows.count; ++i) {
            const T then = rows.along(i, y, n);
            if (rows.on[i] || !(then > rows.most[i] + rounding * (T(1) + absolute(then)))) continue;
            const T now = rows.along(i, x, n), reached = greatest((rows.most[i] - now) / (then - now), T(0));
            if (met < 0 || reached < share) {
                share = reached;
                met = n + i;
            }
        }
        if (met >= 0) {
            for (int a = 0; a < n; ++a)
                if (at[a] == 0) x[a] = clamped(x[a] + share * (y[a] - x[a]), lower[a], upper[a]);
            if (met >= n) {
                rows.on[met - n] = true;
                continue;
            }
            at[met] = y[met] > upper[met] ? 1 : -1;
            x[met] = at[met] > 0 ? upper[met] : lower[met];
            continue;
        }
        for (int a = 0; a < n; ++a) x[a] = y[a];
        int released = -1;
        T most = T(0);
        for (int a = 0; a < n; ++a) {
            if (at[a] == 0) continue;
            T by_rows = T(0);
            for (int i = 0; i < rows.count; ++i) by_rows += pull_of[i] * rows.normal[i][a];
            const T pull = detail::pull_inward(H, r, n, at, x, a) + (at[a] < 0 ? -by_rows : by_rows) -
                           rounding * (absolute(r[a]) + absolute(by_rows));
            if (pull > most) {
                most = pull;
                released = a;
            }
        }
        for (int i = 0; i < rows.count; ++i) {
            if (!rows.on[i]) continue;
            T size = T(0);
            for (int k = 0; k < n; ++k) size = greatest(size, absolute(rows.normal[i][k]));
            const T pull = -pull_of[i] * size - rounding;
            if (pull > most) {
                most = pull;
                released = n + i;
            }
        }
        if (released < 0) return;
        if (released < n) at[released] = 0;
        else rows.on[released - n] = false;
    }
}

TWISTARM_END
