// Reason why a target cannot be met: the limits, a direction the arm has no joint for, or its reach.
#pragma once

#include "unlimited.hpp"

TWISTARM_BEGIN

/// unusable: the target or θ₀ is not finite (`is_usable`), and nothing was searched. Python refuses it before.
enum class stop_reason {
    converged, out_of_reach, impossible_direction, blocked_by_limits, exhausted, timed_out, unusable
};

namespace detail {
/// Random configurations among which the rank of a task is the largest; almost every one has it.
constexpr int rank_samples = 16;
/// Squared lengths below this, relative to the largest, are directions the arm cannot move in: 1e-6 of a length.
template <class T> constexpr T rank_tolerance = T(sizeof(T) == 8 ? 1e-12 : 1e-6);
}  // namespace detail

/// How many components a target constrains.
template <class T> int constrained(const target<T>& asked) {
    if (asked.kind != target_kind::task) return rows_of(asked.kind);
    int count = 0;
    for (const T tolerance : asked.tolerance) count += tolerance < static_cast<T>(__builtin_inf()) ? 1 : 0;
    return count;
}

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
/// Columns (n,) of the Jacobian along the axes in which a target that is met at θ constrains its components: the
/// tool's, for an approach with z along its axis, or the base's.
template <class T, int N, int M>
void columns_where_met(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, column<T>* J) {
    if (asked.kind == target_kind::task && asked.base_axes) {
        frame<T> g;
        walk_with_columns(arm, arm.base, arm.tip, theta, g, J);
        return;
    }
    forward_with_body_jacobian(arm, theta, J);
    if (asked.kind != target_kind::approach) return;
    const frame<T> turned = rotation_onto(asked.tool_axis);
    for (int i = 0; i < arm.coordinates(); ++i) rotate_back(turned, J[i].w, J[i].w);
}

/// The rank of a positive semidefinite G (size, size), which is used up: how many pivots of its LDLᵀ with interchanges
/// are above `rank_tolerance` of the first. Source: G. Golub & C. Van Loan, Matrix Computations, 4th ed., §4.2.8.
template <class T> int rank_of(T (&G)[6][6], int size) {
    T first = T(0);
    for (int rank = 0; rank < size; ++rank) {
        int pivot = rank;
        for (int i = rank + 1; i < size; ++i)
            if (G[i][i] > G[pivot][pivot]) pivot = i;
        for (int k = 0; k < size; ++k) exchange(G[rank][k], G[pivot][k]);
        for (int k = 0; k < size; ++k) exchange(G[k][rank], G[k][pivot]);
        if (rank == 0) first = G[0][0];
        if (!(G[rank][rank] > rank_tolerance<T> * first)) return rank;
        for (int i = rank + 1; i < size; ++i)
            for (int j = rank + 1; j < size; ++j) G[i][j] -= G[i][rank] * (G[rank][j] / G[rank][rank]);
    }
    return size;
}

/// The rank at θ of the rows that a target met there constrains, positions over `reach` [m].
template <class T, int N, int M>
int rank_where_met(const chain<T, N, M>& arm, const target<T>& asked, const T* theta, T reach) {
    column<T> J[capacity(N)];
    columns_where_met(arm, asked, theta, J);
    T rows[6][capacity(N)], G[6][6];
    int count = 0;
    for (int r = 0; r < rows_of(asked.kind); ++r) {
        if (asked.kind == target_kind::task && !(asked.tolerance[r] < static_cast<T>(__builtin_inf()))) continue;
        const bool linear = r < 3;
        for (int k = 0; k < arm.coordinates(); ++k) rows[count][k] = linear ? J[k].v[r % 3] / reach : J[k].w[r % 3];
        ++count;
    }
    for (int a = 0; a < count; ++a)
        for (int b = 0; b < count; ++b) {
            G[a][b] = T(0);
            for (int k = 0; k < arm.coordinates(); ++k) G[a][b] += rows[a][k] * rows[b][k];
        }
    return rank_of(G, count);
}
}  // namespace detail

/// In how many of the target's components the arm can move its tool, in almost every configuration that meets it: the
/// largest rank over random configurations.
template <class T, int N, int M>
int task_rank(const chain<T, N, M>& arm, const ranges<T, N>& range, const target<T>& asked, T reach) {
    int largest = 0;
    for (int k = 0; k < detail::rank_samples; ++k) {
        T theta[capacity(N)];
        random_start(range, arm.coordinates(), 0, k, theta);
        largest = greatest(largest, detail::rank_where_met(arm, asked, theta, reach));
        if (largest == constrained(asked)) break;
    }
    return largest;
}

/// Why the nearest configuration, with these errors, is no answer, though the limits are not to blame.
template <class T, int N, int M>
stop_reason reason_for(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                       const target<T>& asked, T reach, const solution<T, N>& nearest) {
    const bool impossible = nearest.position_error <= settings.position_tolerance &&
                            nearest.orientation_error > settings.orientation_tolerance;
    const bool missing = impossible && task_rank(arm, range, asked, reach) < constrained(asked);
    return missing ? stop_reason::impossible_direction : stop_reason::out_of_reach;
}

TWISTARM_END
