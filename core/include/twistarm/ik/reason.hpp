// The reason why a target cannot be reached: the limits, a direction without a joint, or the reach.
#pragma once

#include "minima.hpp"
#include "unlimited.hpp"

TWISTARM_BEGIN

/// unusable: the target or θ₀ is not finite (`is_usable`), and nothing was searched. Python refuses it before.
enum class stop_reason {
    converged, out_of_reach, impossible_direction, blocked_by_limits, exhausted, timed_out, unusable
};

namespace detail {
/// The distance to neighbouring configurations [rad, m] that are checked for what this one lacks. At the edge of the
/// reach, all joints that turn the tool one way may be without effect to first order.
constexpr double beside = 0.1;
/// If neighbouring configurations lack less than this part of what this one lacks, the configuration is the reason.
constexpr double lacking_alone = 0.9;
/// Shorter vectors [rad for a rad], positions divided by the reach, are directions in which the arm cannot move.
/// Descriptions write 1.57 for a right angle.
constexpr double lacking_below = 1e-3;
/// A smaller part of a rotation error than this is no reason beside the rest of it.
constexpr double lacking_share = 0.05;
/// A component is held if its error is at least this part of its tolerance, because the nearest lies at the edge of
/// tolerances.
constexpr double held_from = 0.999;
}  // namespace detail

/// A rotation error [rad] in two parts, with the position held. The first, about an axis (3,) of the tool, no joint can
/// undo; limits or the reach prevent the second.
template <class T> struct rotation_split {
    T impossible, prevented, axis[3];
};

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
/// Removes the directions of the first `spanning` vectors (count, size) from all of them, if these are longer than
/// `lacking_below`: Gram–Schmidt, the longest first.
template <class T, int Size> void take_out(T (*vectors)[Size], int spanning, int count, int size) {
    for (int step = 0; step < spanning; ++step) {
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

/// The target's components at a configuration: the error of each, its rows, and whether it is held. Rows of a task's
/// rotation are as if the rotation were reached, in the axes of its tolerances: far from the goal, its logarithm changes
/// with what is left free.
template <target_kind Kind, class T, int N> struct asked_here {
    frame<T> g, behind;  ///< the pose in the axes of the aim, and what the aim adds to the tool
    residual<T, N, rows_of(Kind)> at;
    bool held[6];

    template <int M> asked_here(const chain<T, N, M>& arm, const target<T>& asked, const T* theta) {
        const aim<T> aimed = aim_at(arm, asked);
        column<T> columns[capacity(N)];
        walk_with_columns(arm, aimed.base, aimed.tip, theta, g, columns);
        behind = product(inverse(arm.tip), aimed.tip);
        residual_of<Kind, N>(g, columns, arm.coordinates(), aimed, T(1), at);
        for (bool& component : held) component = true;
        if constexpr (Kind == target_kind::task) hold(asked, columns, arm.coordinates());
    }

    /// Components within their tolerances are free, and what is held has all of its row.
    void hold(const target<T>& asked, column<T>* columns, int n) {
        T off[6];
        chord_of(g, off + 3);
        logarithm_of_chord(off + 3);
        for (int r = 0; r < 3; ++r) off[r] = g.p[r];
        for (int r = 0; r < 6; ++r)
            held[r] = asked.tolerance[r] < static_cast<T>(__builtin_inf()) &&
                      absolute(off[r]) >= static_cast<T>(held_from) * asked.tolerance[r];
        for (int k = 0; k < n; ++k) {
            if (!asked.base_axes) rotate_back(g, columns[k].w, columns[k].w);
            for (int r = 0; r < 3; ++r) {
                at.J[k][r] = columns[k].v[r];
                at.J[k][r + 3] = columns[k].w[r];
            }
        }
    }

    /// The remaining rotation error, `left` (3,), if the joints may turn the tool as at `there` with the held position
    /// fixed, metres over `reach` [m]. Returns the square of its length.
    T remains(const residual<T, N, rows_of(Kind)>& there, int n, T reach, T* left) const {
        constexpr int rows = rows_of(Kind);
        T J[rows][capacity(N)], turns[capacity(N) + 1][3] = {};
        for (int r = 0; r < rows; ++r)
            for (int k = 0; k < n; ++k) J[r][k] = !held[r] ? T(0) : r < 3 ? there.J[k][r] / reach : there.J[k][r];
        take_out(J, 3, rows, n);
        for (int r = 3; r < rows; ++r) {
            for (int k = 0; k < n; ++k) turns[k][r - 3] = J[r][k];
            turns[n][r - 3] = at.e[r];
        }
        take_out(turns, n, n + 1, 3);
        for (int r = 0; r < 3; ++r) left[r] = turns[n][r];
        return dot(left, left);
    }

    /// A rotation error's axis in those of the tool.
    void in_tool(const target<T>& asked, const T* error, T* axis) const {
        T turn[3] = {error[0], error[1], error[2]};
        if constexpr (Kind == target_kind::approach)
            for (int k = 0; k < 3; ++k) turn[k] = error[0] * g.x[k] + error[1] * g.y[k];
        if (Kind != target_kind::task || asked.base_axes) rotate_back(g, turn, turn);
        rotate(behind, turn, axis);
    }
};

template <target_kind Kind, class T, int N, int M>
rotation_split<T> split_rotation_as(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, T reach) {
    const int n = arm.coordinates();
    const asked_here<Kind, T, N> here(arm, asked, theta);
    T left[3], other[3], moved[capacity(N)];
    T squared = here.remains(here.at, n, reach, left);
    T enough = static_cast<T>(lacking_alone * lacking_alone) * squared;
    for (int k = 0; k < n; ++k) moved[k] = theta[k];
    for (int way = 0; way < 2 * n; ++way) {
        const int k = way / 2;
        moved[k] = theta[k] + static_cast<T>(way % 2 == 0 ? beside : -beside);
        const T there = here.remains(asked_here<Kind, T, N>(arm, asked, moved).at, n, reach, other);
        moved[k] = theta[k];
        if (!(there < enough)) continue;
        squared = enough = there;
        for (int r = 0; r < 3; ++r) left[r] = other[r];
    }
    rotation_split<T> split{};
    if (!(here.at.rotation_squared > T(0))) return split;
    const T angle = errors_at(asked, forward(arm, theta)).orientation;
    split.impossible = angle * sqrt(least(squared / here.at.rotation_squared, T(1)));
    split.prevented = angle - split.impossible;
    here.in_tool(asked, left, split.axis);
    const T size = sqrt(dot(split.axis, split.axis));
    for (int r = 0; r < 3 && size > T(0); ++r) split.axis[r] /= size;
    return split;
}
}  // namespace detail

/// The rotation error at θ in two parts: what no joint can undo at θ or near it with the position held, and the rest.
template <class T, int N, int M>
rotation_split<T> split_rotation(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, T reach) {
    rotation_split<T> split{};
    with_kind(asked, [&](auto kind) {
        if constexpr (kind() != target_kind::position)
            split = detail::split_rotation_as<kind()>(arm, asked, theta, reach);
    });
    return split;
}

namespace detail {
/// Descends to the nearest configuration without limits from where searches for the target without limits have ended,
/// `ends`. Whether it meets the position.
template <class T, int N, int M, class Stopped>
bool come_near_without_limits(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                              const target<T>& asked, const searched<T, N>& ends, Stopped& stopped, T* theta) {
    using V = pack<T, searches_in_group>;
    const int n = arm.coordinates();
    const two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked))};
    resumed_ends<T, N> starts;
    static_assert(resumed == searches_in_group, "A start for each lane.");
    take_nearest(arm, range, settings, asked, ends.theta, searches_without_limits, starts);
    descent_lanes<V, N> lanes;
    lanes.epsilon = V(first_epsilons<T>[1]);
    for (int l = 0; l < searches_in_group; ++l)
        for (int k = 0; k < n; ++k) set_lane(lanes.theta[k], l, starts.theta[l][k]);
    const ranges<T, N> free = without_limits(arm, range);
    descend(objective, free, finishing<T>, lanes, stopped);
    minimum<T, N> minima[searches_in_group];
    int which[searches_in_group];
    for (int l = 0; l < searches_in_group; ++l) which[l] = l;
    come_to_rest(objective, free, which, searches_in_group, lanes, stopped, minima);
    const minimum<T, N>& best = nearest_of(minima, searches_in_group);
    for (int k = 0; k < n; ++k) theta[k] = best.at.theta[k];
    bring_toward(range, n, theta);
    return best.distance <= settings.position_tolerance && !is_inside(range, n, theta);
}
}  // namespace detail

/// The largest cause of the nearest configuration's errors if nothing meets the target without limits. `ends` are the
/// ends of the searches without limits. If limits are still the reason, `unlimited` is the nearest without them.
template <class T, int N, int M, class Stopped>
stop_reason reason_for(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                       const target<T>& asked, T reach, const solution<T, N>& nearest, const searched<T, N>& ends,
                       Stopped& stopped, T* unlimited) {
    if (nearest.position_error > settings.position_tolerance) return stop_reason::out_of_reach;
    const rotation_split<T> here = split_rotation(arm, asked, nearest.theta, reach);
    if (here.impossible >= here.prevented) return stop_reason::impossible_direction;
    if (!detail::come_near_without_limits(arm, range, settings, asked, ends, stopped, unlimited))
        return stop_reason::out_of_reach;
    const rotation_split<T> there = split_rotation(arm, asked, unlimited, reach);
    const T by_limits = nearest.orientation_error - there.impossible - there.prevented;
    if (by_limits >= greatest(there.impossible, there.prevented)) return stop_reason::blocked_by_limits;
    const bool lacking = here.impossible > static_cast<T>(detail::lacking_share) * here.prevented;
    return lacking && there.impossible >= there.prevented ? stop_reason::impossible_direction
                                                          : stop_reason::out_of_reach;
}

TWISTARM_END
