// Second-order expansion of a rotation error as the tool turns.
#pragma once

#include "aim.hpp"
#include "residual.hpp"

TWISTARM_BEGIN

/// A function f of the rotation R at the end of the walk that grows with the angle to the target.
///
/// If joints i ≤ j of a chain turn the tool about wᵢ and wⱼ, in fixed axes, then ∂f/∂θᵢ = slope · wᵢ and ∂²f/∂θᵢ∂θⱼ =
/// wⱼ · curvature wᵢ, because ∂wⱼ/∂θᵢ = wᵢ × wⱼ.
template <class V> struct turning {
    V value, slope[3], curvature[3][3];
};

namespace detail {
/// 1 − cos φ = sin² φ/(1 + cos φ), which keeps its digits near 0; from the cosine alone beyond 90°.
template <class V> TWISTARM_INLINE V one_less_cosine(const V& cosine, const V& sine_squared) {
    const V one = V(scalar_of<V>(1)), zero = V(scalar_of<V>(0));
    return select(cosine > zero, sine_squared / (one + greatest(cosine, zero)), one - cosine);
}

/// pose: f = 1 − cos φ = ½ (3 − tr R).
///
/// ∂R/∂θᵢ = ŵᵢ R and ∂²R/∂θᵢ∂θⱼ = ŵᵢ ŵⱼ R. The trace of the latter is wᵢᵀ R wⱼ − wᵢᵀwⱼ tr R.
template <class V> TWISTARM_INLINE void turning_to_pose(const frame<V>& R, turning<V>& out) {
    using T = scalar_of<V>;
    const V* columns[3] = {R.x, R.y, R.z};
    const V trace = R.x[0] + R.y[1] + R.z[2];
    const V w[3] = {R.y[2] - R.z[1], R.z[0] - R.x[2], R.x[1] - R.y[0]};
    out.value = one_less_cosine(T(0.5) * (trace - T(1)), T(0.25) * dot(w, w));
    for (int a = 0; a < 3; ++a) {
        out.slope[a] = T(0.5) * w[a];
        for (int b = 0; b < 3; ++b)
            out.curvature[a][b] = T(0.5) * ((a == b ? trace : V(T(0))) - columns[a][b]);
    }
}

/// approach: f = 1 − cos φ = 1 − d · a with d = (0, 0, 1) and a the z column; ∂²a/∂θᵢ∂θⱼ = wᵢ × (wⱼ × a).
template <class V> TWISTARM_INLINE void turning_to_axis(const V a[3], turning<V>& out) {
    using T = scalar_of<V>;
    out.value = one_less_cosine(a[2], a[0] * a[0] + a[1] * a[1]);
    out.slope[0] = -a[1];
    out.slope[1] = a[0];
    out.slope[2] = V(T(0));
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            out.curvature[r][c] = (r == c ? a[2] : V(T(0))) - (r == 2 ? a[c] : V(T(0)));
}

/// c'(φ)/φ of the c in `logarithm_of_chord`, from φ² and c; → 1/360 + φ²/7560 near 0.
///
/// cot(φ/2)/(2φ) = 1/φ² − c and 1/sin² = 1 + cot², so c' = −1/φ³ − c/φ + (1 + cot²(φ/2))/(4φ).
template <class V> TWISTARM_INLINE V growth_of_c(const V& squared, const V& c) {
    using T = scalar_of<V>;
    const auto small = squared < V(T(sizeof(T) == 8 ? 1e-3 : 4e-2));
    const V safe = select(small, V(T(1)), squared), inverse = T(1) / safe;
    const V half_cotangent = inverse - c;  // cot(φ/2)/(2φ)
    const V exact = T(0.25) * inverse + half_cotangent * half_cotangent - inverse * (inverse + c);
    return select(small, T(1.0 / 360.0) + squared * T(1.0 / 7560.0), exact);
}

/// task: f = ½ ‖X‖² with X the part of φ = log R beyond the tolerances; dφ/dt = J_l⁻¹(φ) ω.
///
/// X · ∂²φ/∂θᵢ∂θⱼ = X · (∂J_l⁻¹/∂φ [δ] wⱼ + J_l⁻¹ (wᵢ × wⱼ)) with δ = J_l⁻¹ wᵢ. With J_l⁻¹ ω = ω − ½ φ × ω + c φ × (φ ×
/// ω), every term is wⱼ times a vector that is linear in wᵢ.
template <class V> TWISTARM_INLINE void turning_to_task(const frame<V>& R, const V tolerance[3], turning<V>& out) {
    using T = scalar_of<V>;
    V phi[3], X[3], held[3], X_phi[3], X_phi_phi[3];
    chord_of(R, phi);
    const V c = logarithm_of_chord(phi), growth = growth_of_c(dot(phi, phi), c);
    for (int k = 0; k < 3; ++k) {
        X[k] = beyond(phi[k], tolerance[k]);
        held[k] = select(is_active(X[k], tolerance[k]), V(T(1)), V(T(0)));
    }
    out.value = T(0.5) * dot(X, X);
    cross(X, phi, X_phi);
    cross(X_phi, phi, X_phi_phi);
    for (int k = 0; k < 3; ++k) out.slope[k] = X[k] - T(0.5) * X_phi[k] + c * X_phi_phi[k];
    for (int i = 0; i < 3; ++i) {
        V w[3], delta[3], pulled[3], once[3], twice[3], X_delta[3], X_delta_phi[3], X_phi_delta[3], turned[3];
        for (int k = 0; k < 3; ++k) w[k] = V(T(k == i ? 1 : 0));
        logarithm_rate(phi, c, w, delta);
        for (int k = 0; k < 3; ++k) pulled[k] = held[k] * delta[k];
        cross(pulled, phi, once);
        cross(once, phi, twice);
        cross(X, delta, X_delta);
        cross(X_delta, phi, X_delta_phi);
        cross(X_phi, delta, X_phi_delta);
        cross(out.slope, w, turned);
        const V along = growth * dot(phi, delta);
        for (int k = 0; k < 3; ++k)
            out.curvature[k][i] = pulled[k] - T(0.5) * (once[k] + X_delta[k]) +
                                  c * (twice[k] + X_delta_phi[k] + X_phi_delta[k]) + along * X_phi_phi[k] + turned[k];
    }
}
}  // namespace detail

/// `turning` of a target of this kind at the end g of a walk to its aim.
template <class V>
TWISTARM_INLINE void turning_at(target_kind kind, const frame<V>& g, const aim<V>& aims, turning<V>& out) {
    if (kind == target_kind::pose) detail::turning_to_pose(g, out);
    else if (kind == target_kind::approach) detail::turning_to_axis(g.z, out);
    else if (kind == target_kind::task) detail::turning_to_task(g, aims.tolerance + 3, out);
    else out = {};
}

TWISTARM_END
