// Reason why a target cannot be met: the limits, a direction the arm has no joint for, or its reach.
#pragma once

#include "unlimited.hpp"

TWISTARM_BEGIN

/// unusable: the target or θ₀ is not finite (`is_usable`), and nothing was searched. Python refuses it before.
enum class stop_reason {
    converged, out_of_reach, impossible_direction, blocked_by_limits, exhausted, timed_out, unusable
};

namespace detail {
/// How far beside a configuration [rad, m] one looks for what it lacks by itself: where a reach ends, all joints that turn
/// the tool one way may stand still at first.
constexpr double beside = 0.1;
/// Lengths below this [rad for a rad], positions over the reach, are of directions the arm cannot move in: descriptions
/// write 1.57 for a right angle, and mean it.
constexpr double lacking_below = 1e-3;
/// A smaller part of the rotation error than this is no reason beside the rest of it.
constexpr double lacking_share = 0.05;
}  // namespace detail

/// Whether a target constrains more than the tool's position.
template <class T> bool has_rotation(const target<T>& asked) {
    if (asked.kind != target_kind::task) return asked.kind != target_kind::position;
    for (int k = 3; k < 6; ++k)
        if (asked.tolerance[k] < static_cast<T>(__builtin_inf())) return true;
    return false;
}

/// What a target asks of the tool's position alone.
template <class T> target<T> position_of(const target<T>& asked) {
    if (asked.kind != target_kind::task) return position_target(asked.goal.p);
    target<T> part = asked;
    for (int k = 3; k < 6; ++k) part.tolerance[k] = static_cast<T>(__builtin_inf());
    return part;
}

namespace detail {
/// Takes what lies along the first `spanning` of the vectors (count, size) out of all of them, as far as those are longer
/// than `lacking_below`: Gram-Schmidt, the longest first.
template <class T, int Size> void take_out(T (*vectors)[Size], int spanning, int count, int size) {
    for (int taken = 0; taken < spanning; ++taken) {
        T longest = static_cast<T>(lacking_below * lacking_below), unit[Size];
        int which = -1;
        for (int i = 0; i < spanning; ++i) {
            T square = T(0);
            for (int k = 0; k < size; ++k) square += vectors[i][k] * vectors[i][k];
            if (!(square > longest)) continue;
            longest = square;
            which = i;
        }
        if (which < 0) return;
        for (int k = 0; k < size; ++k) unit[k] = vectors[which][k] / sqrt(longest);
        for (int i = 0; i < count; ++i) {
            T share = T(0);
            for (int k = 0; k < size; ++k) share += unit[k] * vectors[i][k];
            for (int k = 0; k < size; ++k) vectors[i][k] -= share * unit[k];
        }
    }
}

/// Error of a target at θ, and its rows. Those of a task's rotation are as if it were met there, in the axes of its
/// tolerances: far off, its logarithm changes with what is left free.
template <target_kind Kind, class T, int N, int M>
void look_from(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, residual<T, N, rows_of(Kind)>& at) {
    const aim<T> aimed = aim_at(arm, asked);
    frame<T> g;
    column<T> columns[capacity(N)];
    walk_with_columns(arm, aimed.base, aimed.tip, theta, g, columns);
    residual_of<Kind, N>(g, columns, arm.coordinates(), aimed, T(1), at);
    if constexpr (Kind == target_kind::task)
        for (int k = 0; k < arm.coordinates(); ++k) {
            if (!asked.base_axes) rotate_back(g, columns[k].w, columns[k].w);
            for (int r = 0; r < 3; ++r)
                at.J[k][r + 3] = asked.tolerance[r + 3] < static_cast<T>(__builtin_inf()) ? columns[k].w[r] : T(0);
        }
}

/// The square of what remains of a rotation error, `here.e`, if the joints may turn the tool as at `there`, with what of
/// the position is held `here` held, metres over `reach` [m]. What lies inside its tolerance is free.
template <target_kind Kind, class T, int N>
T left_of_rotation(const residual<T, N, rows_of(Kind)>& here, const residual<T, N, rows_of(Kind)>& there, int n,
                   T reach) {
    constexpr int rows = rows_of(Kind);
    T J[rows][capacity(N)], turns[capacity(N) + 1][3] = {};
    for (int r = 0; r < rows; ++r)
        for (int k = 0; k < n; ++k) J[r][k] = r < 3 ? there.J[k][r] / reach : there.J[k][r];
    for (int r = 0; r < rows && Kind == target_kind::task; ++r) {
        bool held = r >= 3 && here.e[r] != T(0);
        for (int k = 0; k < n && r < 3; ++k) held = held || here.J[k][r] != T(0);
        for (int k = 0; k < n && !held; ++k) J[r][k] = T(0);
    }
    take_out(J, 3, rows, n);
    for (int r = 3; r < rows; ++r) {
        for (int k = 0; k < n; ++k) turns[k][r - 3] = J[r][k];
        turns[n][r - 3] = here.e[r];
    }
    take_out(turns, n, n + 1, 3);
    return dot(turns[n], turns[n]);
}

/// Whether a part of the rotation error at θ is about directions in which no joint turns the tool, the position held, at θ
/// or beside it.
template <target_kind Kind, class T, int N, int M>
bool lacks_direction(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, T reach) {
    residual<T, N, rows_of(Kind)> here, there;
    look_from<Kind>(arm, asked, theta, here);
    T least_left = left_of_rotation<Kind>(here, here, arm.coordinates(), reach), moved[capacity(N)];
    for (int k = 0; k < arm.coordinates(); ++k) moved[k] = theta[k];
    for (int way = 0; way < 2 * arm.coordinates(); ++way) {
        const int k = way / 2;
        moved[k] = theta[k] + static_cast<T>(way % 2 == 0 ? beside : -beside);
        look_from<Kind>(arm, asked, moved, there);
        least_left = least(least_left, left_of_rotation<Kind>(here, there, arm.coordinates(), reach));
        moved[k] = theta[k];
    }
    return least_left > static_cast<T>(lacking_share * lacking_share) * here.rotation_squared;
}
}  // namespace detail

/// Why the nearest configuration, with these errors, is no answer, though the limits are not to blame.
template <class T, int N, int M>
stop_reason reason_for(const chain<T, N, M>& arm, const search_settings<T>& settings,
                       const target<T>& asked, T reach, const solution<T, N>& nearest) {
    bool lacking = false;
    if (nearest.position_error <= settings.position_tolerance)
        with_kind(asked, [&](auto kind) {
            if constexpr (kind() != target_kind::position)
                lacking = detail::lacks_direction<kind()>(arm, asked, nearest.theta, reach);
        });
    return lacking ? stop_reason::impossible_direction : stop_reason::out_of_reach;
}

TWISTARM_END
