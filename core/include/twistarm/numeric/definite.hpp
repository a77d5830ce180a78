// A descent direction from a symmetric matrix that need not be positive definite.
#pragma once

#include "lanes.hpp"

TWISTARM_BEGIN

/// The index of element (i, j), j ≤ i, of a symmetric matrix stored as its lower triangle, row by row.
constexpr int in_triangle(int i, int j) { return i * (i + 1) / 2 + j; }
constexpr int triangle_of(int size) { return in_triangle(size, 0); }

/// d = −(H + E)⁻¹ g with H + E = L D Lᵀ positive definite. E is diagonal, and 0 if H is sufficiently definite. Returns
/// −gᵀd ≥ 0: twice the decrease of ½ dᵀ(H + E) d + gᵀd. Overwrites H's lower triangle; n ≤ Capacity.
///
/// Each pivot is at least `floor`, and so large that no element of L √D exceeds √`bound`. So a direction of negative
/// curvature is followed downhill, with a step as for a positive curvature of that size. Source: P. Gill, W. Murray, M.
/// Wright, Practical Optimization, 1981, §4.4.2.2 (without interchanges).
template <int Capacity, class V>
TWISTARM_INLINE V descent_direction(V (&H)[triangle_of(Capacity)], const V* g, const V& floor, const V& bound, int n,
                                    V* d) {
    using T = scalar_of<V>;
    V inverse[Capacity], promise = V(T(0));
    TWISTARM_UNROLL
    for (int j = 0; j < n; ++j) {
        // Column j holds L_ij D_j until its pivot D_j is known. The columns before it are subtracted from H_jj already.
        V longest = V(T(0));
        TWISTARM_UNROLL
        for (int i = j + 1; i < n; ++i) longest = greatest(longest, absolute(H[in_triangle(i, j)]));
        const V pivot = greatest(greatest(absolute(H[in_triangle(j, j)]), longest * longest / bound), floor);
        inverse[j] = T(1) / pivot;
        TWISTARM_UNROLL
        for (int i = j + 1; i < n; ++i) {
            const V factor = H[in_triangle(i, j)] * inverse[j];
            TWISTARM_UNROLL
            for (int k = j + 1; k <= i; ++k)
                H[in_triangle(i, k)] = H[in_triangle(i, k)] - factor * H[in_triangle(k, j)];
        }
        TWISTARM_UNROLL
        for (int i = j + 1; i < n; ++i) H[in_triangle(i, j)] = H[in_triangle(i, j)] * inverse[j];
    }
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        d[i] = -g[i];
        TWISTARM_UNROLL
        for (int k = 0; k < i; ++k) d[i] = d[i] - H[in_triangle(i, k)] * d[k];
    }
    TWISTARM_UNROLL
    for (int i = 0; i < n; ++i) {
        const V scaled = d[i] * inverse[i];
        promise = promise + d[i] * scaled;
        d[i] = scaled;
    }
    TWISTARM_UNROLL
    for (int i = n - 1; i >= 0; --i) {
        TWISTARM_UNROLL
        for (int k = i + 1; k < n; ++k) d[i] = d[i] - H[in_triangle(k, i)] * d[k];
    }
    return promise;
}

TWISTARM_END
