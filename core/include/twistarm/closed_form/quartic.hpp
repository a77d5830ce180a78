// All roots of a quartic at once, the complex ones too: the iteration of Aberth and Ehrlich.
#pragma once

#include "../numeric/lanes.hpp"

TWISTARM_BEGIN

namespace closed_form {

template <class T> struct complex_number {
    T re, im;
};

template <class T> complex_number<T> operator+(complex_number<T> a, complex_number<T> b) { return {a.re + b.re, a.im + b.im}; }
template <class T> complex_number<T> operator-(complex_number<T> a, complex_number<T> b) { return {a.re - b.re, a.im - b.im}; }
template <class T> complex_number<T> operator*(complex_number<T> a, complex_number<T> b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class T> complex_number<T> operator/(complex_number<T> a, complex_number<T> b) {
    const T size = b.re * b.re + b.im * b.im;
    return {(a.re * b.re + a.im * b.im) / size, (a.im * b.re - a.re * b.im) / size};
}
template <class T> T size_of(complex_number<T> a) { return absolute(a.re) + absolute(a.im); }

/// Roots t of p₀ + p₁ t + … + p₄ t⁴ with p₄ ≠ 0.
///
/// tᵢ ← tᵢ − N / (1 − N Σ 1/(tᵢ − tⱼ)) with N = p/p' at tᵢ. The sum keeps the four apart, so they find all roots:
/// simple ones to rounding, clustered ones to the digits that they have. Sources: L. W. Ehrlich, A modified Newton
/// method for polynomials, Comm. ACM 10(2), 1967; O. Aberth, Iteration methods for finding all zeros of a polynomial
/// simultaneously, Math. Comp. 27, 1973.
template <class T> void quartic_roots(const T p[5], complex_number<T> t[4]) {
    constexpr int most_steps = 60;
    constexpr T precise = sizeof(T) == 8 ? T(1e-14) : T(1e-6);
    const T lead = T(1) / p[4], a[4] = {p[0] * lead, p[1] * lead, p[2] * lead, p[3] * lead};
    // On a circle about the mean of the roots, with their mean distance from it as radius, and off the real axis.
    const T mean = T(-0.25) * a[3];
    const T there = a[0] + mean * (a[1] + mean * (a[2] + mean * (a[3] + mean)));
    const T radius = sqrt(sqrt(absolute(there))) + T(1e-3) * (T(1) + absolute(mean));
    const T start[4][2] = {{T(0.92), T(0.39)}, {T(-0.39), T(0.92)}, {T(-0.92), T(-0.39)}, {T(0.39), T(-0.92)}};
    for (int i = 0; i < 4; ++i) t[i] = {mean + radius * start[i][0], radius * start[i][1]};
    const complex_number<T> one{T(1), T(0)};
    bool still = false;
    for (int step = 0; step < most_steps && !still; ++step) {
        still = true;
        for (int i = 0; i < 4; ++i) {
            complex_number<T> value = one, slope{T(0), T(0)}, others{T(0), T(0)};
            for (int k = 3; k >= 0; --k) {
                slope = slope * t[i] + value;
                value = value * t[i];
                value.re += a[k];
            }
            if (size_of(value) == T(0)) continue;
            for (int j = 0; j < 4; ++j)
                if (j != i && size_of(t[i] - t[j]) > T(0)) others = others + one / (t[i] - t[j]);
            const complex_number<T> bottom = slope - value * others;
            if (!(size_of(bottom) > T(0))) continue;
            const complex_number<T> move = value / bottom;
            t[i] = t[i] - move;
            still = still && size_of(move) <= precise * (T(1) + size_of(t[i]));
        }
    }
}

}  // namespace closed_form

TWISTARM_END
