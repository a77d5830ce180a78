// A target's error and its rows: what the damped search makes vanish.
#pragma once

#include "aim.hpp"
#include "../kinematics/kinematics.hpp"

TWISTARM_BEGIN

/// Error e and rows J with de = J dθ for the constrained components, rotations weighed by `rotation_scale`.
///
/// A component that is free or within its tolerance has zero rows and zero error.
template <class V, int N, int K> struct residual {
    V J[capacity(N)][K], e[K];
    V position_squared, rotation_squared;  ///< unweighed: [m²], and chord² or [rad²]
};

namespace detail {
/// Keeps the length of an error of zero from dividing by zero [m²].
template <class T> constexpr T least_length = T(sizeof(T) == 8 ? 1e-30 : 1e-20);

/// For a smaller 1 + trace, R − Rᵀ has lost half of its digits, and R + Rᵀ gives the axis.
template <class T> constexpr T near_half_turn = T(sizeof(T) == 8 ? 1e-6 : 1e-2);

/// The longest column of (R + Rᵀ)/2 − cos φ I = (1 − cos φ) u uᵀ, brought to the length of the chord.
template <class V> __attribute__((noinline, cold)) void chord_near_half_turn(const frame<V>& R, V chord[3]) {
    using T = scalar_of<V>;
    const V trace = R.x[0] + R.y[1] + R.z[2];
    const V yx = T(0.5) * (R.x[1] + R.y[0]), zx = T(0.5) * (R.x[2] + R.z[0]), zy = T(0.5) * (R.y[2] + R.z[1]);
    const V cosine = T(0.5) * (trace - T(1));
    V u[3] = {R.x[0] - cosine, yx, zx}, largest = R.x[0];
    const auto y_longer = R.y[1] > largest;
    const V second[3] = {yx, R.y[1] - cosine, zy}, third[3] = {zx, zy, R.z[2] - cosine};
    largest = greatest(largest, R.y[1]);
    const auto z_longer = R.z[2] > largest;
    for (int k = 0; k < 3; ++k) u[k] = select(z_longer, third[k], select(y_longer, second[k], u[k]));
    const V scale = sqrt((T(3) - trace) / dot(u, u));
    const V w[3] = {R.y[2] - R.z[1], R.z[0] - R.x[2], R.x[1] - R.y[0]};
    const V sign = select(dot(u, w) < V(T(0)), V(T(-1)), V(T(1)));
    const auto near = trace + T(1) < V(near_half_turn<T>);
    for (int k = 0; k < 3; ++k) chord[k] = select(near, u[k] * scale * sign, chord[k]);
}

/// 2 sin(φ/2) u of the rotation R by φ about u: (R − Rᵀ)^∨ / √(1 + tr R), without an arc tangent.
///
/// dφ/dt = u · ω, so Jᵀ chord is the gradient of 4 (1 − cos φ/2). It grows with φ up to half a turn, where the sign of
/// u is arbitrary.
template <class V> TWISTARM_INLINE void chord_of(const frame<V>& R, V chord[3]) {
    using T = scalar_of<V>;
    const V stretched = R.x[0] + R.y[1] + R.z[2] + T(1);
    const auto near = stretched < V(near_half_turn<T>);
    const V scale = T(1) / sqrt(greatest(stretched, V(near_half_turn<T>)));
    chord[0] = (R.y[2] - R.z[1]) * scale;
    chord[1] = (R.z[0] - R.x[2]) * scale;
    chord[2] = (R.x[1] - R.y[0]) * scale;
    if (__builtin_expect(any(near), 0)) chord_near_half_turn(R, chord);
}

/// chord → φ u, and c with J_l⁻¹(φ u) = I − φ̂/2 + c φ̂², c = 1/φ² − cot(φ/2)/(2φ) → 1/12 + φ²/720 near 0.
///
/// d log(R)/dt = J_l⁻¹(log R) ω, ω in the axes that stand still. Source: G. Chirikjian, Stochastic Models, Information
/// Theory, and Lie Groups, vol. 2, 2012, §10.8.
template <class V> TWISTARM_INLINE V logarithm_of_chord(V chord[3]) {
    using T = scalar_of<V>;
    const V sine = least(sqrt(T(0.25) * dot(chord, chord)), V(T(1)));
    const V angle = T(2) * arcsine(sine);
    const auto small = sine < V(T(sizeof(T) == 8 ? 1e-4 : 1e-2));
    const V safe_sine = select(small, V(T(1)), sine), safe_angle = select(small, V(T(1)), angle);
    const V ratio = select(small, T(1) + sine * sine * T(1.0 / 6.0), T(0.5) * angle / safe_sine);
    for (int k = 0; k < 3; ++k) chord[k] = chord[k] * ratio;
    const V cotangent = sqrt(greatest(T(1) - sine * sine, V(T(0)))) / safe_sine;
    const V exact = (T(1) / safe_angle - T(0.5) * cotangent) / safe_angle;
    return select(small, T(1.0 / 12.0) + angle * angle * T(1.0 / 720.0), exact);
}

/// ω → J_l⁻¹(φ) ω = ω − ½ φ × ω + c φ × (φ × ω).
template <class V> TWISTARM_INLINE void logarithm_rate(const V phi[3], const V& c, const V omega[3], V rate[3]) {
    V once[3], twice[3];
    cross(phi, omega, once);
    cross(phi, once, twice);
    for (int k = 0; k < 3; ++k) rate[k] = omega[k] - scalar_of<V>(0.5) * once[k] + c * twice[k];
}

/// The error across the tool axis z, and its scale: 2 sin(φ/2) u of the turn from (0, 0, 1) to z, along x and y.
///
/// (0, 0, 1) × z has the components y₃ and −x₃ along x and y, and the length sin φ = 2 sin(φ/2) cos(φ/2).
template <class V> TWISTARM_INLINE void error_across(const frame<V>& g, V& along_x, V& along_y) {
    using T = scalar_of<V>;
    const V stretched = T(1) + g.z[2];
    const auto opposite = stretched < V(T(1e-3));
    V scale = sqrt(T(2) / greatest(stretched, V(T(1e-3))));
    along_x = g.y[2];
    along_y = -g.x[2];
    if (__builtin_expect(any(opposite), 0)) {
        const V squared = along_x * along_x + along_y * along_y;
        const auto lost = squared <= V(T(1e-30));
        scale = select(opposite, sqrt(T(2) * (T(1) - g.z[2]) / select(lost, V(T(1)), squared)), scale);
        along_x = select(opposite & lost, V(T(1)), along_x);
    }
    along_x = along_x * scale;
    along_y = along_y * scale;
}

/// The part of an error beyond its tolerance. `active` is set if there is one, or if the tolerance is zero.
template <class V> TWISTARM_INLINE V beyond(const V& error, const V& tolerance) {
    return error - clamped(error, -tolerance, tolerance);
}
template <class V> TWISTARM_INLINE auto is_active(const V& excess, const V& tolerance) {
    const V zero = V(scalar_of<V>(0));
    return (excess < zero) | (excess > zero) | (tolerance <= zero);
}
}  // namespace detail

/// The error where the walk has ended at g, and its rows from the hybrid Jacobian's columns.
template <target_kind Kind, int N, class V>
TWISTARM_INLINE void residual_of(const frame<V>& g, const column<V>* columns, int n, const aim<V>& aims,
                                 scalar_of<V> rotation_scale, residual<V, N, rows_of(Kind)>& out) {
    using T = scalar_of<V>;
    const V zero = V(T(0));
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) out.e[k] = g.p[k];
    if constexpr (Kind != target_kind::task) {
        out.position_squared = dot(g.p, g.p);
        TWISTARM_UNROLL
        for (int i = 0; i < n; ++i)
            TWISTARM_UNROLL
            for (int k = 0; k < 3; ++k) out.J[i][k] = columns[i].v[k];
    }
    if constexpr (Kind == target_kind::position) out.rotation_squared = zero;
    if constexpr (Kind == target_kind::pose) {
        V chord[3];
        detail::chord_of(g, chord);
        out.rotation_squared = dot(chord, chord);
        TWISTARM_UNROLL
        for (int k = 0; k < 3; ++k) out.e[k + 3] = rotation_scale * chord[k];
        TWISTARM_UNROLL
        for (int i = 0; i < n; ++i)
            TWISTARM_UNROLL
            for (int k = 0; k < 3; ++k) out.J[i][k + 3] = rotation_scale * columns[i].w[k];
    }
    if constexpr (Kind == target_kind::approach) {
        V along_x, along_y, x[3], y[3];
        detail::error_across(g, along_x, along_y);
        out.rotation_squared = along_x * along_x + along_y * along_y;
        out.e[3] = rotation_scale * along_x;
        out.e[4] = rotation_scale * along_y;
        for (int k = 0; k < 3; ++k) {
            x[k] = rotation_scale * g.x[k];
            y[k] = rotation_scale * g.y[k];
        }
        TWISTARM_UNROLL
        for (int i = 0; i < n; ++i) {
            out.J[i][3] = dot(x, columns[i].w);
            out.J[i][4] = dot(y, columns[i].w);
        }
    }
    if constexpr (Kind == target_kind::task) {
        V phi[3];
        detail::chord_of(g, phi);
        const V c = detail::logarithm_of_chord(phi);
        V error[6], away[3], turned[3];
        for (int k = 0; k < 3; ++k) {
            away[k] = error[k] = detail::beyond(g.p[k], aims.tolerance[k]);
            turned[k] = error[k + 3] = detail::beyond(phi[k], aims.tolerance[k + 3]);
        }
        out.position_squared = dot(away, away);
        out.rotation_squared = dot(turned, turned);
        for (int k = 0; k < 6; ++k) out.e[k] = k < 3 ? error[k] : rotation_scale * error[k];
        for (int i = 0; i < n; ++i) {
            V rate[3];
            detail::logarithm_rate(phi, c, columns[i].w, rate);
            for (int k = 0; k < 3; ++k) {
                out.J[i][k] = select(detail::is_active(error[k], aims.tolerance[k]), columns[i].v[k], zero);
                out.J[i][k + 3] = select(detail::is_active(error[k + 3], aims.tolerance[k + 3]),
                                         rotation_scale * rate[k], zero);
            }
        }
    }
}

/// Takes out of an error what a tolerance allows, and out of its rows what that leaves free.
///
/// Rows first to last with r = ‖e‖ beyond the radius ρ keep (1 − ρ/r) e, with the derivative (1 − ρ/r) J + (ρ/r) u uᵀ
/// J, u = e/r. Within ρ nothing remains. Returns the square of the rest.
template <class V, int N, int K>
TWISTARM_INLINE V allow(residual<V, N, K>& at, int first, int last, scalar_of<V> radius, int n) {
    using T = scalar_of<V>;
    const V zero = V(T(0));
    V squared = zero;
    for (int k = first; k < last; ++k) squared = squared + at.e[k] * at.e[k];
    const V length = sqrt(greatest(squared, V(radius * radius + detail::least_length<T>)));
    const V kept = greatest(T(1) - radius / length, zero);
    const auto outside = squared > V(radius * radius);
    V u[K];
    for (int k = first; k < last; ++k) {
        u[k] = at.e[k] / length;
        at.e[k] = select(outside, kept * at.e[k], zero);
    }
    for (int i = 0; i < n; ++i) {
        V along = zero;
        for (int k = first; k < last; ++k) along = along + u[k] * at.J[i][k];
        for (int k = first; k < last; ++k)
            at.J[i][k] = select(outside, kept * at.J[i][k] + (T(1) - kept) * along * u[k], zero);
    }
    return select(outside, kept * kept * squared, zero);
}

TWISTARM_END
