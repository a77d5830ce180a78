// A target built into the chain: its goal becomes the base and the identity the goal. The walk then gives the error.
#pragma once

#include "../kinematics/chain.hpp"
#include "target.hpp"

TWISTARM_BEGIN

/// The base and tip with which the walk along a chain ends at the identity if the target is reached.
///
/// pose, task: g_goal⁻¹ · g_st. task in base axes: T(−p) · g_st · R_goalᵀ, with the rotation R R_goalᵀ. position and
/// approach: the origin at p. approach also turns z along the direction before and along the tool axis after, so that
/// the last z column is (0, 0, 1) if the target is reached.
template <class V> struct aim {
    frame<V> base, tip;
    V tolerance[6];
};

namespace detail {
/// A rotation with the unit vector `axis` as z column.
template <class T> inline frame<T> rotation_onto(const T axis[3]) {
    frame<T> g = identity_frame<T>();
    int smallest = 0;
    for (int k = 1; k < 3; ++k)
        if (absolute(axis[k]) < absolute(axis[smallest])) smallest = k;
    T across[3] = {T(0), T(0), T(0)};
    across[smallest] = T(1);
    cross(across, axis, g.x);
    const T size = sqrt(dot(g.x, g.x));
    for (int k = 0; k < 3; ++k) {
        g.x[k] /= size;
        g.z[k] = axis[k];
    }
    cross(g.z, g.x, g.y);
    return g;
}
}  // namespace detail

/// The aim of a target for a chain.
template <class T, int N, int M> aim<T> aim_at(const chain<T, N, M>& arm, const target<T>& asked) {
    frame<T> before = identity_frame<T>(), behind = identity_frame<T>();
    if (asked.kind == target_kind::pose || (asked.kind == target_kind::task && !asked.base_axes)) before = asked.goal;
    if (asked.kind == target_kind::approach) {
        before = detail::rotation_onto(asked.direction);
        behind = detail::rotation_onto(asked.tool_axis);
    }
    if (asked.kind == target_kind::task && asked.base_axes) {
        behind = asked.goal;
        for (T& component : behind.p) component = T(0);
        behind = inverse(behind);
    }
    for (int k = 0; k < 3; ++k) before.p[k] = asked.goal.p[k];
    const bool rotated = asked.kind == target_kind::approach || (asked.kind == target_kind::task && asked.base_axes);
    aim<T> aimed{product(inverse(before), arm.base), rotated ? product(arm.tip, behind) : arm.tip, {}};
    for (int k = 0; k < 6; ++k) aimed.tolerance[k] = asked.tolerance[k];
    return aimed;
}

/// One lane of an aim of packs.
template <class V, class T> TWISTARM_INLINE void set_lane(aim<V>& aims, int i, const aim<T>& value) {
    set_lane(aims.base, i, value.base);
    set_lane(aims.tip, i, value.tip);
    for (int k = 0; k < 6; ++k) set_lane(aims.tolerance[k], i, value.tolerance[k]);
}

/// The same aim in every lane.
template <class V, class T> TWISTARM_INLINE aim<V> aim_in_every_lane(const aim<T>& value) {
    aim<V> aims;
    aims.base = converted<V>(value.base);
    aims.tip = converted<V>(value.tip);
    for (int k = 0; k < 6; ++k) aims.tolerance[k] = V(value.tolerance[k]);
    return aims;
}

TWISTARM_END
