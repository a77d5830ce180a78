// Why a target cannot be met: the limits, a direction the arm has no joint for, or its reach.
#pragma once

#include "race.hpp"

TWISTARM_BEGIN

/// unusable: the target or θ₀ is not finite (`is_usable`), and nothing was searched. Python refuses it before.
enum class stop_reason {
    converged, out_of_reach, impossible_direction, blocked_by_limits, exhausted, timed_out, unusable
};

namespace detail {
/// Searches without limits before the limits are found not to be the reason.
constexpr int searches_without_limits = 48;
/// They are given more patience: a helical joint takes many turns to where it is wanted.
constexpr int iterations_without_limits = 60;
template <class T> constexpr T progress_without_limits = T(0.95);
/// Random configurations among which the rank of a task is the largest; almost every one has it.
constexpr int rank_samples = 16;
/// Squared lengths below this, relative to the largest, are directions the arm cannot move in: 1e-6 of a length.
template <class T> constexpr T rank_tolerance = T(sizeof(T) == 8 ? 1e-12 : 1e-6);
}  // namespace detail

namespace detail {
/// Half the range of random starts of a coordinate without limits: 1 m where it slides anything, else π.
template <class T, int N, int M> T usual_half(const chain<T, N, M>& arm, int k) {
    T slide = T(0);
    for (int i = 0; i < arm.joints(); ++i)
        slide = greatest(slide, absolute(arm.coupling[i][k] * arm.links[i].slide));
    return slide > static_cast<T>(whole_turn_tolerance) ? T(1) / slide : static_cast<T>(0.5 * whole_turn);
}
}  // namespace detail

/// The ranges of the same chain without limits.
template <class T, int N, int M> ranges<T, N> without_limits(const chain<T, N, M>& arm, const ranges<T, N>& range) {
    ranges<T, N> free = range;
    free.all_turn = true;
    for (int k = 0; k < arm.coordinates(); ++k) {
        free.upper[k] = static_cast<T>(__builtin_inf());
        free.lower[k] = -free.upper[k];
        free.start_upper[k] = detail::usual_half(arm, k);
        free.start_lower[k] = -free.start_upper[k];
        free.turns[k] = range.periodic[k];
        free.all_turn = free.all_turn && free.turns[k];
    }
    return free;
}

/// θ with every periodic coordinate at its representative nearest to the middle of its limits, in them or not.
template <class T, int N> void bring_toward(const ranges<T, N>& range, int coordinates, T* theta) {
    for (int k = 0; k < coordinates; ++k) {
        if (!range.periodic[k]) continue;
        const double width = static_cast<double>(range.upper[k]) - static_cast<double>(range.lower[k]);
        const double here = static_cast<double>(theta[k]);
        const double middle = width < __builtin_inf() ? static_cast<double>(range.lower[k]) + 0.5 * width : here;
        theta[k] = static_cast<T>(here + whole_turn * __builtin_round((middle - here) / whole_turn));
    }
}

/// How many components a target constrains.
template <class T> int constrained(const target<T>& asked) {
    if (asked.kind != target_kind::task) return rows_of(asked.kind);
    int count = 0;
    for (const T tolerance : asked.tolerance) count += tolerance < static_cast<T>(__builtin_inf()) ? 1 : 0;
    return count;
}

namespace detail {
template <class T> void exchange(T& a, T& b) {
    const T kept = a;
    a = b;
    b = kept;
}

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

/// A configuration that meets the target if the arm had no limits, searched from `theta` on; false if none was found.
template <class T, int N, int M, class Stopped>
bool meets_without_limits(const chain<T, N, M>& arm, const ranges<T, N>& range, search_settings<T> settings,
                          const target<T>& asked, const T* theta, std::uint64_t seed, Stopped& stopped, T* unlimited) {
    solution<T, N> found;
    settings.searches = detail::searches_without_limits;
    settings.iterations = detail::iterations_without_limits;
    settings.progress = detail::progress_without_limits<T>;
    solve(arm, without_limits(arm, range), settings, asked, theta, seed, found, static_cast<T*>(nullptr), 0, stopped);
    if (!found.converged) return false;
    for (int k = 0; k < arm.coordinates(); ++k) unlimited[k] = found.theta[k];
    bring_toward(range, arm.coordinates(), unlimited);
    return true;
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
