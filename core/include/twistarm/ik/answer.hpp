// Whole answer to a target: a configuration that meets it, or the nearest one and the reason.
#pragma once

#include "branch.hpp"
#include "far_slides.hpp"
#include "nearest.hpp"
#include "posture.hpp"
#include "reason.hpp"

TWISTARM_BEGIN

/// What is known of a target in the end.
template <class T, int N> struct answer {
    solution<T, N> found;  ///< it meets the target, or is the nearest to it
    stop_reason stop;
    bool nearest;                 ///< `found` comes from the search for the nearest, not from a search for an answer
    bool has_unlimited;
    T unlimited[capacity(N)];     ///< outside the limits, where they block: it meets the target, or comes nearest to it
    bool other_branch;            ///< `found` is not near θ₀, though the target is near the tool there, or is not reached
};

namespace detail {
/// The nearest of the starts as they are, for a call that is cut short.
template <class T, int N, int M>
void take_nearest_start(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                        const target<T>& asked, const T* theta0, const T* starts, int count, solution<T, N>& found) {
    const auto beyond = [&](T position) { return position <= settings.position_tolerance ? T(0) : position; };
    for (int i = 0; i < count; ++i) {
        solution<T, N> start = found;
        for (int k = 0; k < arm.coordinates(); ++k) start.theta[k] = starts[i * arm.coordinates() + k];
        judge(arm, range, settings, asked, theta0, start);
        const T here = beyond(start.position_error), best = beyond(found.position_error);
        if (here < best || (here == best && start.orientation_error < found.orientation_error)) found = start;
    }
}

/// Whether limits are the reason. Searches look for roots without limits: of the target, or of its position alone if
/// the position is missed and no root meets the target. The nearest configuration that the limits leave is the answer.
/// Without roots, `roots` holds the ends of the searches.
template <class T, int N, int M, class Stopped>
void find_unlimited(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                    const target<T>& asked, const T* theta0, std::uint64_t seed, Stopped& stopped,
                    searched<T, N>& roots, answer<T, N>& out) {
    solution<T, N>& found = out.found;
    const auto search = [&](const target<T>& wanted, int enough) {
        meet_without_limits(arm, range, settings, wanted, found.theta, seed, enough, stopped, roots);
        if (roots.count == 0) return false;
        out.has_unlimited = true;
        out.stop = stop_reason::blocked_by_limits;
        for (int k = 0; k < arm.coordinates(); ++k) out.unlimited[k] = roots.theta[k];
        return true;
    };
    const bool position_first = found.position_error > settings.position_tolerance && has_rotation(asked);
    if (position_first && !search(position_of(asked), 1)) return;
    if (search(asked, enough_roots)) meet_inside(arm, range, settings, asked, theta0, roots, stopped, found);
    if (!found.converged) return;
    out.stop = stop_reason::converged;
    out.has_unlimited = false;
}

/// The nearest configuration and the reason, from a field of starts, which is used up.
template <class T, int N, int M, class Stopped>
void explain(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
             const target<T>& asked, const T* theta0, std::uint64_t seed, T reach, Stopped& stopped,
             field_of_starts<T, N>& field, answer<T, N>& out) {
    solution<T, N>& found = out.found;
    const int begun = field.count;
    out.stop = stop_reason::timed_out;
    if (stopped()) return take_nearest_start(arm, range, settings, asked, theta0, field.theta, begun, found);
    const solution<T, N> before = found;
    nearest_configuration<T, N> nearest;
    nearest_from<pack<T, searches_in_group>>(arm, range, settings, asked, theta0, field, stopped, nearest);
    for (int k = 0; k < arm.coordinates(); ++k) found.theta[k] = nearest.theta[k];
    out.nearest = true;
    judge(arm, range, settings, asked, theta0, found);
    if (stopped()) take_nearest_start(arm, range, settings, asked, theta0, before.theta, 1, found);
    if (!found.converged) resume(arm, range, settings, asked, theta0, nearest.theta, 1, stopped, found);
    if (found.converged) {
        out.stop = stop_reason::converged;
        return;
    }
    searched<T, N> roots;
    find_unlimited(arm, range, settings, asked, theta0, seed, stopped, roots, out);
    if (found.converged || out.has_unlimited || stopped()) return;
    out.stop = stop_reason::exhausted;
    // The distance of a position that is out of reach does not depend on the rotation.
    const bool decided = nearest.rotation_stationary || found.position_error > settings.position_tolerance;
    if (!nearest.position_stationary || !decided) return;
    out.stop = reason_for(arm, range, settings, asked, reach, found, roots, stopped, out.unlimited);
    out.has_unlimited = out.stop == stop_reason::blocked_by_limits;
}

/// Makes the errors of an answer that is only within loose tolerances as small as the arm allows nearby: first the
/// position's.
template <class T, int N, int M, class Stopped>
void sharpen(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
             const target<T>& asked, Stopped& stopped, solution<T, N>& found) {
    using V = pack<T, searches_in_group>;
    const two_levels<V, T, N, M> objective{arm, asked.kind, aim_in_every_lane<V>(aim_at(arm, asked))};
    descent_lanes<V, N> lanes;
    for (int k = 0; k < arm.coordinates(); ++k) lanes.theta[k] = V(found.theta[k]);
    lanes.epsilon = V(drawn_from<T>);
    descend(objective, without_turning(range, arm.coordinates()), letting_go<T>, lanes, stopped);
    solution<T, N> moved = found;
    for (int k = 0; k < arm.coordinates(); ++k) moved.theta[k] = lane(lanes.theta[k], 0);
    if (judge(arm, range, settings, asked, found.theta, moved)) found = moved;
}

template <class T, int N> void begin(answer<T, N>& out) {
    out.stop = stop_reason::converged;
    out.nearest = out.has_unlimited = out.other_branch = false;
}
}  // namespace detail

/// Whether an answer may need more than `solve` has done. It does not meet the target itself, or it is not near θ₀
/// though another configuration near θ₀ may meet the target.
template <class T, int N>
bool is_open(const solution<T, N>& found, const ranges<T, N>& range, const search_settings<T>& settings,
             target_kind kind, const T* theta0, int n) {
    if (!is_exact(found, settings)) return true;
    const T half = detail::other_branch<T>;
    const T position = greatest(half * range.most_speed, detail::near_position<T>);
    const T rotation = greatest(half * range.most_turning, detail::near_orientation<T>);
    return detail::begins_within(found, settings, kind, position, rotation) &&
           detail::largest_difference(found.theta, theta0, n) > half;
}

template <class T, int N, int M, class Stopped>
void answer_to(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, std::uint64_t seed, T reach, const T* posture, Stopped& stopped,
               answer<T, N>& out);

/// From where the searches have ended to the whole answer. `found` is what `solve` or `solve_batch` have left, `ends`
/// (count, n) where their searches failed, or null. The other arguments are those of `answer_to`.
template <class T, int N, int M, class Stopped>
void conclude(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
              const target<T>& asked, const T* theta0, std::uint64_t seed, T reach, const T* posture, Stopped& stopped,
              const solution<T, N>& found, const T* ends, int count, answer<T, N>& out) {
    const int n = arm.coordinates(), known = ends == nullptr ? 0 : count < most_ends ? count : most_ends;
    T start[capacity(N)];
    for (int k = 0; k < n; ++k) start[k] = theta0[k];
    bring_inside(range, n, start);
    detail::begin(out);
    out.found = found;
    ranges<T, N> there = range;
    if (!found.converged && bring_slides_near(arm, asked, there, start))
        return answer_to(arm, there, settings, asked, start, seed, reach, posture, stopped, out);
    const T* from = known > 0 ? ends : found.theta;
    const int begun = known > 0 ? known : 1;
    if (!is_exact(found, settings)) resume(arm, range, settings, asked, start, from, begun, stopped, out.found);
    if (!out.found.converged) {
        detail::field_of_starts<T, N> field;
        field.count = begun;
        for (int k = 0; k < begun * n; ++k) field.theta[k] = from[k];
        // The best end may be that of a search too late to be kept.
        for (int k = 0; k < n && found.restarts > most_ends; ++k) field.theta[k] = found.theta[k];
        detail::explain(arm, range, settings, asked, start, seed, reach, stopped, field, out);
        if (!out.found.converged) {
            keep_near(arm, range, settings, asked, start, stopped, out.found);
            if (!out.found.converged) {
                out.other_branch = lies_elsewhere(arm, settings, asked, start, out.found);
                return;
            }
            detail::begin(out);
        }
    }
    search_settings<T> alike = settings;
    alike.to_edge = !is_exact(out.found, settings);
    if (!alike.to_edge) polish(arm, range, settings, asked, start, out.found);
    out.other_branch = keep_branch(arm, range, alike, asked, start, stopped, out.found);
    if (alike.to_edge) detail::sharpen(arm, range, settings, asked, stopped, out.found);
    if (posture != nullptr) approach_posture(arm, range, settings, asked, posture, stopped, out.found);
}

/// Inverse kinematics of one target, and where it cannot be reached, the nearest configuration and the reason.
///
/// As `solve`: settings.searches searches from `theta0` (n,) and from random starts of `seed`. Equal calls give equal
/// bits unless stopped() ends them; it is called now and then and returns true when the time is up. `reach` [m] brings
/// metres and radians together for the rank of a task. `posture` (n,) or null: a redundant arm stays near it while it
/// meets the target. Without one, an answer stays on the branch of θ₀ if it can. Numbers that are not finite give the
/// answer "unusable".
template <class T, int N, int M, class Stopped>
void answer_to(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
               const target<T>& asked, const T* theta0, std::uint64_t seed, T reach, const T* posture, Stopped& stopped,
               answer<T, N>& out) {
    if (!is_usable(asked, theta0, arm.coordinates())) {
        detail::begin(out);
        find_nothing(theta0, arm.coordinates(), out.found);
        out.stop = stop_reason::unusable;
        return;
    }
    T ends[most_ends * capacity(N)];
    solution<T, N> found{};
    solve(arm, range, settings, asked, theta0, seed, found, ends, most_ends, stopped);
    conclude(arm, range, settings, asked, theta0, seed, reach, posture, stopped, found, ends, found.restarts, out);
}

TWISTARM_END
