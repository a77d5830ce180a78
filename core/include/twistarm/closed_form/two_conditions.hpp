// Two conditions on two joints, A u(x) + B u(y) = e: the points where two ellipses or parabolas meet.
//
// u(x) is (cos x, sin x) for a turn and (x, x²) for a slide. Only the second condition has squares of lengths. For two
// turns this is subproblem 6 of Elias & Wen, IK-Geo, 2022: a quartic. If every value of one joint works but the other
// has no root, the nearest value counts as one; Newton's method then moves both. If one condition is nearly a multiple
// of the other, both ways of solving are used. So the result holds every root, and some values that are not roots.
#pragma once

#include "trigonometric.hpp"

TWISTARM_BEGIN

namespace closed_form {

/// Ratio of singular values above which the two rows of a matrix are two conditions. Below the second number they are
/// one.
template <class T> constexpr T clearly_two = is_double<T> ? T(1e-6) : T(1e-3);
template <class T> constexpr T barely_two = is_double<T> ? T(1e-12) : T(1e-6);

/// Below this ratio a matrix has rank 1 up to rounding.
template <class T> constexpr T only_one = is_double<T> ? T(1e-12) : T(1e-6);

/// Above this ratio a pair (cos x, sin x) is solved for as two numbers.
template <class T> constexpr T well_conditioned = T(is_double<T> ? 1e-3 : 3e-2);

/// One joint's part: the matrix, whether it slides, and the value that it gets where every one does.
template <class T> struct side {
    T A[2][2];
    bool slides;
    joint_value<T> near;

    T largest() const { return greatest(greatest(size(0), size(1)), T(0)); }
    T size(int row) const { return greatest(absolute(A[row][0]), absolute(A[row][1])); }
    T size_of_column(int k) const { return greatest(absolute(A[0][k]), absolute(A[1][k])); }
    /// Row i of A u(x).
    T at(int i, const joint_value<T>& x) const {
        return slides ? (A[i][0] + A[i][1] * x.length) * x.length : A[i][0] * x.cosine + A[i][1] * x.sine;
    }
};

/// Values of both joints.
template <class T> struct pair {
    joint_value<T> x, y;
};

template <class T> using pairs = few<pair<T>, 8>;

/// Singular values of a 2 × 2 matrix, and the main direction `row` of its columns. `row` is the first column of U in U
/// Σ Vᵀ; the second is (−row[1], row[0]).
template <class T> struct two_by_two {
    T larger, smaller, row[2];

    explicit two_by_two(const T A[2][2]) {
        const T p = A[0][0] * A[0][0] + A[0][1] * A[0][1], r = A[1][0] * A[1][0] + A[1][1] * A[1][1];
        const T q = A[0][0] * A[1][0] + A[0][1] * A[1][1];
        // Rows across one another, or one of them 0: no root needs to be drawn to see it.
        const bool diagonal = absolute(q) <= T(sizeof(T) == 8 ? 1e-15 : 1e-7) * absolute(p - r);
        const T h = diagonal ? absolute(p - r) : sqrt((p - r) * (p - r) + T(4) * q * q);
        larger = sqrt(T(0.5) * (p + r + h));
        smaller = larger > T(0) ? absolute(A[0][0] * A[1][1] - A[0][1] * A[1][0]) / larger : T(0);
        row[0] = T(1);
        row[1] = T(0);
        if (!(h > T(0))) return;
        const int main = p >= r ? 0 : 1;
        row[main] = diagonal ? T(1) : sqrt(T(0.5) * (T(1) + absolute(p - r) / h));
        row[1 - main] = diagonal ? T(0) : q / (h * row[main]);
    }
};

/// A⁻¹ e.
template <class T, class V> void solve_two(const T A[2][2], const V e[2], V x[2]) {
    const T determinant = A[0][0] * A[1][1] - A[0][1] * A[1][0];
    x[0] = (e[0] * A[1][1] - A[0][1] * e[1]) / determinant;
    x[1] = (A[0][0] * e[1] - e[0] * A[1][0]) / determinant;
}

/// All x with A u(x) = e: two conditions, one of which is enough.
template <class T, class V> roots<V, 4> one_joint(const side<T>& a, const V e[2], V slack) {
    roots<V, 4> found;
    const auto always = in_every_lane<V>(true);
    const auto add_all = [&](const roots<V, 2>& some) {
        for (int r = 0; r < some.count; ++r) found.add(some.items[r], some.there[r]);
    };
    const joint_value<V> any_value(set_free(a.near));
    if (a.slides && a.size_of_column(1) <= nothing<T> * a.largest()) {
        const T square = a.A[0][0] * a.A[0][0] + a.A[1][0] * a.A[1][0];
        found.add(square > T(0) ? slid((a.A[0][0] * e[0] + a.A[1][0] * e[1]) / square) : any_value, always);
        return found;
    }
    if (a.slides) {
        for (int i = 0; i < 2; ++i)
            if (a.size(i) > T(0)) add_all(quadratic(a.A[i][1], a.A[i][0], -e[i], slack));
        return found;
    }
    const two_by_two<T> size(a.A);
    if (size.larger <= nothing<T>) {
        found.add(any_value, always);
    } else if (size.smaller > well_conditioned<T> * size.larger) {
        V both[2];
        solve_two(a.A, e, both);
        found.add(rotated(both[0], both[1]), always);
    } else {
        const T cosine = size.row[0] * a.A[0][0] + size.row[1] * a.A[1][0];
        const T sine = size.row[0] * a.A[0][1] + size.row[1] * a.A[1][1];
        const V wanted = size.row[0] * e[0] + size.row[1] * e[1];
        add_all(harmonic(cosine, sine, wanted, size.larger, greatest(slack, V(clearly_two<T>))));
    }
    return found;
}

namespace detail {
template <class T> void add_swapped(const pairs<T>& swapped, pairs<T>& found) {
    for (const pair<T>& root : swapped) found.add({root.y, root.x});
}

/// Both conditions are linear. If they are dependent, the second length keeps its current value.
template <class T> void two_linear(const side<T>& a, const side<T>& b, const T e[2], pairs<T>& found) {
    const T both[2][2] = {{a.A[0][0], b.A[0][0]}, {a.A[1][0], b.A[1][0]}};
    if (absolute(both[0][0] * both[1][1] - both[0][1] * both[1][0]) > nothing<T>) {
        T x[2];
        solve_two(both, e, x);
        found.add({slid(x[0]), slid(x[1])});
        return;
    }
    const roots<T, 4> first = one_joint(a, e, T(0)), second = one_joint(b, e, T(0));
    if (first.count == 0 || second.count == 0) return;
    joint_value<T> x = first.items[0], y = second.items[0];
    if (!x.free && !y.free) {
        const T rest[2] = {e[0] - both[0][1] * b.near.length, e[1] - both[1][1] * b.near.length};
        const T square = a.A[0][0] * a.A[0][0] + a.A[1][0] * a.A[1][0];
        x = slid((a.A[0][0] * rest[0] + a.A[1][0] * rest[1]) / square);
        y = set_free(b.near);
    }
    found.add({x, y});
}

/// Both slide: one length follows from the first condition; where the slides have come parallel one is free.
template <class T> void two_lengths(const side<T>& a, const side<T>& b, const T e[2], T slack, pairs<T>& found) {
    const auto &A = a.A, &B = b.A;
    if (a.size_of_column(1) + b.size_of_column(1) <= nothing<T>) return two_linear(a, b, e, found);
    if (absolute(B[0][0]) > absolute(A[0][0])) {
        pairs<T> swapped;
        two_lengths(b, a, e, slack, swapped);
        return add_swapped(swapped, found);
    }
    if (absolute(A[0][0]) <= nothing<T>) {
        for (const joint_value<T>& x : quadratic(A[1][1], A[1][0], b.at(1, b.near) - e[1], nearest<T>))
            found.add({x, set_free(b.near)});
        return;
    }
    const T p = e[0] / A[0][0], q = -B[0][0] / A[0][0];  // x = p + q y
    const T square = A[1][1] * q * q + B[1][1], linear = A[1][0] * q + T(2) * A[1][1] * p * q + B[1][0];
    const T constant = A[1][0] * p + A[1][1] * p * p - e[1];
    if (absolute(square) <= nothing<T> && absolute(linear) <= nothing<T>)
        return found.add({slid(p + q * b.near.length), set_free(b.near)});
    for (const joint_value<T>& y : quadratic(square, linear, constant, slack)) found.add({slid(p + q * y.length), y});
}

/// x turns, y slides. y follows from a condition that is linear in it, or x from one without y.
template <class T> void angle_and_length(const side<T>& a, const side<T>& b, const T e[2], T slack, pairs<T>& found) {
    const auto& A = a.A;
    const T linear[2] = {b.A[0][0], b.A[1][0]}, square = b.A[1][1], scale = a.largest() + b.largest();
    if (b.size_of_column(1) <= nothing<T>) {
        const int i = absolute(linear[1]) > absolute(linear[0]) ? 1 : 0, j = 1 - i;
        if (absolute(linear[i]) <= nothing<T> * scale) {
            for (const joint_value<T>& x : one_joint(a, e, slack)) found.add({x, set_free(b.near)});
            return;
        }
        const T share = linear[j] / linear[i], cosine = A[j][0] - share * A[i][0], sine = A[j][1] - share * A[i][1];
        for (const joint_value<T>& x : harmonic(cosine, sine, e[j] - share * e[i], scale, slack).or_near(a.near))
            found.add({x, slid((e[i] - a.at(i, x)) / linear[i])});
        return;
    }
    if (absolute(linear[0]) > clearly_two<T>) {
        const T p = e[0] / linear[0], q[2] = {-A[0][0] / linear[0], -A[0][1] / linear[0]};  // y = p + q · u(x)
        const T f = square, g = linear[1];
        const second_harmonic<T> equation{{g * p + f * p * p - e[1], A[1][0] + (g + T(2) * f * p) * q[0],
                                           A[1][1] + (g + T(2) * f * p) * q[1], f * q[0] * q[0], T(2) * f * q[0] * q[1],
                                           f * q[1] * q[1]}};
        const T terms = greatest(greatest(absolute(g * p), absolute(f * p * p)), absolute(e[1]));
        for (const joint_value<T>& x : equation.zeros(slack, terms).or_near(a.near))
            found.add({x, slid(p + q[0] * x.cosine + q[1] * x.sine)});
        return;
    }
    for (const joint_value<T>& x : harmonic(A[0][0], A[0][1], e[0], scale, slack).or_near(a.near))
        for (const joint_value<T>& y : quadratic(square, linear[1], a.at(1, x) - e[1], x.free ? nearest<T> : slack)) found.add({x, y});
}

/// u(x) = A⁻¹ (e − B u(y)) has length 1.
template <class T> void by_inverse(const side<T>& a, const side<T>& b, const T e[2], T slack, pairs<T>& found) {
    T m[2], B[2][2];
    solve_two(a.A, e, m);
    for (int k = 0; k < 2; ++k) {
        const T column[2] = {b.A[0][k], b.A[1][k]};
        T solved[2];
        solve_two(a.A, column, solved);
        B[0][k] = solved[0];
        B[1][k] = solved[1];
    }
    const second_harmonic<T> equation{{m[0] * m[0] + m[1] * m[1] - T(1), T(-2) * (m[0] * B[0][0] + m[1] * B[1][0]),
                                       T(-2) * (m[0] * B[0][1] + m[1] * B[1][1]), B[0][0] * B[0][0] + B[1][0] * B[1][0],
                                       T(2) * (B[0][0] * B[0][1] + B[1][0] * B[1][1]),
                                       B[0][1] * B[0][1] + B[1][1] * B[1][1]}};
    for (const joint_value<T>& y : equation.zeros(slack).or_near(b.near))
        found.add({rotated(m[0] - B[0][0] * y.cosine - B[0][1] * y.sine, m[1] - B[1][0] * y.cosine - B[1][1] * y.sine), y});
}

/// A is of rank 1: across its one row y stands alone; x follows.
template <class T>
void one_by_one(const side<T>& a, const side<T>& b, const T e[2], const T row[2], T scale, T slack, pairs<T>& found) {
    const auto &A = a.A, &B = b.A;
    const auto along = [&](const T M[2][2], int k) { return row[0] * M[0][k] + row[1] * M[1][k]; };
    const auto alone = [&](const T M[2][2], int k) { return row[0] * M[1][k] - row[1] * M[0][k]; };
    const T wanted = row[0] * e[0] + row[1] * e[1], left = row[0] * e[1] - row[1] * e[0];
    for (const joint_value<T>& y : harmonic(alone(B, 0), alone(B, 1), left, scale, slack).or_near(b.near)) {
        const T rest = wanted - along(B, 0) * y.cosine - along(B, 1) * y.sine;
        for (const joint_value<T>& x : harmonic(along(A, 0), along(A, 1), rest, scale, y.free ? nearest<T> : slack).or_near(a.near))
            found.add({x, y});
    }
}

/// Both turn. If A is the better conditioned, x is eliminated: by A's inverse, or by the row that A lacks.
///
/// If only one of the matrices has rank 1, one condition holds the other joint alone.
template <class T> void two_angles(const side<T>& a, const side<T>& b, const T e[2], T slack, pairs<T>& found) {
    const two_by_two<T> size_a(a.A), size_b(b.A);
    const T scale = greatest(size_a.larger, size_b.larger);
    if (size_a.larger <= nothing<T> * scale) {
        for (const joint_value<T>& y : one_joint(b, e, slack)) found.add({set_free(a.near), y});
        return;
    }
    if (size_b.larger <= nothing<T> * scale) {
        for (const joint_value<T>& x : one_joint(a, e, slack)) found.add({x, set_free(b.near)});
        return;
    }
    const T ratio = size_a.smaller / size_a.larger, other = size_b.smaller / size_b.larger;
    // The usual arms: no quartic is needed.
    if (ratio <= only_one<T> && other > well_conditioned<T>)
        return one_by_one(a, b, e, size_a.row, scale, slack, found);
    if (other > ratio || (other <= only_one<T> && ratio > well_conditioned<T>)) {
        pairs<T> swapped;
        two_angles(b, a, e, slack, swapped);
        return add_swapped(swapped, found);
    }
    if (ratio > barely_two<T>) by_inverse(a, b, e, slack, found);
    if (!(ratio > clearly_two<T>)) one_by_one(a, b, e, size_a.row, scale, greatest(slack, clearly_two<T>), found);
}
}  // namespace detail

/// All (x, y) with A u(x) + B u(y) = e.
template <class T> pairs<T> two_conditions(const side<T>& a, const side<T>& b, const T e[2], T slack) {
    pairs<T> found;
    if (a.slides && !b.slides) {
        pairs<T> swapped;
        detail::angle_and_length(b, a, e, slack, swapped);
        detail::add_swapped(swapped, found);
    } else if (a.slides) {
        detail::two_lengths(a, b, e, slack, found);
    } else if (b.slides) {
        detail::angle_and_length(a, b, e, slack, found);
    } else {
        detail::two_angles(a, b, e, slack, found);
    }
    return found;
}

}  // namespace closed_form

TWISTARM_END
