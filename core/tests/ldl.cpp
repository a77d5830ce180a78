// Symmetric positive definite systems: what is left when the solution is put back.
#include "twistarm/numeric/ldl.hpp"

#include "check.hpp"
#include "plain.hpp"

using namespace twistarm;

namespace {
/// The trace of H⁻¹, by Gauss and Jordan's elimination.
template <int Capacity> double inverse_trace(const double (&H)[Capacity][Capacity], int size) {
    tests::real rows[Capacity][2 * Capacity] = {}, trace = 0;
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j) rows[i][j] = static_cast<tests::real>(H[i][j]);
        rows[i][size + i] = 1;
    }
    for (int p = 0; p < size; ++p) {
        const tests::real pivot = rows[p][p];
        for (int j = 0; j < 2 * size; ++j) rows[p][j] /= pivot;
        for (int i = 0; i < size; ++i) {
            const tests::real share = rows[i][p];
            for (int j = 0; j < 2 * size && i != p; ++j) rows[i][j] -= share * rows[p][j];
        }
    }
    for (int i = 0; i < size; ++i) trace += rows[i][size + i];
    return static_cast<double>(trace);
}

/// H = B Bᵀ + λ I with B of `columns` columns, so that its condition is set by λ.
template <class T, int Capacity> void test_size(tests::generator& random, int size, double lambda, double tolerance) {
    using V = pack<T, 8>;
    V H[Capacity][Capacity] = {}, y[Capacity] = {};
    double kept[8][Capacity][Capacity], right[8][Capacity];
    for (int l = 0; l < 8; ++l) {
        double B[Capacity][Capacity];
        for (int i = 0; i < size; ++i)
            for (int j = 0; j < size; ++j) B[i][j] = random.between(-1, 1);
        for (int i = 0; i < size; ++i) {
            right[l][i] = static_cast<double>(static_cast<T>(random.between(-1, 1)));
            y[i].set(l, static_cast<T>(right[l][i]));
            for (int j = 0; j <= i; ++j) {
                double sum = i == j ? lambda : 0;
                for (int k = 0; k < size; ++k) sum += B[i][k] * B[j][k];
                H[i][j].set(l, static_cast<T>(sum));
                kept[l][i][j] = kept[l][j][i] = static_cast<double>(static_cast<T>(sum));
            }
        }
    }
    solve_ldl(H, y, size);
    const V trace = trace_of_inverse(H, size);
    for (int l = 0; l < 8; ++l) {
        const double wanted = inverse_trace(kept[l], size), missed = std::fabs(static_cast<double>(trace[l]) / wanted - 1);
        CHECK(missed <= tolerance / lambda, "%d unknowns, lane %d: the inverse's trace misses by %g", size, l, missed);
    }
    for (int l = 0; l < 8; ++l)
        for (int i = 0; i < size; ++i) {
            tests::real left = -right[l][i], scale = 1;
            for (int j = 0; j < size; ++j) {
                left += static_cast<tests::real>(kept[l][i][j]) * static_cast<tests::real>(y[j][l]);
                scale += std::fabs(static_cast<tests::real>(y[j][l]));
            }
            CHECK(std::fabs(left) <= tolerance * scale, "%d unknowns, lane %d: %g", size, l, static_cast<double>(left));
        }
}
}  // namespace

int main() {
    tests::generator random;
    for (int repeat = 0; repeat < 50; ++repeat) {
        for (int size = 1; size <= 6; ++size) test_size<double, 6>(random, size, 1e-3, 1e-13);
        test_size<double, 1>(random, 1, 0.1, 1e-14);
        test_size<double, 5>(random, 5, 1e-9, 1e-13);
        test_size<float, 6>(random, 6, 1e-2, 1e-4);
    }
    return tests::verdict("ldl");
}
