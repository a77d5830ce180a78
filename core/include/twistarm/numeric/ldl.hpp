// Symmetric positive definite systems of a few unknowns, one per lane, without a square root.
#pragma once

#include "lanes.hpp"

TWISTARM_BEGIN

/// Solves H y = r for `size` ≤ Capacity unknowns with H = L D Lᵀ. On entry y holds r, and H its lower triangle. Source:
/// G. Golub & C. Van Loan, Matrix Computations, 4th ed., §4.1.2.
template <int Capacity, class V> TWISTARM_INLINE void solve_ldl(V (&H)[Capacity][Capacity], V (&y)[Capacity], int size) {
    TWISTARM_UNROLL
    for (int i = 0; i < size; ++i) {
        // Row i holds L_ij D_j until its pivot D_i is known. The diagonal then holds the inverse of the pivot.
        TWISTARM_UNROLL
        for (int j = 0; j < i; ++j) {
            TWISTARM_UNROLL
            for (int k = 0; k < j; ++k) H[i][j] = H[i][j] - H[i][k] * H[j][k];
        }
        TWISTARM_UNROLL
        for (int k = 0; k < i; ++k) {
            const V factor = H[i][k] * H[k][k];
            H[i][i] = H[i][i] - factor * H[i][k];
            H[i][k] = factor;
            y[i] = y[i] - factor * y[k];
        }
        H[i][i] = scalar_of<V>(1) / H[i][i];
    }
    TWISTARM_UNROLL
    for (int i = 0; i < size; ++i) y[i] = y[i] * H[i][i];
    TWISTARM_UNROLL
    for (int i = size - 1; i >= 0; --i) {
        TWISTARM_UNROLL
        for (int k = i + 1; k < size; ++k) y[i] = y[i] - H[k][i] * y[k];
    }
}

/// The trace of H⁻¹ = L⁻ᵀ D⁻¹ L⁻¹, with H as solve_ldl leaves it. It is between the inverse of H's least eigenvalue and
/// `size` times that.
template <int Capacity, class V> TWISTARM_INLINE V trace_of_inverse(const V (&H)[Capacity][Capacity], int size) {
    V trace = V(scalar_of<V>(0)), z[Capacity];
    TWISTARM_UNROLL
    for (int j = 0; j < size; ++j) {
        trace = trace + H[j][j];
        TWISTARM_UNROLL
        for (int i = j + 1; i < size; ++i) {
            z[i] = -H[i][j];
            TWISTARM_UNROLL
            for (int k = j + 1; k < i; ++k) z[i] = z[i] - H[i][k] * z[k];
            trace = trace + z[i] * z[i] * H[i][i];
        }
    }
    return trace;
}

TWISTARM_END
