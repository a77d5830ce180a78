// Newton's step inside the limits, in every lane.
#pragma once

#include "../numeric/definite.hpp"
#include "ranges.hpp"

TWISTARM_BEGIN

/// F(θ + d) ≈ F + gᵀd + ½ dᵀHd, H by its lower triangle.
template <class V, int N> struct quadratic_model {
    V g[capacity(N)], H[triangle_of(capacity(N))];

    /// Takes coordinate i of n out where `held` is: it stays, and pulls at no other.
    template <class Mask> TWISTARM_INLINE void hold(const Mask& held, int i, int n) {
        const V zero = V(scalar_of<V>(0));
        g[i] = select(held, zero, g[i]);
        TWISTARM_UNROLL
        for (int j = 0; j < n; ++j) {
            V& element = H[j < i ? in_triangle(i, j) : in_triangle(j, i)];
            element = select(held, i == j ? V(scalar_of<V>(1)) : zero, element);
        }
    }
};

namespace detail {
/// Takes coordinates that stand at a bound and are pulled outward out of the model.
template <class V, class T, int N>
TWISTARM_INLINE void hold_at_bounds(const ranges<T, N>& range, int n, const V* theta, quadratic_model<V, N>& model) {
    const V zero = V(T(0));
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i)
        if (!range.turns[i])
            model.hold(((theta[i] >= V(range.upper[i])) & (model.g[i] < zero)) |
                           ((theta[i] <= V(range.lower[i])) & (model.g[i] > zero)),
                       i, n);
}

/// The unbounded step, all of it scaled so that no coordinate moves by more than `longest`. Returns what it promises.
template <class V, class T, int N>
TWISTARM_INLINE V unbounded_step(const quadratic_model<V, N>& model, const V& floor, T longest, int n, V* d) {
    quadratic_model<V, N> used;
    for (int i = 0; i < triangle_of(n); ++i) used.H[i] = model.H[i];
    V bound = floor, largest = V(longest);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        TWISTARM_UNROLL
        for (int j = 0; j <= i; ++j) bound = greatest(bound, absolute(used.H[in_triangle(i, j)]));
    }
    const V promise = descent_direction<capacity(N)>(used.H, model.g, floor, bound, n, d);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) largest = greatest(largest, absolute(d[i]));
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) d[i] = d[i] * (longest / largest);
    return promise;
}

/// The step with the coordinates that d takes past a bound stopped at it, and the others solved with that known. A
/// positive decrease that it promises replaces `promise`.
template <class V, class T, int N>
void step_to_bounds(const ranges<T, N>& range, const V* theta, quadratic_model<V, N>& model, const V& floor, T longest,
                    int n, V* d, V& promise) {
    const V zero = V(T(0));
    V room[capacity(N)], other[capacity(N)], pull[capacity(N)], promised = zero;
    for (int i = 0; i < n; ++i) {
        const V there = theta[i] + d[i], inside = clamped(there, V(range.lower[i]), V(range.upper[i]));
        room[i] = range.turns[i] ? zero : select((there < inside) | (there > inside), inside - theta[i], zero);
        pull[i] = model.g[i];
    }
    for (int i = 0; i < n; ++i)
        if (!range.turns[i])
            for (int j = 0; j < n; ++j)
                model.g[j] = model.g[j] + model.H[j < i ? in_triangle(i, j) : in_triangle(j, i)] * room[i];
    for (int i = 0; i < n; ++i) {
        const V there = theta[i] + d[i];
        if (!range.turns[i]) model.hold((there < V(range.lower[i])) | (there > V(range.upper[i])), i, n);
    }
    unbounded_step(model, floor, longest, n, other);
    for (int i = 0; i < n; ++i) {
        other[i] = other[i] + room[i];
        promised = promised - pull[i] * other[i];
    }
    const auto better = promised > zero;
    for (int i = 0; i < n; ++i) d[i] = select(better, other[i], d[i]);
    promise = select(better, promised, promise);
}
}  // namespace detail

/// The downhill step d (n,) from θ by the model, with `shift` added to every curvature and no coordinate longer than
/// `longest` (m, rad). Returns its promise, twice the decrease of the model. Uses the model up.
///
/// Coordinates at a bound that are pulled outward rest. Those that the step takes past a bound will be cut there; with
/// `again`, the rest is solved again with that known.
template <class V, class T, int N>
TWISTARM_INLINE V newton_step(const ranges<T, N>& range, const V* theta, quadratic_model<V, N>& model, const V& shift,
                              T longest, bool again, int n, V* d) {
    if (!range.all_turn) detail::hold_at_bounds(range, n, theta, model);
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) model.H[in_triangle(i, i)] = model.H[in_triangle(i, i)] + shift;
    V promise = detail::unbounded_step(model, shift, longest, n, d);
    if (!again || range.all_turn) return promise;
    auto past = d[0] < d[0];
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i)
        if (!range.turns[i])
            past = past | (theta[i] + d[i] < V(range.lower[i])) | (theta[i] + d[i] > V(range.upper[i]));
    if (any(past)) detail::step_to_bounds(range, theta, model, shift, longest, n, d, promise);
    return promise;
}

TWISTARM_END
