// A serial chain as constant transforms between joints that turn about and slide along their own z axis.
#pragma once

#include "frame.hpp"

TWISTARM_BEGIN

/// In place of a number of joints: known only when the program runs, at most `most_joints`.
constexpr int dynamic = 0;
constexpr int most_joints = 64;

constexpr int capacity(int size) { return size == dynamic ? most_joints : size; }

/// One joint and the constant transform before it: T(offset) Rx(alpha) · Rz(turn x + phase) Tz(slide x).
///
/// A revolute joint has turn 1 and slide 0 [m/rad], a prismatic one turn 0 and slide 1, a helical one turn 1 and its
/// pitch as slide. Any constant rotation is Rz Rx Rz, and a turn about z commutes with the joint. So the phases hold
/// both Rz.
template <class T> struct link {
    T offset[3], cos_alpha, sin_alpha;
    T turn, phase, slide;
    bool revolute;
};

/// g_st(θ) = base · J₁(x₁) · L₂ J₂(x₂) ⋯ L_M J_M(x_M) · tip with x = A θ.
///
/// N coordinates θ, M joints; where every coordinate is one joint, `identity` holds and `coupling` (A) is not read.
/// The first link's offset and alpha are part of `base`.
/// What x = A θ + b adds as b is in the screws and in home, which are those at θ = 0.
template <class T, int N, int M = N> struct chain {
    int coordinate_count, joint_count;
    bool identity;
    frame<T> base, tip;
    link<T> links[capacity(M)];
    T coupling[capacity(M)][capacity(N)];

    constexpr int coordinates() const { return N == dynamic ? coordinate_count : N; }
    constexpr int joints() const { return M == dynamic ? joint_count : M; }
};

/// The chain with a tool in its tip: g_st' = g_st · tool.
template <class T, int N, int M> chain<T, N, M> with_tool(const chain<T, N, M>& arm, const frame<T>& tool) {
    chain<T, N, M> extended = arm;
    extended.tip = product(arm.tip, tool);
    return extended;
}

/// Whether a chain with run-time sizes has N coordinates, M joints and a coupling that the template can hold.
template <int N, int M, class S> bool fits(const chain<S, dynamic, dynamic>& arm) {
    if (N != dynamic && arm.coordinate_count != N) return false;
    return M == dynamic || (arm.joint_count == M && (N != M || arm.identity));
}

/// A chain known at run time as one of fixed size, or in another precision; `fits<N, M>(arm)` must hold.
template <class T, int N, int M, class S> chain<T, N, M> narrowed(const chain<S, dynamic, dynamic>& arm) {
    chain<T, N, M> fixed{};
    fixed.coordinate_count = arm.coordinate_count;
    fixed.joint_count = arm.joint_count;
    fixed.identity = arm.identity;
    fixed.base = converted<T>(arm.base);
    fixed.tip = converted<T>(arm.tip);
    for (int i = 0; i < arm.joint_count; ++i) {
        const link<S>& from = arm.links[i];
        link<T>& to = fixed.links[i];
        for (int k = 0; k < 3; ++k) to.offset[k] = static_cast<T>(from.offset[k]);
        to.cos_alpha = static_cast<T>(from.cos_alpha);
        to.sin_alpha = static_cast<T>(from.sin_alpha);
        to.turn = static_cast<T>(from.turn);
        to.phase = static_cast<T>(from.phase);
        to.slide = static_cast<T>(from.slide);
        to.revolute = from.revolute;
        for (int k = 0; k < arm.coordinate_count; ++k) fixed.coupling[i][k] = static_cast<T>(arm.coupling[i][k]);
    }
    return fixed;
}

TWISTARM_END
