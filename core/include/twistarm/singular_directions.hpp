// Singular value decomposition of a few rows: A = Σ σ u vᵀ.
#pragma once

#include "chain.hpp"

TWISTARM_BEGIN

/// Up to six rows of n numbers.
template <class T, int N> using six_rows = T[6][capacity(N)];

/// One-sided Jacobi rotations: rows ← Xᵀ rows until they are orthogonal; row i is then σ_i v_i and u_i is X's column i.
///
/// Accurate to rounding for small singular values too: M. R. Hestenes, Inversion of matrices by biorthogonalization and
/// related results, J. SIAM 6(1), 1958; J. Demmel & K. Veselić, SIAM J. Matrix Anal. 13(4), 1992.
template <class T, int N> void make_orthogonal(six_rows<T, N>& rows, int count, int n, T X[6][6]) {
    constexpr int most_sweeps = 30;
    const T precise = sizeof(T) == 8 ? T(1e-15) : T(1e-6);
    T size = T(0);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < n; ++k) size += rows[i][k] * rows[i][k];
    const T nothing = size * (sizeof(T) == 8 ? T(1e-24) : T(1e-12));
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) X[i][j] = T(i == j ? 1 : 0);
    bool turned = true;
    for (int sweep = 0; turned && sweep < most_sweeps; ++sweep) {
        turned = false;
        for (int p = 0; p < count; ++p)
            for (int q = p + 1; q < count; ++q) {
                T a = T(0), b = T(0), c = T(0);
                for (int k = 0; k < n; ++k) {
                    a += rows[p][k] * rows[p][k];
                    b += rows[q][k] * rows[q][k];
                    c += rows[p][k] * rows[q][k];
                }
                if (c * c <= precise * precise * a * b || absolute(c) <= nothing) continue;
                turned = true;
                const T zeta = (b - a) / (T(2) * c);
                const T t = (zeta < T(0) ? T(-1) : T(1)) / (absolute(zeta) + sqrt(T(1) + zeta * zeta));
                const T cosine = T(1) / sqrt(T(1) + t * t), sine = cosine * t;
                for (int k = 0; k < n; ++k) {
                    const T row = rows[p][k];
                    rows[p][k] = cosine * row - sine * rows[q][k];
                    rows[q][k] = sine * row + cosine * rows[q][k];
                }
                for (int k = 0; k < count; ++k) {
                    const T column = X[k][p];
                    X[k][p] = cosine * column - sine * X[k][q];
                    X[k][q] = sine * column + cosine * X[k][q];
                }
            }
    }
}

TWISTARM_END
