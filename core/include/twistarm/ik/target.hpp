// Targets of the tool (pose, position, approach, task) and the error of a pose against them.
#pragma once

#include "../numeric/elementary.hpp"
#include "../kinematics/frame.hpp"

TWISTARM_BEGIN

/// pose: all six components. position: the tool's origin. approach: the origin and R tool_axis = direction. task: each
/// component with a tolerance of its own.
enum class target_kind { pose, position, approach, task };

/// Rows of the error: what is free by its kind has none.
constexpr int rows_of(target_kind kind) {
    return kind == target_kind::position ? 3 : (kind == target_kind::approach ? 5 : 6);
}

template <target_kind Kind> using constant_kind = std::integral_constant<target_kind, Kind>;

/// Calls f with the kind as a constant. It is the only place where a run-time value selects compiled code.
template <class F> TWISTARM_INLINE void with_kind(target_kind kind, const F& f) {
    switch (kind) {
        case target_kind::pose: return f(constant_kind<target_kind::pose>{});
        case target_kind::position: return f(constant_kind<target_kind::position>{});
        case target_kind::approach: return f(constant_kind<target_kind::approach>{});
        case target_kind::task: return f(constant_kind<target_kind::task>{});
    }
}

/// A target of any kind in the base frame; lengths in m, angles in rad.
template <class T> struct target {
    target_kind kind;
    frame<T> goal;                   ///< position and approach: its origin alone
    T direction[3], tool_axis[3];    ///< approach: unit vectors, in base and in tool axes
    T tolerance[6];                  ///< task: x, y, z [m], rx, ry, rz [rad]; 0 exact, infinite free
    bool base_axes;                  ///< task: tolerances along the base's axes, not the goal's
};

/// A target with a kind known at compile time. It needs only the solver of that kind.
template <class T, target_kind Kind> struct target_of : target<T> {
    static constexpr target_kind kind = Kind;  ///< before the member of this name, so that nothing changes that
};

/// Whether a Target can be of this kind; a plain `target` can be of any.
template <target_kind Kind, class Target> constexpr bool may_be = true;
template <target_kind Kind, class T, target_kind Other> constexpr bool may_be<Kind, target_of<T, Other>> = Kind == Other;

/// Calls f with a target's kind: that of its type, or else its run-time value.
template <class T, class F> TWISTARM_INLINE void with_kind(const target<T>& asked, const F& f) { with_kind(asked.kind, f); }
template <class T, target_kind Kind, class F> TWISTARM_INLINE void with_kind(const target_of<T, Kind>&, const F& f) {
    f(constant_kind<Kind>{});
}

/// The whole pose g.
template <class T> target_of<T, target_kind::pose> pose_target(const frame<T>& g) {
    return {{target_kind::pose, g, {}, {}, {}, false}};
}

/// The tool's origin at p [m].
template <class T> target_of<T, target_kind::position> position_target(const T p[3]) {
    frame<T> goal = identity_frame<T>();
    for (int k = 0; k < 3; ++k) goal.p[k] = p[k];
    return {{target_kind::position, goal, {}, {}, {}, false}};
}

/// The tool's origin at p [m], and R tool_axis along the direction. Both vectors may have any length but zero.
template <class T>
target_of<T, target_kind::approach> approach_target(const T p[3], const T direction[3], const T tool_axis[3]) {
    target_of<T, target_kind::approach> asked{{target_kind::approach, position_target(p).goal, {}, {}, {}, false}};
    const T length = sqrt(dot(direction, direction)), tool_length = sqrt(dot(tool_axis, tool_axis));
    for (int k = 0; k < 3; ++k) {
        asked.direction[k] = direction[k] / length;
        asked.tool_axis[k] = tool_axis[k] / tool_length;
    }
    return asked;
}

/// The pose g within six tolerances ≥ 0; infinite, or ≥ π for a rotation, leaves a component free.
template <class T>
target_of<T, target_kind::task> task_target(const frame<T>& g, const T tolerance[6], bool base_axes) {
    target_of<T, target_kind::task> asked{{target_kind::task, g, {}, {}, {}, base_axes}};
    for (int k = 0; k < 6; ++k)
        asked.tolerance[k] = k >= 3 && tolerance[k] >= T(3.14159265358979323846) ? T(__builtin_inf()) : tolerance[k];
    return asked;
}

/// How far a pose misses a target, counting only what is constrained: position [m], orientation [rad].
template <class T> struct target_errors {
    T position, orientation;
};

namespace detail {
/// The angle in [0, π] with this sine ≥ 0 and cosine; without an arc tangent where it is below 60°.
template <class T> inline T angle_of(T sine, T cosine) {
    if (cosine > T(0.5)) return arcsine(least(sine, T(1)));
    return static_cast<T>(__builtin_atan2(static_cast<double>(sine), static_cast<double>(cosine)));
}

/// φ u of the rotation R by φ in [0, π] about u. Beyond 2.6 rad the axis is read from R + Rᵀ, because R − Rᵀ fades.
template <class T> inline void logarithm(const frame<T>& R, T phi[3]) {
    const T* columns[3] = {R.x, R.y, R.z};
    const T w[3] = {R.y[2] - R.z[1], R.z[0] - R.x[2], R.x[1] - R.y[0]};
    const T trace = R.x[0] + R.y[1] + R.z[2], sine = sqrt(dot(w, w));
    const T angle = angle_of(T(0.5) * sine, T(0.5) * (trace - T(1)));
    for (int k = 0; k < 3; ++k) phi[k] = sine > T(0) ? w[k] * (angle / sine) : T(0);
    if (angle < T(2.6)) return;
    int longest = 0;
    for (int k = 1; k < 3; ++k)
        if (columns[k][k] > columns[longest][longest]) longest = k;
    T u[3];
    for (int k = 0; k < 3; ++k)
        u[k] = T(0.5) * (columns[longest][k] + columns[k][longest]) - (k == longest ? T(0.5) * (trace - T(1)) : T(0));
    const T scale = angle / sqrt(dot(u, u));
    for (int k = 0; k < 3; ++k) phi[k] = dot(u, w) < T(0) ? -u[k] * scale : u[k] * scale;
}

template <class T> inline T excess(T error, T tolerance) { return error - clamped(error, -tolerance, tolerance); }

template <class T> inline T length_of_excess(const T error[3], const T tolerance[3]) {
    T squared = T(0);
    for (int k = 0; k < 3; ++k) squared += excess(error[k], tolerance[k]) * excess(error[k], tolerance[k]);
    return sqrt(squared);
}

template <class T> inline target_errors<T> task_errors(const target<T>& asked, const frame<T>& g, const T offset[3]) {
    T away[3], phi[3];
    rotate_back(asked.goal, offset, away);
    logarithm(product(inverse(asked.goal), g), phi);
    if (asked.base_axes) {
        for (int k = 0; k < 3; ++k) away[k] = offset[k];
        rotate(asked.goal, phi, phi);
    }
    return {length_of_excess(away, asked.tolerance), length_of_excess(phi, asked.tolerance + 3)};
}
}  // namespace detail

/// The errors of the pose g. pose: ‖p − p_g‖ and the angle of R_gᵀ R. approach: the angle between the axes. task: the
/// norms of the parts beyond the tolerances, of p − p_g and of log(R R_gᵀ) in base axes or the goal's.
template <class T> target_errors<T> errors_at(const target<T>& asked, const frame<T>& g) {
    const T offset[3] = {g.p[0] - asked.goal.p[0], g.p[1] - asked.goal.p[1], g.p[2] - asked.goal.p[2]};
    const T distance = sqrt(dot(offset, offset));
    if (asked.kind == target_kind::position) return {distance, T(0)};
    if (asked.kind == target_kind::task) return detail::task_errors(asked, g, offset);
    if (asked.kind == target_kind::approach) {
        T axis[3], turn[3];
        rotate(g, asked.tool_axis, axis);
        cross(axis, asked.direction, turn);
        return {distance, detail::angle_of(sqrt(dot(turn, turn)), dot(axis, asked.direction))};
    }
    T phi[3];
    detail::logarithm(product(inverse(asked.goal), g), phi);
    return {distance, sqrt(dot(phi, phi))};
}

/// Whether a solver can begin. The numbers of the target and of θ₀ (n,) are finite, tolerances are 0 to infinity, and
/// an approach's directions have a length.
template <class T> bool is_usable(const target<T>& asked, const T* theta0, int n) {
    T sum = T(0);  // 0 x is NaN for what is not finite, and so is every sum that it enters
    for (int k = 0; k < n; ++k) sum += T(0) * theta0[k];
    for (int k = 0; k < 3; ++k) {
        sum += T(0) * (asked.goal.x[k] + asked.goal.y[k] + asked.goal.z[k] + asked.goal.p[k]);
        if (asked.kind == target_kind::approach) sum += T(0) * (asked.direction[k] + asked.tool_axis[k]);
    }
    bool usable = sum == T(0);
    for (int k = 0; k < 6 && asked.kind == target_kind::task; ++k) usable = usable && asked.tolerance[k] >= T(0);
    return usable;
}

TWISTARM_END
