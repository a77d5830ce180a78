// Sine, cosine, arc sine and arc tangent of scalars and packs, without branches on the ordinary path.
#pragma once

#include "lanes.hpp"

TWISTARM_BEGIN

/// Beyond this [rad] angles are reduced by the C library, lane by lane.
constexpr double far_angle = 1e4;

namespace detail {
// π/2 in three parts, the first two with so few bits that k times them is exact for |k| up to 2 far_angle / π
// (Cody & Waite, Software Manual for the Elementary Functions, 1980), and the minimax polynomials on [−π/4, π/4].
template <class T> struct trigonometry;

template <> struct trigonometry<double> {
    static constexpr double rounding = 6755399441055744.0;  // 1.5 · 2⁵²: added, it leaves the nearest integer
    static constexpr double half_pi[3] = {1.57079632673412561417e+00, 6.07710050630396597660e-11,
                                          2.02226624879595063154e-21};
    template <class V> static TWISTARM_INLINE V sine(const V& r, const V& z) {
        V p = 1.58969099521155010221e-10 * z - 2.50507602534068634195e-08;
        p = p * z + 2.75573137070700676789e-06;
        p = p * z - 1.98412698298579493134e-04;
        p = p * z + 8.33333333332248946124e-03;
        p = p * z - 1.66666666666666324348e-01;
        return r + (r * z) * p;
    }
    template <class V> static TWISTARM_INLINE V cosine(const V& z) {
        V p = -1.13596475577881948265e-11 * z + 2.08757232129817482790e-09;
        p = p * z - 2.75573143513906633035e-07;
        p = p * z + 2.48015872894767294178e-05;
        p = p * z - 1.38888888888741095749e-03;
        p = p * z + 4.16666666666666019037e-02;
        return (1.0 - 0.5 * z) + (z * z) * p;
    }
};

template <> struct trigonometry<float> {
    static constexpr float rounding = 12582912.0F;  // 1.5 · 2²³
    static constexpr float half_pi[3] = {1.5703125F, 4.837512969970703125e-4F, 7.54978995489188216e-8F};
    template <class V> static TWISTARM_INLINE V sine(const V& r, const V& z) {
        V p = -1.9515295891e-4F * z + 8.3321608736e-3F;
        p = p * z - 1.6666654611e-1F;
        return r + (r * z) * p;
    }
    template <class V> static TWISTARM_INLINE V cosine(const V& z) {
        V p = 2.443315711809948e-5F * z - 1.388731625493765e-3F;
        p = p * z + 4.166664568298827e-2F;
        return (1.0F - 0.5F * z) + (z * z) * p;
    }
};

template <class V> __attribute__((noinline, cold)) void far_sincos(const V& x, V& sine, V& cosine) {
    for (int i = 0; i < number<V>::lanes; ++i) {
        const double angle = static_cast<double>(lane(x, i));
        if (angle > -far_angle && angle < far_angle) continue;
        set_lane(sine, i, static_cast<scalar_of<V>>(__builtin_sin(angle)));
        set_lane(cosine, i, static_cast<scalar_of<V>>(__builtin_cos(angle)));
    }
}
}  // namespace detail

/// The nearest whole number, for |x| < 2⁵¹ (float: 2²²).
template <class V> TWISTARM_INLINE V nearest_whole(const V& x) {
    constexpr auto rounding = detail::trigonometry<scalar_of<V>>::rounding;
    return (x + rounding) - rounding;
}

/// sin x and cos x, x [rad]: within 2.5 ulp for double and |x| < `far_angle`, the C library's beyond; NaN for ∓inf.
///
/// x = k π/2 + r with |r| ≤ π/4; k mod 4 says which polynomial and which sign. In float the reduction leaves 1e-7
/// absolute, not relative, near the zeros.
template <class V> TWISTARM_INLINE void sincos(const V& x, V& sine, V& cosine) {
    using constants = detail::trigonometry<scalar_of<V>>;
    const V shifted = x * scalar_of<V>(0.63661977236758134308) + constants::rounding;
    const V k = shifted - constants::rounding;
    const V r = ((x - k * constants::half_pi[0]) - k * constants::half_pi[1]) - k * constants::half_pi[2];
    const V z = r * r;
    const V s = constants::sine(r, z), c = constants::cosine(z);
    const auto quadrant = to_bits(shifted);
    const auto odd = is_odd(quadrant);
    sine = flip_sign(select(odd, c, s), quadrant, 0, 1);
    cosine = flip_sign(select(odd, s, c), quadrant, 1, 1);
    const auto near = (x > V(scalar_of<V>(-far_angle))) & (x < V(scalar_of<V>(far_angle)));
    if (__builtin_expect(!all(near), 0)) detail::far_sincos(x, sine, cosine);
}

/// arcsin x for x in [0, 1], within 3 ulp for double. Source: the rational approximation of fdlibm, e_asin.c.
///
/// arcsin x = x + x R(x²) up to ½, and π/2 − 2 arcsin √((1 − x)/2) above.
template <class V> TWISTARM_INLINE V arcsine(const V& x) {
    using T = scalar_of<V>;
    const auto large = x > V(T(0.5));
    const V z = select(large, T(0.5) * (V(T(1)) - x), x * x);
    const V root = select(large, sqrt(greatest(z, V(T(0)))), x);
    V p = z * T(3.47933107596021167570e-05) + T(7.91534994289814532176e-04);
    p = p * z + T(-4.00555345006794114027e-02);
    p = p * z + T(2.01212532134862925881e-01);
    p = p * z + T(-3.25565818622400915405e-01);
    p = p * z + T(1.66666666666666657415e-01);
    V q = z * T(7.70381505559019352791e-02) + T(-6.88283971605453293030e-01);
    q = q * z + T(2.02094576023350569471e+00);
    q = q * z + T(-2.40339491173441421878e+00);
    q = q * z + T(1);
    const V near = root + root * (z * p / q);
    return select(large, T(1.57079632679489661923) - T(2) * near, near);
}

/// The angle of (x, y) in [−π, π], within 4 ulp for double; 0 for (0, 0). Source: the rational approximation of Cephes, atan.c.
///
/// With t = s/l, s = min(|x|, |y|), l = max(|x|, |y|): arctan t = t + t³ P(t²) / Q(t²) up to tan(π/8), and above
/// π/4 + arctan((s − l)/(s + l)).
template <class V> TWISTARM_INLINE V arctangent(const V& y, const V& x) {
    using T = scalar_of<V>;
    const V across = absolute(y), along = absolute(x), zero = V(T(0));
    const V larger = greatest(across, along), smaller = least(across, along);
    const auto middle = smaller > larger * T(0.41421356237309504880);
    const V below = select(middle, smaller + larger, larger);
    const V t = select(middle, smaller - larger, smaller) / select(below > zero, below, V(T(1))), z = t * t;
    V p = z * T(-8.750608600031904122785e-1) + T(-1.615753718733365076637e1);
    p = p * z + T(-7.500855792314704667340e1);
    p = p * z + T(-1.228866684490136173410e2);
    p = p * z + T(-6.485021904942025371773e1);
    V q = z + T(2.485846490142306297962e1);
    q = q * z + T(1.650270098316988542046e2);
    q = q * z + T(4.328810604912902668951e2);
    q = q * z + T(4.853903996359136964868e2);
    q = q * z + T(1.945506571482613964425e2);
    V angle = t + t * (z * p / q);
    angle = select(middle, T(0.78539816339744830962) + angle, angle);
    angle = select(across > along, T(1.57079632679489661923) - angle, angle);
    angle = select(x < zero, T(3.14159265358979323846) - angle, angle);
    return select(y < zero, -angle, angle);
}

TWISTARM_END
