// Lexicographic cost F = f₁ + ε (f₂ + ν f₃), with its gradient and full Hessian. Each level is minimised as far as the
// one before allows.
#pragma once

#include "../numeric/definite.hpp"
#include "../kinematics/kinematics.hpp"
#include "ranges.hpp"
#include "turning.hpp"

TWISTARM_BEGIN

/// nearest: f₁ = ½ ‖position error‖², f₂ = the rotation's. both: f₁ is both, f₂ nothing.
enum class levels { nearest, both };

/// What the rotation counts beside a squared metre where both belong to the first level.
template <class T> constexpr T rotation_beside_position = T(0.4);

/// Where the walk has ended, to second order: the errors and what the joints do to them.
template <class V, int M> struct local_errors {
    column<V> moved[capacity(M)];
    V p[3];              ///< where the tool's origin is, from where it should be [m]
    V away[3], held[3];  ///< p beyond its tolerance [m], and 1 for components that are held
    V position;          ///< ½ ‖away‖²
    turning<V> rotation_level;
    V off[capacity(M)];  ///< θ − θ_near, or what of θ lies outside its limits, where that counts
    V departure;         ///< f₃ = ½ ‖off‖²
};

/// F = f₁ + ε (f₂ + ν f₃) for one target. f₃ is ½ ‖θ − θ_near‖² if θ_near (n,) is given, and ½ ‖θ − θ clipped to the
/// limits‖² if limits are.
template <class V, class T, int N, int M> struct two_levels {
    const chain<T, N, M>& arm;
    target_kind kind;
    aim<V> aims;
    levels order = levels::nearest;
    const T* near = nullptr;  ///< θ_near
    T nu = T(0);
    const ranges<T, N>* limits = nullptr;

    TWISTARM_INLINE V rotation_weight(const V& epsilon) const {
        return order == levels::nearest ? epsilon : V(rotation_beside_position<T>);
    }

    /// The errors at θ.
    TWISTARM_INLINE void look(const V* theta, local_errors<V, M>& at) const {
        frame<V> g;
        walk_with_joint_columns(arm, aims.base, aims.tip, theta, g, at.moved);
        beyond(g.p, at.away);
        for (int k = 0; k < 3; ++k) {
            at.p[k] = g.p[k];
            at.held[k] = V(T(1));
            if (kind == target_kind::task)
                at.held[k] = select(detail::is_active(at.away[k], aims.tolerance[k]), V(T(1)), V(T(0)));
        }
        at.position = T(0.5) * dot(at.away, at.away);
        turning_at(kind, g, aims, at.rotation_level);
        at.departure = V(T(0));
        if (!departs()) return;
        for (int i = 0; i < arm.coordinates(); ++i) {
            at.off[i] = theta[i] - (limits == nullptr ? V(near[i])
                                                      : clamped(theta[i], V(limits->lower[i]), V(limits->upper[i])));
            at.departure = at.departure + T(0.5) * at.off[i] * at.off[i];
        }
    }

    /// What of the position p (3,) is beyond its tolerance.
    TWISTARM_INLINE void beyond(const V* p, V* away) const {
        for (int k = 0; k < 3; ++k)
            away[k] = kind == target_kind::task ? detail::beyond(p[k], aims.tolerance[k]) : p[k];
    }

    /// Holds at the edge of its tolerance what was `expected` (3,) beyond it but came out inside. If it were free, the
    /// next step would leave the tolerance again. An active set by the sign of the multiplier (J. Nocedal & S. Wright,
    /// Numerical Optimization, 2nd ed., §16.5).
    TWISTARM_INLINE void hold_at_edges(const V* expected, local_errors<V, M>& at) const {
        if (kind != target_kind::task) return;
        for (int k = 0; k < 3; ++k) {
            const V over = detail::beyond(expected[k], aims.tolerance[k]);
            const auto led_out = ((over < V(T(0))) | (over > V(T(0)))) & (at.held[k] <= V(T(0)));
            at.away[k] = select(led_out, at.p[k] - (expected[k] - over), at.away[k]);
            at.held[k] = select(led_out, V(T(1)), at.held[k]);
        }
    }

    /// F at θ.
    TWISTARM_INLINE V value(const local_errors<V, M>& at, const V& epsilon) const {
        return at.position + rotation_weight(epsilon) * at.rotation_level.value + epsilon * nu * at.departure;
    }

    /// ∇F (n,) and the lower triangle of F's Hessian at θ, by joints. With vⱼ and wⱼ the velocities that joint j gives
    /// the tool, ∂vⱼ/∂θᵢ = wᵢ × vⱼ for i ≤ j and all joint types. `pull` (3,) [m] is the position error that weights
    /// the curvature of the tool's path.
    TWISTARM_INLINE void slopes(const local_errors<V, M>& at, const V& epsilon, const V* pull, V* g, V* H) const {
        if (N == M && arm.identity) by_joints(at, epsilon, pull, g, H);
        else by_coordinates(at, epsilon, pull, g, H);
        if (!departs()) return;
        const V zero = V(T(0));
        for (int i = 0; i < arm.coordinates(); ++i) {
            g[i] = g[i] + epsilon * nu * at.off[i];
            const auto flat = (at.off[i] >= zero) & (at.off[i] <= zero);
            const V curvature = limits == nullptr ? V(nu) : select(flat, zero, V(nu));
            H[in_triangle(i, i)] = H[in_triangle(i, i)] + epsilon * curvature;
        }
    }

    /// How the tool's origin is moved (3,) by a step d (n,), to first order.
    TWISTARM_INLINE void move(const local_errors<V, M>& at, const V* d, V* moved) const {
        V x[capacity(M)];
        detail::joint_values(arm, d, x);
        for (int k = 0; k < 3; ++k) {
            moved[k] = V(T(0));
            for (int i = 0; i < arm.joints(); ++i) moved[k] = moved[k] + at.moved[i].v[k] * x[i];
        }
    }

  private:
    bool departs() const { return near != nullptr || limits != nullptr; }

    TWISTARM_INLINE void by_joints(const local_errors<V, M>& at, const V& epsilon, const V* pull, V* g, V* H) const {
        const V weight = rotation_weight(epsilon);
        const int joints = arm.joints();
        TWISTARM_UNROLL
        for (int i = 0; i < joints; ++i) {
            const column<V>& moved = at.moved[i];
            g[i] = dot(moved.v, at.away) + weight * dot(moved.w, at.rotation_level.slope);
            V push[3], twist[3];
            cross(pull, moved.w, push);
            for (int k = 0; k < 3; ++k) {
                push[k] = push[k] + at.held[k] * moved.v[k];
                twist[k] = weight * dot(at.rotation_level.curvature[k], moved.w);
            }
            TWISTARM_UNROLL
            for (int j = i; j < joints; ++j)
                H[in_triangle(j, i)] = dot(at.moved[j].v, push) + dot(at.moved[j].w, twist);
        }
    }

    /// The same with x = A θ: Aᵀ g and Aᵀ H A.
    void by_coordinates(const local_errors<V, M>& at, const V& epsilon, const V* pull, V* g, V* H) const {
        const int joints = arm.joints(), n = arm.coordinates();
        V slope[capacity(M)], curvature[triangle_of(capacity(M))];
        by_joints(at, epsilon, pull, slope, curvature);
        for (int a = 0; a < n; ++a) {
            g[a] = V(T(0));
            V row[capacity(M)];
            for (int j = 0; j < joints; ++j) row[j] = V(T(0));
            for (int i = 0; i < joints; ++i) {
                const T share = arm.coupling[i][a];
                if (share == T(0)) continue;
                g[a] = g[a] + slope[i] * share;
                for (int j = 0; j < joints; ++j)
                    row[j] = row[j] + curvature[j < i ? in_triangle(i, j) : in_triangle(j, i)] * share;
            }
            for (int b = 0; b <= a; ++b) {
                V sum = V(T(0));
                for (int j = 0; j < joints; ++j)
                    if (arm.coupling[j][b] != T(0)) sum = sum + row[j] * arm.coupling[j][b];
                H[in_triangle(a, b)] = sum;
            }
        }
    }
};

TWISTARM_END
