// Singular directions: the rows reassembled from them, orthonormal, and the singular values that were put in.
#include "twistarm/kinematics/singular_directions.hpp"

#include "check.hpp"
#include "plain.hpp"

using namespace twistarm;
using tests::real;

namespace {
template <class T> constexpr double rounding = sizeof(T) == 8 ? 1e-14 : 4e-6;

/// Below this share of the largest, directions are not distinguished.
constexpr double least = 1e-4;

/// `count` orthonormal vectors of `size` numbers, by Gram and Schmidt, twice.
void draw_orthonormal(tests::generator& random, int count, int size, real (&out)[6][most_joints]) {
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < size; ++k) out[i][k] = random.between(-1, 1);
        for (int pass = 0; pass < 2 * i; ++pass) {
            real along = 0;
            for (int k = 0; k < size; ++k) along += out[i][k] * out[pass % i][k];
            for (int k = 0; k < size; ++k) out[i][k] -= along * out[pass % i][k];
        }
        real length = 0;
        for (int k = 0; k < size; ++k) length += out[i][k] * out[i][k];
        for (int k = 0; k < size; ++k) out[i][k] /= std::sqrt(length);
    }
}

/// A = Σ σ u vᵀ of count rows, min(count, n) singular values given.
template <class T, int N>
void assemble(tests::generator& random, int count, int n, const double* sigma, six_rows<T, N>& A) {
    real u[6][most_joints], v[6][most_joints];
    const int rank = count < n ? count : n;
    draw_orthonormal(random, rank, count, u);
    draw_orthonormal(random, rank, n, v);
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < n; ++k) {
            real sum = 0;
            for (int d = 0; d < rank; ++d) sum += u[d][i] * static_cast<real>(sigma[d]) * v[d][k];
            A[i][k] = static_cast<T>(sum);
        }
}

template <class T> double dotted(const T* a, const T* b, int count, int stride = 1) {
    real sum = 0;
    for (int k = 0; k < count; ++k) sum += static_cast<real>(a[k * stride]) * static_cast<real>(b[k * stride]);
    return static_cast<double>(sum);
}

/// X is orthogonal, X · rows is A again, and rows that are longer than rounding are orthogonal; sigma: their lengths.
template <class T, int N> void check_directions(const six_rows<T, N>& A, int count, int n, double size, double* sigma) {
    six_rows<T, N> rows;
    T X[6][6];
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < n; ++k) rows[i][k] = A[i][k];
    make_orthogonal<T, N>(rows, count, n, X);
    for (int i = 0; i < count; ++i) {
        sigma[i] = std::sqrt(dotted(rows[i], rows[i], n));
        for (int k = 0; k < n; ++k) {
            real sum = 0;
            for (int d = 0; d < count; ++d) sum += static_cast<real>(X[i][d]) * static_cast<real>(rows[d][k]);
            const double off = std::fabs(static_cast<double>(sum - static_cast<real>(A[i][k])));
            CHECK(off <= rounding<T> * size, "%d rows of %d: reassembled by %g", count, n, off);
        }
        for (int j = 0; j < i; ++j) {
            const double turned = std::fabs(dotted(&X[0][i], &X[0][j], count, 6));
            CHECK(turned <= rounding<T>, "%d rows of %d: u · u = %g", count, n, turned);
            if (sigma[i] <= least * size || sigma[j] <= least * size) continue;
            const double cosine = std::fabs(dotted(rows[i], rows[j], n)) / (sigma[i] * sigma[j]);
            CHECK(cosine <= rounding<T>, "%d rows of %d: v · v = %g", count, n, cosine);
        }
        const double whole = dotted(&X[0][i], &X[0][i], count, 6);
        CHECK(std::fabs(whole - 1) <= rounding<T>, "%d rows of %d: |u|² = %g", count, n, whole);
    }
    tests::sort_down(sigma, count);
}

template <class T, int N> void test_given_values(tests::generator& random, int count, int n) {
    const double kinds[][6] = {{2, 1.5, 1, 0.7, 0.3, 0.1}, {1, 1, 1, 1, 1, 1},          {3, 2, 1, 0, 0, 0},
                               {1, 1, 1e-3, 1e-3, 0, 0},   {1, 1e-3, 1e-9, 0, 0, 0}, {1, 1, 1e-3, 1e-3, 1e-9, 1e-9},
                               {0, 0, 0, 0, 0, 0}};
    for (const double(&given)[6] : kinds) {
        six_rows<T, N> A;
        double found[6];
        assemble<T, N>(random, count, n, given, A);
        check_directions<T, N>(A, count, n, given[0], found);
        for (int d = 0; d < count; ++d) {
            const double expected = d < n ? given[d] : 0;
            CHECK(std::fabs(found[d] - expected) <= rounding<T> * given[0], "%d rows of %d: σ%d = %.17g, not %g", count,
                  n, d, found[d], expected);
        }
    }
}

/// Rows that are zero, the same or opposite to the last bit: √k |a| is the one singular value of k of them.
template <class T> void test_equal_rows() {
    six_rows<T, 3> A = {};
    double sigma[6];
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) A[i][k] = T((i % 2 == 0 ? 1 : -1) * (k + 1));
    check_directions<T, 3>(A, 6, 3, std::sqrt(56), sigma);
    CHECK(std::fabs(sigma[0] - std::sqrt(56)) < 10 * rounding<T>, "%g", sigma[0]);
    CHECK(sigma[1] < 10 * rounding<T>, "%g", sigma[1]);
}

/// Small singular values are right in their own digits where the rows are only scaled: D B, B well conditioned.
void test_graded_rows() {
    const double B[3][3] = {{2, 1, 0}, {1, 3, 1}, {0, 1, 2}}, scale[3] = {1, 1e-6, 1e-12};
    six_rows<double, 3> A;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) A[i][k] = scale[i] * B[i][k];
    double X[6][6], product = 1;
    make_orthogonal<double, 3>(A, 3, 3, X);
    for (int i = 0; i < 3; ++i) product *= std::sqrt(dotted(A[i], A[i], 3));
    CHECK(std::fabs(product / 8e-18 - 1) < 1e-12, "|det| = %g, det B = 8", product);
}
}  // namespace

int main() {
    tests::generator random;
    for (int count = 1; count <= 6; ++count)
        for (int n = 1; n <= most_joints; n += n < 8 ? 1 : 8) {
            test_given_values<double, dynamic>(random, count, n);
            test_given_values<float, dynamic>(random, count, n);
        }
    test_given_values<double, 6>(random, 6, 6);
    test_equal_rows<double>();
    test_equal_rows<float>();
    test_graded_rows();
    return tests::verdict("singular_directions");
}
