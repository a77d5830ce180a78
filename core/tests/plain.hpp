// Forward kinematics and errors the plain way, in long double: exponentials by their series, definitions word by word.
// Nothing here is taken from the library but the form in which a target is written down.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>

#include "twistarm/ik/target.hpp"

namespace tests {
using real = long double;

/// Where long double has no more digits than double, its own rounding is allowed for.
constexpr bool exact = std::numeric_limits<real>::digits > std::numeric_limits<double>::digits;

struct matrix {
    real a[4][4];
};

inline matrix identity() {
    matrix m{};
    for (int i = 0; i < 4; ++i) m.a[i][i] = 1;
    return m;
}

inline matrix operator*(const matrix& x, const matrix& y) {
    matrix z{};
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) z.a[i][j] += x.a[i][k] * y.a[k][j];
    return z;
}

/// (Rᵀ, −Rᵀ p).
inline matrix inverse(const matrix& g) {
    matrix back = identity();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            back.a[i][j] = g.a[j][i];
            back.a[i][3] -= g.a[j][i] * g.a[j][3];
        }
    return back;
}

/// exp(ξ̂ x) of ξ = (v, w): the Taylor series of a sixteenth of it, squared up again.
inline matrix exponential(const double* xi, real x) {
    constexpr int squarings = 4, terms = 40;
    const real s = x / (1 << squarings);
    matrix twist{};
    twist.a[0][1] = -xi[5] * s;
    twist.a[0][2] = xi[4] * s;
    twist.a[1][2] = -xi[3] * s;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < i; ++j) twist.a[i][j] = -twist.a[j][i];
    for (int i = 0; i < 3; ++i) twist.a[i][3] = xi[i] * s;
    matrix sum = identity(), term = identity();
    for (int k = 1; k < terms; ++k) {
        term = term * twist;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                term.a[i][j] /= k;
                sum.a[i][j] += term.a[i][j];
            }
    }
    for (int k = 0; k < squarings; ++k) sum = sum * sum;
    return sum;
}

inline matrix rotation(const double phi[3]) {
    const double xi[6] = {0, 0, 0, phi[0], phi[1], phi[2]};
    return exponential(xi, 1);
}

/// R v.
template <class S> void turn(const matrix& R, const S v[3], real out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = R.a[i][0] * v[0] + R.a[i][1] * v[1] + R.a[i][2] * v[2];
}

inline real norm(const real v[3]) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// A few numbers, the largest first.
inline void sort_down(double* values, int count) { std::sort(values, values + count, std::greater<double>()); }

/// φ u of a rotation by less than π.
inline void logarithm(const matrix& R, real phi[3]) {
    const real w[3] = {R.a[2][1] - R.a[1][2], R.a[0][2] - R.a[2][0], R.a[1][0] - R.a[0][1]};
    const real sine = norm(w) / 2, angle = std::atan2(sine, (R.a[0][0] + R.a[1][1] + R.a[2][2] - 1) / 2);
    for (int k = 0; k < 3; ++k) phi[k] = sine > 0 ? w[k] * angle / (2 * sine) : 0;
}

template <class T> matrix from_frame(const twistarm::frame<T>& g) {
    matrix m = identity();
    for (int i = 0; i < 3; ++i) {
        m.a[i][0] = g.x[i];
        m.a[i][1] = g.y[i];
        m.a[i][2] = g.z[i];
        m.a[i][3] = g.p[i];
    }
    return m;
}

template <class T> twistarm::frame<T> to_frame(const matrix& m) {
    double rows[16];
    for (int i = 0; i < 16; ++i) rows[i] = static_cast<double>(m.a[i / 4][i % 4]);
    return twistarm::frame_from_rows<T>(rows);
}

/// The largest difference of an element.
template <class T> double distance(const matrix& expected, const twistarm::frame<T>& g) {
    const matrix m = from_frame(g);
    real worst = 0;
    for (int i = 0; i < 16; ++i) worst = std::fmax(worst, std::fabs(m.a[i / 4][i % 4] - expected.a[i / 4][i % 4]));
    return static_cast<double>(worst);
}

/// What of each of three components lies beyond its tolerance, and the length of that.
template <class T> real beyond(const real v[3], const T* tolerance) {
    real out[3];
    for (int k = 0; k < 3; ++k) out[k] = std::fmax(std::fabs(v[k]) - static_cast<real>(tolerance[k]), real(0));
    return norm(out);
}

struct misses {
    real position, orientation;  ///< [m], [rad]
};

/// How far g misses a target, by the definitions.
template <class T> misses missed(const twistarm::target<T>& asked, const matrix& g) {
    using twistarm::target_kind;
    const matrix goal = from_frame(asked.goal), back = inverse(goal);
    const real d[3] = {g.a[0][3] - goal.a[0][3], g.a[1][3] - goal.a[1][3], g.a[2][3] - goal.a[2][3]};
    if (asked.kind == target_kind::position) return {norm(d), 0};
    real phi[3], away[3];
    if (asked.kind == target_kind::approach) {
        turn(g, asked.tool_axis, phi);
        for (int k = 0; k < 3; ++k) phi[k] -= asked.direction[k];
        return {norm(d), 2 * std::asin(std::fmin(norm(phi) / 2, real(1)))};
    }
    const bool base = asked.kind == target_kind::task && asked.base_axes;
    logarithm(base ? g * back : back * g, phi);
    if (asked.kind == target_kind::pose) return {norm(d), norm(phi)};
    turn(base ? identity() : back, d, away);
    return {beyond(away, asked.tolerance), beyond(phi, asked.tolerance + 3)};
}
}  // namespace tests
