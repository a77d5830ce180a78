// One damped least-squares step in every lane: towards the target, inside the limits.
#pragma once

#include "../numeric/ldl.hpp"
#include "ranges.hpp"
#include "residual.hpp"

TWISTARM_BEGIN

/// What a search is run with. The defaults hold for arms of some decimetres to some metres; a chain of another size is
/// best given in units of its reach.
template <class T> struct search_settings {
    T position_tolerance = T(1e-5), orientation_tolerance = T(5e-5);  ///< greatest errors of an answer [m], [rad]
    bool to_edge = false;           ///< aim at the edge of the tolerances, where no search reached the target itself
    int searches = 100;             ///< in all, the one from theta0 included
    T rotation_weight = T(0.2);     ///< what a squared radian counts beside a squared metre
    T damping = T(0.03);            ///< λ = damping · E + least_damping
    T least_damping = T(sizeof(T) == 8 ? 1e-9 : 1e-6);
    T progress = T(0.8);            ///< an iteration that leaves E above this times the best so far is a stall
    int stalls = 4;                 ///< so many of them end a search
    int iterations = 31;            ///< as do so many iterations
    int head_start = 6;             ///< the search from theta0 wins in so many, whatever the others do
};

namespace detail {
/// d with (JᵀJ + λ I) d = −Jᵀe, for n < K unknowns.
template <class V, int N, int K>
TWISTARM_INLINE void step_by_columns(const residual<V, N, K>& at, const V& lambda, int n, V* d) {
    constexpr int size = N == dynamic || N > K ? K : N;
    V H[size][size] = {}, y[size] = {};
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        TWISTARM_UNROLL
        for (int j = 0; j <= i; ++j) {
            H[i][j] = at.J[i][0] * at.J[j][0];
            TWISTARM_UNROLL
            for (int k = 1; k < K; ++k) H[i][j] = H[i][j] + at.J[i][k] * at.J[j][k];
        }
        H[i][i] = H[i][i] + lambda;
        y[i] = at.J[i][0] * at.e[0];
        TWISTARM_UNROLL
        for (int k = 1; k < K; ++k) y[i] = y[i] + at.J[i][k] * at.e[k];
    }
    solve_ldl(H, y, n);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) d[i] = -y[i];
}

/// The same d = −Jᵀ (JJᵀ + λ I)⁻¹ e, for n ≥ K unknowns.
template <class V, int N, int K>
TWISTARM_INLINE void step_by_rows(const residual<V, N, K>& at, const V& lambda, int n, V* d) {
    V H[K][K] = {}, y[K] = {};
    TWISTARM_UNROLL
    for (int a = 0; a < K; ++a) {
        TWISTARM_UNROLL
        for (int b = 0; b <= a; ++b) {
            H[a][b] = at.J[0][a] * at.J[0][b];
            TWISTARM_UNROLL
            for (int i = 1; i < n; ++i) H[a][b] = H[a][b] + at.J[i][a] * at.J[i][b];
        }
        H[a][a] = H[a][a] + lambda;
        y[a] = at.e[a];
    }
    solve_ldl(H, y, K);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        d[i] = at.J[i][0] * y[0];
        TWISTARM_UNROLL
        for (int k = 1; k < K; ++k) d[i] = d[i] + at.J[i][k] * y[k];
        d[i] = -d[i];
    }
}

/// The unconstrained step, by whichever system is smaller.
template <class V, int N, int K>
TWISTARM_CALLED void free_step(const residual<V, N, K>& at, const V& lambda, int n, V* d) {
    if constexpr (N == dynamic) {
        if (n < K) step_by_columns(at, lambda, n, d);
        else step_by_rows(at, lambda, n, d);
    } else if constexpr (N < K) {
        step_by_columns(at, lambda, N, d);
    } else {
        step_by_rows(at, lambda, N, d);
    }
}

/// Takes coordinates that stand at a bound and are pulled outward (along −Jᵀe) out of the problem. Most stand at none.
template <class V, class T, int N, int K>
TWISTARM_INLINE void freeze_outward(const ranges<T, N>& range, int n, const V* theta, residual<V, N, K>& at) {
    const V zero = V(T(0));
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        if (range.turns[i]) continue;
        const auto above = theta[i] >= V(range.upper[i]), below = theta[i] <= V(range.lower[i]);
        if (!any(above | below)) continue;
        V gradient = at.J[i][0] * at.e[0];
        TWISTARM_UNROLL
        for (int k = 1; k < K; ++k) gradient = gradient + at.J[i][k] * at.e[k];
        const auto frozen = (above & (gradient < zero)) | (below & (gradient > zero));
        TWISTARM_UNROLL
        for (int k = 0; k < K; ++k) at.J[i][k] = select(frozen, zero, at.J[i][k]);
    }
}
}  // namespace detail

/// θ one step further: d minimises ‖J d + e‖² + λ ‖d‖², and θ + d is clamped to the limits. Uses up the residual.
///
/// A coordinate at a bound that is pulled outward is frozen first; one that steps past a bound is cut. Solving again
/// for the others succeeds slightly more often per search, but costs a fifth more in total. Source: S. K. Chan & P. D.
/// Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
template <class V, class T, int N, int K>
TWISTARM_CALLED void bounded_step(const ranges<T, N>& range, const V& lambda, int n, residual<V, N, K>& at, V* theta) {
    V d[capacity(N)];
    if (!range.all_turn) detail::freeze_outward(range, n, theta, at);
    detail::free_step(at, lambda, n, d);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        theta[i] = theta[i] + d[i];
        if (!range.turns[i]) theta[i] = clamped(theta[i], V(range.lower[i]), V(range.upper[i]));
    }
}

TWISTARM_END
