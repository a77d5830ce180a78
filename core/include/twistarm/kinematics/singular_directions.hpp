// Singular value decomposition of a few rows: A = Σ σ u vᵀ.
#pragma once

#include "chain.hpp"

TWISTARM_BEGIN

/// Up to six rows of n numbers.
template <class T, int N> using six_rows = T[6][capacity(N)];

/// A lower bound of the smallest of the k = min(count, n) singular values of `count` rows A of n numbers, and at least
/// 1/√k of it: 1/√tr((A Aᵀ)⁻¹) or 1/√tr((Aᵀ A)⁻¹), by L D Lᵀ.
template <class T, int N> T smallest_about(const six_rows<T, N>& rows, int count, int n) {
    const bool wide = count <= n;
    const int k = wide ? count : n, length = wide ? n : count;
    T L[6][6], D[6], trace = T(0);
    for (int i = 0; i < k; ++i)
        for (int j = 0; j <= i; ++j) {
            L[i][j] = T(0);
            for (int m = 0; m < length; ++m) L[i][j] += wide ? rows[i][m] * rows[j][m] : rows[m][i] * rows[m][j];
            for (int m = 0; m < j; ++m) L[i][j] -= L[i][m] * L[j][m] * D[m];
            if (j < i) {
                L[i][j] = L[i][j] / D[j];
                continue;
            }
            D[i] = L[i][i];
            if (!(D[i] > T(0))) return T(0);
        }
    for (int j = 0; j < k; ++j) {
        T y[6];
        for (int i = j; i < k; ++i) {
            y[i] = T(i == j ? 1 : 0);
            for (int m = j; m < i; ++m) y[i] -= L[i][m] * y[m];
            trace += y[i] * y[i] / D[i];
        }
    }
    return T(1) / sqrt(trace);
}

/// One-sided Jacobi rotations: rows ← Xᵀ rows until they are orthogonal. Row i is then σ_i v_i, and u_i is X's column
/// i.
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
    bool rotated = true;
    for (int sweep = 0; rotated && sweep < most_sweeps; ++sweep) {
        rotated = false;
        for (int p = 0; p < count; ++p)
            for (int q = p + 1; q < count; ++q) {
                T a = T(0), b = T(0), c = T(0);
                for (int k = 0; k < n; ++k) {
                    a += rows[p][k] * rows[p][k];
                    b += rows[q][k] * rows[q][k];
                    c += rows[p][k] * rows[q][k];
                }
                if (c * c <= precise * precise * a * b || absolute(c) <= nothing) continue;
                rotated = true;
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
