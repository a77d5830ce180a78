// Roots of the equations that subproblems lead to: in the sine and cosine of an angle, or in a length.
//
// An equation that misses a root by less than `slack` of its size has the nearest value as its root. So a stretched arm
// has one answer in spite of rounding. Forward kinematics decides later which roots are true.
#pragma once

#include "joint_axis.hpp"
#include "quartic.hpp"

TWISTARM_BEGIN

namespace closed_form {

template <class T> constexpr bool is_double = sizeof(T) == 8;

/// A coefficient below this part of the equation's scale is zero.
template <class T> constexpr T nothing = is_double<T> ? T(1e-9) : T(1e-5);

/// If all coefficients are zero, the rest of the equation may be this part of its scale.
template <class T> constexpr T level = is_double<T> ? T(1e-7) : T(1e-4);

/// The slack with which every equation has a root: the nearest value.
template <class T> constexpr T nearest = T(is_double<T> ? 1e100 : 1e30F);

/// A discriminant below this part of its size is rounding, and two roots are one.
template <class T> constexpr T double_root = is_double<T> ? T(1e-13) : T(1e-6);

/// Real roots; `any`: every value is one.
template <class V, int Most> struct roots : few<joint_value<V>, Most, mask_of<V>> {
    mask_of<V> any = in_every_lane<V>(false);

    /// These roots, or the current value if every value is a root.
    roots or_near(const joint_value<scalar_of<V>>& near) const {
        roots found = *this;
        found.add(joint_value<V>(set_free(near)), any);
        return found;
    }
};

/// Angles x with a cos x + b sin x = c: atan2(b, a) ± acos(c / √(a² + b²)). `scale` is that of the other coefficients.
template <class T, class V> roots<V, 2> harmonic(T a, T b, V c, T scale, V slack) {
    roots<V, 2> found;
    const T amplitude = sqrt(a * a + b * b);
    if (amplitude <= nothing<T> * scale) {
        found.any = absolute(c) <= (level<T> + slack) * scale;
        return found;
    }
    const auto there = absolute(c) <= amplitude * (T(1) + slack) + nothing<T> * scale;
    if (!any(there)) return found;
    const V square = (amplitude - c) * (amplitude + c), zero = V(0);
    const V opening = sqrt(select(square > V(double_root<T> * amplitude * amplitude), square, zero));
    found.add(rotated(a * c - b * opening, b * c + a * opening), there);
    found.add(rotated(a * c + b * opening, b * c - a * opening), there & (opening > zero));
    return found;
}

/// Lengths x with f x² + b x + c = 0, without cancellation.
template <class T, class V> roots<V, 2> quadratic(T f, T b, V c, V slack) {
    roots<V, 2> found;
    if (absolute(f) <= nothing<T> * absolute(b)) {
        if (b != T(0)) found.add(slid(-c / b), in_every_lane<V>(true));
        return found;
    }
    const V discriminant = b * b - T(4) * f * c, size = b * b + absolute(T(4) * f * c), zero = V(0);
    const auto there = discriminant >= -slack * size;
    const V root = sqrt(select(discriminant > double_root<T> * size, discriminant, zero));
    const V q = T(-0.5) * (b + (b < T(0) ? -root : root));
    found.add(slid(q / f), there);
    found.add(slid(c / q), there & (root > zero) & (absolute(q) > zero));
    return found;
}

/// k₀ + k₁ c + k₂ s + k₃ c² + k₄ c s + k₅ s², c = cos x and s = sin x.
template <class T> struct second_harmonic {
    T k[6];

    T at(T c, T s) const { return k[0] + k[1] * c + k[2] * s + k[3] * c * c + k[4] * c * s + k[5] * s * s; }
    T slope(T c, T s) const {
        return -k[1] * s + k[2] * c - T(2) * k[3] * c * s + k[4] * (c * c - s * s) + T(2) * k[5] * s * c;
    }
    T scale() const {
        T largest = T(0);
        for (T value : k) largest = greatest(largest, absolute(value));
        return largest;
    }

    /// The zeros, at most four: a quartic in t = tan((x − x₀)/2), with x₀ such that its leading coefficient is large.
    /// terms: the size of the summands of the coefficients. If all coefficients cancel to rounding, every x is a root.
    roots<T, 4> zeros(T slack, T terms = T(0)) const {
        roots<T, 4> found;
        const T size = scale();
        if (!(size > nothing<T> * terms)) {
            found.any = true;
            return found;
        }
        const joint_value<T> start = beginning();
        T p[5];
        in_half_tangent(start, p);
        T largest = T(0);
        for (T value : p) largest = greatest(largest, absolute(value));
        if (!(largest > nothing<T> * size)) {
            found.any = true;
            return found;
        }
        complex_number<T> t[4];
        quartic_roots(p, t);
        for (const complex_number<T>& root : t) {
            const T square = root.re * root.re + root.im * root.im;
            if (absolute(root.im) > T(3) * sqrt(slack) * (T(1) + square)) continue;
            const joint_value<T> x = rotated(T(1) - root.re * root.re, T(2) * root.re) + start;
            found.add(corrected(x, size));
        }
        return found;
    }

private:
    /// Of eight angles the one half a turn from where the value is largest.
    joint_value<T> beginning() const {
        joint_value<T> best{T(1), T(0), T(0)}, tried = best;
        const joint_value<T> on{T(0.7648421872844885), T(0.644217687237691), T(0)};  // by 0.7 rad
        T largest = T(-1);
        for (int i = 0; i < 8; ++i, tried = tried + on) {
            const T size = absolute(at(-tried.cosine, -tried.sine));
            if (size > largest) {
                largest = size;
                best = tried;
            }
        }
        return best;
    }

    /// The equation times (1 + t²)², p[i] with tⁱ.
    void in_half_tangent(const joint_value<T>& start, T p[5]) const {
        const T one[3] = {T(1), T(0), T(1)}, c[3] = {start.cosine, T(-2) * start.sine, -start.cosine},
                s[3] = {start.sine, T(2) * start.cosine, -start.sine};
        const T* const pairs[6][2] = {{one, one}, {c, one}, {s, one}, {c, c}, {c, s}, {s, s}};
        for (int i = 0; i < 5; ++i) p[i] = T(0);
        for (int m = 0; m < 6; ++m)
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) p[i + j] += k[m] * pairs[m][0][i] * pairs[m][1][j];
    }

    /// x after three short Newton steps. At a double root they gain nothing.
    joint_value<T> corrected(joint_value<T> x, T size) const {
        for (int step = 0; step < 3; ++step) {
            const T rate = slope(x.cosine, x.sine);
            if (absolute(rate) < nothing<T> * size) break;
            const T on = at(x.cosine, x.sine) / rate;
            if (absolute(on) > T(0.01)) break;
            x = rotated(x.cosine + on * x.sine, x.sine - on * x.cosine);
        }
        return x;
    }
};

}  // namespace closed_form

TWISTARM_END
