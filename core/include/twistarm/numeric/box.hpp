// A strictly convex quadratic within bounds: least ½ xᵀ H x − rᵀ x over lower ≤ x ≤ upper.
#pragma once

#include "ldl.hpp"

TWISTARM_BEGIN

/// Which bound each unknown stands at: −1 the lower, 1 the upper, 0 neither.
template <int Capacity> using sides = int[Capacity];

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
}  // namespace detail

/// Moves x within the bounds to the minimum of ½ xᵀ H x − rᵀ x, H positive definite. `at` holds the bounds that x
/// starts and ends at.
///
/// The active-set method: J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §16.5.
template <int Capacity, class T>
void least_in_box(const T (&H)[Capacity][Capacity], const T* r, const T* lower, const T* upper, int n,
                  sides<Capacity>& at, T* x) {
    const T rounding = T(sizeof(T) == 8 ? 1e-10 : 1e-5);
    for (int round = 0; round < 8 * n; ++round) {
        T y[Capacity], share = T(1);
        detail::solve_between(H, r, n, at, x, y);
        int met = -1;
        for (int a = 0; a < n; ++a) {
            if (at[a] != 0 || (y[a] <= upper[a] && y[a] >= lower[a])) continue;
            const T room = (y[a] > upper[a] ? upper[a] : lower[a]) - x[a];
            const T reached = greatest(room / (y[a] - x[a]), T(0));
            if (met < 0 || reached < share) {
                share = reached;
                met = a;
            }
        }
        if (met >= 0) {
            for (int a = 0; a < n; ++a)
                if (at[a] == 0) x[a] = clamped(x[a] + share * (y[a] - x[a]), lower[a], upper[a]);
            at[met] = y[met] > upper[met] ? 1 : -1;
            x[met] = at[met] > 0 ? upper[met] : lower[met];
            continue;
        }
        for (int a = 0; a < n; ++a) x[a] = y[a];
        int released = -1;
        T most = T(0);
        for (int a = 0; a < n; ++a) {
            if (at[a] == 0) continue;
            const T pull = detail::pull_inward(H, r, n, at, x, a) - rounding * absolute(r[a]);
            if (pull > most) {
                most = pull;
                released = a;
            }
        }
        if (released < 0) return;
        at[released] = 0;
    }
}

TWISTARM_END
