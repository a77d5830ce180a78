// Forward kinematics and Jacobians of a chain, for one configuration or a pack of them.
#pragma once

#include "chain.hpp"
#include "../numeric/elementary.hpp"

TWISTARM_BEGIN

/// One column of a Jacobian, (v, w): what a coordinate's rate does to the tool.
template <class V> struct column {
    V v[3], w[3];
};

namespace detail {
/// The next joint: g ← g T(offset) Rx(alpha) Rz(turn x + phase) Tz(slide x). The first joint has no link before it.
template <class V, class T> TWISTARM_INLINE void step_through(const link<T>& joint, bool first, const V& x, frame<V>& g) {
    V s, c;
    sincos(joint.revolute ? x + joint.phase : x * joint.turn + joint.phase, s, c);
    if (!first)
        TWISTARM_UNROLL
        for (int k = 0; k < 3; ++k) {
            g.p[k] = g.p[k] + (g.x[k] * joint.offset[0] + g.y[k] * joint.offset[1] + g.z[k] * joint.offset[2]);
            const V y = g.y[k] * joint.cos_alpha + g.z[k] * joint.sin_alpha;
            g.z[k] = g.z[k] * joint.cos_alpha - g.y[k] * joint.sin_alpha;
            g.y[k] = y;
        }
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) {
        const V rotated = c * g.x[k] + s * g.y[k];
        g.y[k] = c * g.y[k] - s * g.x[k];
        g.x[k] = rotated;
    }
    if (!joint.revolute) {
        const V along = x * joint.slide;
        TWISTARM_UNROLL
        for (int k = 0; k < 3; ++k) g.p[k] = g.p[k] + g.z[k] * along;
    }
}

/// The joint values x = A θ.
template <class V, class T, int N, int M>
TWISTARM_INLINE void joint_values(const chain<T, N, M>& arm, const V* theta, V* x) {
    const int joints = arm.joints();
    if (N == M && arm.identity) {
        TWISTARM_UNROLL
        for (int i = 0; i < joints; ++i) x[i] = theta[i];
        return;
    }
    for (int i = 0; i < joints; ++i) {
        x[i] = V(T(0));
        for (int k = 0; k < arm.coordinates(); ++k) x[i] = x[i] + theta[k] * arm.coupling[i][k];
    }
}

/// The tool's velocity if joint i alone moves at rate 1: (turn z × (p − o) + slide z, turn z), with z and o its axis.
template <class V, class T>
TWISTARM_INLINE void joint_column(const link<T>& joint, const V p[3], const V z[3], const V o[3], column<V>& out) {
    const V arm[3] = {p[0] - o[0], p[1] - o[1], p[2] - o[2]};
    cross(z, arm, out.v);
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) out.w[k] = z[k];
    if (!joint.revolute)
        TWISTARM_UNROLL
        for (int k = 0; k < 3; ++k) {
            out.v[k] = out.v[k] * joint.turn + z[k] * joint.slide;
            out.w[k] = out.w[k] * joint.turn;
        }
}
}  // namespace detail

/// base · J₁ ⋯ J_M · tip at θ, `base` and `tip` in place of the chain's own.
template <class V, class T, int N, int M>
TWISTARM_CALLED void walk(const chain<T, N, M>& arm, const frame<V>& base, const frame<V>& tip, const V* theta, frame<V>& g) {
    const int joints = arm.joints();
    V x[capacity(M)];
    detail::joint_values(arm, theta, x);
    g = base;
    TWISTARM_UNROLL
    for (int i = 0; i < joints; ++i) detail::step_through(arm.links[i], i == 0, x[i], g);
    g = product(g, tip);
}

/// `walk`, and the tool's velocity for each of the M joints: of its origin and angular, in base axes.
template <class V, class T, int N, int M>
TWISTARM_CALLED void walk_with_joint_columns(const chain<T, N, M>& arm, const frame<V>& base, const frame<V>& tip,
                                             const V* theta, frame<V>& g, column<V>* moved) {
    const int joints = arm.joints();
    V x[capacity(M)], axis[capacity(M)][3], origin[capacity(M)][3];
    detail::joint_values(arm, theta, x);
    g = base;
    TWISTARM_UNROLL
    for (int i = 0; i < joints; ++i) {
        detail::step_through(arm.links[i], i == 0, x[i], g);
        TWISTARM_UNROLL
        for (int k = 0; k < 3; ++k) {
            axis[i][k] = g.z[k];
            origin[i][k] = g.p[k];
        }
    }
    g = product(g, tip);
    TWISTARM_UNROLL
    for (int i = 0; i < joints; ++i) detail::joint_column(arm.links[i], g.p, axis[i], origin[i], moved[i]);
}

/// `walk`, and the hybrid Jacobian's N columns: velocity of the tool's origin and angular velocity, in base axes.
template <class V, class T, int N, int M>
TWISTARM_INLINE void walk_with_columns(const chain<T, N, M>& arm, const frame<V>& base, const frame<V>& tip,
                                       const V* theta, frame<V>& g, column<V>* columns) {
    if (N == M && arm.identity) {
        walk_with_joint_columns(arm, base, tip, theta, g, columns);
        return;
    }
    column<V> moved[capacity(M)];
    walk_with_joint_columns(arm, base, tip, theta, g, moved);
    for (int k = 0; k < arm.coordinates(); ++k)
        for (int r = 0; r < 3; ++r) columns[k].v[r] = columns[k].w[r] = V(T(0));
    for (int i = 0; i < arm.joints(); ++i)
        for (int k = 0; k < arm.coordinates(); ++k)
            if (arm.coupling[i][k] != T(0))
                for (int r = 0; r < 3; ++r) {
                    columns[k].v[r] = columns[k].v[r] + moved[i].v[r] * arm.coupling[i][k];
                    columns[k].w[r] = columns[k].w[r] + moved[i].w[r] * arm.coupling[i][k];
                }
}

/// g_st(θ), θ (N,) [rad or m].
template <class V, class T, int N, int M> TWISTARM_INLINE frame<V> forward(const chain<T, N, M>& arm, const V* theta) {
    frame<V> g;
    walk(arm, converted<V>(arm.base), converted<V>(arm.tip), theta, g);
    return g;
}

/// A column of the hybrid Jacobian as one of the body Jacobian J^b: V^b = J^b dθ/dt = (Rᵀ ṗ, Rᵀ ω). MLS §3.4.1.
template <class V> TWISTARM_INLINE column<V> body_column(const frame<V>& g, const column<V>& hybrid) {
    column<V> moved;
    rotate_back(g, hybrid.v, moved.v);
    rotate_back(g, hybrid.w, moved.w);
    return moved;
}

/// The same as one of the spatial Jacobian J^s: V^s = J^s dθ/dt = (ṗ + p × ω, ω). MLS §3.4.1.
template <class V> TWISTARM_INLINE column<V> spatial_column(const frame<V>& g, const column<V>& hybrid) {
    column<V> moved = hybrid;
    V moment[3];
    cross(g.p, hybrid.w, moment);
    for (int k = 0; k < 3; ++k) moved.v[k] = moved.v[k] + moment[k];
    return moved;
}

/// g_st(θ) and the hybrid Jacobian's N columns.
template <class V, class T, int N, int M>
TWISTARM_INLINE frame<V> forward_with_columns(const chain<T, N, M>& arm, const V* theta, column<V>* J) {
    frame<V> g;
    walk_with_columns(arm, converted<V>(arm.base), converted<V>(arm.tip), theta, g, J);
    return g;
}

/// g_st(θ) and the body Jacobian (6, N) by columns.
template <class V, class T, int N, int M>
TWISTARM_INLINE frame<V> forward_with_body_jacobian(const chain<T, N, M>& arm, const V* theta, column<V>* J) {
    const frame<V> g = forward_with_columns(arm, theta, J);
    for (int i = 0; i < arm.coordinates(); ++i) J[i] = body_column(g, J[i]);
    return g;
}

/// g_st(θ) and the spatial Jacobian (6, N) by columns.
template <class V, class T, int N, int M>
TWISTARM_INLINE frame<V> forward_with_spatial_jacobian(const chain<T, N, M>& arm, const V* theta, column<V>* J) {
    const frame<V> g = forward_with_columns(arm, theta, J);
    for (int i = 0; i < arm.coordinates(); ++i) J[i] = spatial_column(g, J[i]);
    return g;
}

TWISTARM_END
