// Chain from screws and home: converts the description of an arm to the form of the kernels.
#pragma once

#include "chain.hpp"
#include "screw_axes.hpp"

TWISTARM_BEGIN

/// An arm as the design writes it: g_st(θ) = Π exp(ξ̂ᵢ (A θ)ᵢ) · home, screws and home both at θ = 0.
struct screw_model {
    int joints, coordinates;
    const double* screws;    ///< (6, joints), row-major: columns ξ = (v, w) in the base frame
    const double* home;      ///< (4, 4), row-major: g_st(0)
    const double* coupling;  ///< A (joints, coordinates), row-major; nullptr for the identity
};

namespace detail {
/// A twist that follows `row` of the coupling, `scale` times as fast.
struct driven_twist {
    double v[3], w[3], scale, row[most_joints];  // scale ≥ 0: a negative multiplier turns the twist round
};

inline driven_twist twist_of(const screw_model& model, int i) {
    driven_twist twist{};
    twist.scale = 1.0;
    for (int k = 0; k < 3; ++k) {
        twist.v[k] = model.screws[k * model.joints + i];
        twist.w[k] = model.screws[(k + 3) * model.joints + i];
    }
    for (int k = 0; k < model.coordinates; ++k)
        twist.row[k] = model.coupling != nullptr ? model.coupling[i * model.coordinates + k] : (i == k ? 1.0 : 0.0);
    return twist;
}

/// A joint that follows one coordinate only takes the multiplier as its scale: exp(ξ̂ (a θ)). Whether it moves at all.
inline bool moves_after_scaling(driven_twist& twist, int coordinates) {
    int followed = 0, last = 0;
    for (int k = 0; k < coordinates; ++k)
        if (twist.row[k] != 0.0) {
            ++followed;
            last = k;
        }
    if (followed != 1) return followed > 0;
    twist.scale = absolute(twist.row[last]);
    for (int k = 0; k < 3 && twist.row[last] < 0.0; ++k) {
        twist.v[k] = -twist.v[k];
        twist.w[k] = -twist.w[k];
    }
    twist.row[last] = 1.0;
    return true;
}

/// Whether two neighbours follow the same coordinates and commute: [ξ₁, ξ₂] = (w₁ × v₂ − w₂ × v₁, w₁ × w₂) = 0. Then
/// exp(ξ̂₁ x) exp(ξ̂₂ x) = exp((ξ₁ + ξ₂)^ x). A turn with a slide along the same axis is one helical joint.
inline bool are_one(const driven_twist& a, const driven_twist& b, int coordinates) {
    for (int k = 0; k < coordinates; ++k)
        if (a.row[k] != b.row[k]) return false;
    double ab[3], ba[3], turning[3];
    cross(a.w, b.v, ab);
    cross(b.w, a.v, ba);
    cross(a.w, b.w, turning);
    for (int k = 0; k < 3; ++k)
        if (absolute(ab[k] - ba[k]) > no_motion || absolute(turning[k]) > no_motion) return false;
    return true;
}

/// a ← a + b, the scales taken into the twists.
inline void add(driven_twist& a, const driven_twist& b) {
    for (int k = 0; k < 3; ++k) {
        a.v[k] = a.scale * a.v[k] + b.scale * b.v[k];
        a.w[k] = a.scale * a.w[k] + b.scale * b.w[k];
    }
    a.scale = 1.0;
}

/// The constant transform between two joint axes as T(offset) Rx(alpha). The remaining turns about z go into the
/// phases.
inline void connect(const frame<double>& between, link<double>& before, link<double>& after) {
    // The third column of Rz(a) Rx(α) Rz(b) is (sin a sin α, −cos a sin α, cos α). With a chosen, b and α follow from
    // Rz(−a) R, so small α cost no digits.
    const bool parallel = absolute(between.z[0]) <= no_motion && absolute(between.z[1]) <= no_motion;
    const double a = parallel ? 0.0 : __builtin_atan2(between.z[0], -between.z[1]);
    const double s = __builtin_sin(a), c = __builtin_cos(a);
    const double b = __builtin_atan2(-(c * between.y[0] + s * between.y[1]), c * between.x[0] + s * between.x[1]);
    const double sine = s * between.z[0] - c * between.z[1];
    const double size = sqrt(sine * sine + between.z[2] * between.z[2]);
    after.sin_alpha = sine / size;
    after.cos_alpha = between.z[2] / size;
    after.offset[0] = c * between.p[0] + s * between.p[1];
    after.offset[1] = c * between.p[1] - s * between.p[0];
    after.offset[2] = between.p[2];
    before.phase += a;
    after.phase += b;
}

/// The number of joints after constant ones are removed and commuting neighbours merged; −1 if there are too many.
inline int gathered_twists(const screw_model& model, driven_twist twists[most_joints]) {
    int count = 0;
    for (int i = 0; i < model.joints; ++i) {
        driven_twist twist = twist_of(model, i);
        if (!moves_after_scaling(twist, model.coordinates)) continue;
        if (count > 0 && are_one(twists[count - 1], twist, model.coordinates)) {
            add(twists[count - 1], twist);
            continue;
        }
        if (count == most_joints) return -1;
        twists[count++] = twist;
    }
    return count;
}

inline bool is_identity(const driven_twist* twists, int joints, int coordinates) {
    if (joints != coordinates) return false;
    for (int i = 0; i < joints; ++i)
        for (int k = 0; k < coordinates; ++k)
            if (twists[i].row[k] != (i == k ? 1.0 : 0.0)) return false;
    return true;
}
}  // namespace detail

/// The chain of an arm; false where it has no coordinates, or more than `most_joints` or joints.
///
/// exp(ξ̂ x) = B J(x) B⁻¹ for each joint (`screw_axis_of`), so the constant transforms are B₁, Bᵢ⁻¹ Bᵢ₊₁, B_M⁻¹ home.
inline bool chain_from_screws(const screw_model& model, chain<double, dynamic, dynamic>& arm) {
    if (model.coordinates < 1 || model.coordinates > most_joints) return false;
    detail::driven_twist twists[most_joints];
    const int joints = detail::gathered_twists(model, twists);
    if (joints < 1) return false;
    arm = {};
    arm.coordinate_count = model.coordinates;
    arm.joint_count = joints;
    arm.identity = detail::is_identity(twists, joints, model.coordinates);
    screw_axis before{identity_frame<double>(), 0.0, 0.0};
    for (int i = 0; i < joints; ++i) {
        const screw_axis screw = screw_axis_of(twists[i].v, twists[i].w, before.axis.p);
        link<double>& now = arm.links[i];
        now.turn = screw.turn * twists[i].scale;
        now.slide = screw.slide * twists[i].scale;
        now.cos_alpha = 1.0;
        if (i == 0) arm.base = screw.axis;
        else detail::connect(product(inverse(before.axis), screw.axis), arm.links[i - 1], now);
        for (int k = 0; k < model.coordinates; ++k) arm.coupling[i][k] = twists[i].row[k];
        before = screw;
    }
    arm.tip = product(inverse(before.axis), frame_from_rows<double>(model.home));
    for (int i = 0; i < joints; ++i) arm.links[i].revolute = arm.links[i].turn == 1.0 && arm.links[i].slide == 0.0;
    return true;
}

TWISTARM_END
