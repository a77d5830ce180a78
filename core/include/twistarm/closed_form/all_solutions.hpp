// All configurations that meet a target, by the closed form of the arm's family. Forward kinematics verifies each.
#pragma once

#include "verification.hpp"

TWISTARM_BEGIN

constexpr int most_configurations = 32;

/// Configurations that meet a target, those inside the limits first, nearest to the start first; then those outside.
template <class T, int N> struct configurations {
    configuration<T, N> found[most_configurations];
    int count, inside;
};

namespace closed_form {

/// What misses a subproblem by less, in shares of its size, is rounding: a stretched arm.
template <class T> constexpr T default_slack = is_double<T> ? T(1e-6) : T(2e-3);

/// Shifts θ by whole turns as near to `near` as the limits allow. θ may exceed a limit by `slack` and is then cut to
/// it. Returns false if it is farther outside.
template <class V, class T, int N>
mask_of<V> nearest_copy(const ranges<T, N>& range, int n, const V* theta, const T* near, T slack, V* copy, mask_of<V>& cut) {
    constexpr T turn = T(whole_turn), rest = static_cast<T>(whole_turn - static_cast<double>(turn));
    const auto turns = [](const V& x) { return x * T(1.0 / whole_turn); };
    auto inside = in_every_lane<V>(true);
    cut = in_every_lane<V>(false);
    for (int k = 0; k < n; ++k) {
        const V lower = V(range.lower[k]), upper = V(range.upper[k]);
        copy[k] = theta[k];
        if (range.periodic[k]) {
            const V wanted = nearest_whole(turns(near[k] - theta[k]));
            const V least_turns = turns((lower - slack) - theta[k]), most_turns = turns((upper + slack) - theta[k]);
            const V from = nearest_whole(least_turns), to = nearest_whole(most_turns);
            const V least_count = select(from < least_turns, from + T(1), from);
            const V most_count = select(to > most_turns, to - T(1), to);
            const V count = greatest(least(wanted, most_count), least_count);
            copy[k] = (theta[k] + count * turn) + count * rest;
        }
        const V clipped = clamped(copy[k], lower, upper), beyond = absolute(clipped - copy[k]);
        inside = inside & (beyond <= V(slack));
        cut = cut | (beyond > V(T(0)));
    }
    return inside;
}

/// Shifts θ by whole turns as near to `near` as the limits allow. Returns false, with θ unchanged, if it is outside.
///
/// A copy may exceed a limit by no more than the error of a multiple root. It moves to the limit if the other joints
/// can then meet the target. Otherwise the other copies remain.
template <class Judge, class T, int N>
bool bring_within(const Judge& judged, const ranges<T, N>& range, int n, const T* near, T* theta) {
    T copy[capacity(N)];
    const T slacks[2] = {precision<T>::at_limit, precision<T>::on_limit};
    for (const T slack : slacks) {
        bool cut = false;
        if (!nearest_copy(range, n, theta, near, slack, copy, cut)) return false;
        if (cut && !judged.meet_at_limits(range, copy)) continue;
        for (int k = 0; k < n; ++k) theta[k] = copy[k];
        return true;
    }
    return false;
}

/// What each joint's distance is a share of: its range, 2π or 1 m where it has none.
template <class T, int N, int M> void find_spans(const chain<T, N, M>& arm, const ranges<T, N>& range, T* span) {
    for (int k = 0; k < arm.coordinates(); ++k) {
        span[k] = range.upper[k] - range.lower[k];
        if (!(span[k] > T(0)) || span[k] - span[k] != T(0)) span[k] = arm.links[k].turn == T(0) ? T(1) : T(whole_turn);
    }
}

/// The largest joint difference, in shares.
template <class V, class T> V distance(int n, const T* span, const V* theta, const T* near) {
    V largest = V(T(0));
    for (int k = 0; k < n; ++k) largest = greatest(largest, absolute(theta[k] - near[k]) / span[k]);
    return largest;
}

/// Some of the candidates side by side, from `first` on. The last lanes of a register repeat the first.
template <class V, class T, int N>
void to_lanes(const solved_arm<T, N>& solved, const T* held_values, const candidate_list<T>& candidates, int first, V* theta) {
    for (int h = 0; h < solved.held_count; ++h) theta[solved.held[h]] = V(held_values[h]);
    for (int i = 0; i < solved.family.count; ++i) {
        const int k = solved.joint[i];
        if (k < 0) continue;
        V x;
        for (int l = 0; l < number<V>::lanes; ++l)
            set_lane(x, l, candidates.items[first + l < candidates.count ? first + l : first].x[i]);
        theta[k] = x * (T(1) / solved.rate[k]);
    }
}

/// The number of answers with the distinct ones among the candidates after the first `count`, each in its copy nearest
/// to `near`.
///
/// Members of a continuous family are added only if none of the first moves the same joints: one member represents the
/// family. `twins` is set if two answers are one within the tolerances.
template <class Judge, class T, int N>
int verify(const Judge& judged, const solved_arm<T, N>& solved, const ranges<T, N>& range, int n, const T* near,
           const T* held_values, const T* span, const candidate_list<T>& candidates, configuration<T, N>* answers, int count,
           bool& twins) {
    constexpr int lanes = lanes_at_once<T>;
    using V = pack<T, lanes>;
    const auto bit = [](unsigned all, int l) { return (all >> l & 1U) != 0; };
    const int before = count;
    for (int first = 0; first < candidates.count; first += lanes) {
        V theta[capacity(N)], copy[capacity(N)];
        mask_of<V> cut;
        to_lanes(solved, held_values, candidates, first, theta);
        unsigned done = 0, hardly_missed = 0, known = 0;
        judged.step(theta, done, hardly_missed);
        const unsigned inside = bits(nearest_copy(range, n, theta, near, precision<T>::at_limit, copy, cut));
        const unsigned by_itself = done & ~bits(cut);
        const V away = distance(n, span, copy, near);
        for (int other = 0; other < count; ++other) known |= judged.near_to(range, theta, answers[other].theta);
        for (int l = 0; l < lanes && first + l < candidates.count && count < most_configurations; ++l) {
            configuration<T, N>& one = answers[count];
            const bool regular = bit(done, l), free_to_move = candidates.items[first + l].free != 0;
            // If a joint is fixed at its current value, the others may be far from the root that Newton's method finds.
            if (!regular && !free_to_move && !bit(hardly_missed, l)) continue;
            for (int k = 0; k < n; ++k) one.theta[k] = lane(bit(by_itself, l) ? copy[k] : theta[k], l);
            if (!regular && !judged.correct(one.theta, free_to_move ? precision<T>::steps : precision<T>::patience)) continue;
            bool again = false;
            for (int other = 0; other < count && !again && (!regular || bit(known, l)); ++other) {
                const relation both = judged.compare(range, one.theta, answers[other].theta);
                again = both == relation::same;
                twins = twins || both == relation::twins;
            }
            if (again) continue;
            one.free = regular ? 0 : judged.self_motion(one.theta);
            one.family = one.free != 0;
            one.free |= solved.idle;
            for (int other = 0; other < before && one.family && !again; ++other)
                again = answers[other].family && answers[other].free == one.free;
            if (again) continue;
            one.inside = bit(by_itself, l) ? bit(inside, l) : bring_within(judged, range, n, near, one.theta);
            one.distance = bit(by_itself, l) ? lane(away, l) : distance(n, span, one.theta, near);
            known |= judged.near_to(range, theta, one.theta);
            ++count;
        }
    }
    return count;
}

/// The answers in their order: those inside before the others, and among them by distance.
template <class T, int N> void arrange(const configuration<T, N>* answers, int count, configurations<T, N>& all) {
    int order[most_configurations];
    all.count = all.inside = 0;
    for (int i = 0; i < count; ++i) {
        int at = all.count++;
        if (answers[i].inside) {
            const int place = all.inside++;
            for (; at > place; --at) order[at] = order[at - 1];
            for (; at > 0 && answers[i].distance < answers[order[at - 1]].distance; --at) order[at] = order[at - 1];
        }
        order[at] = i;
    }
    for (int i = 0; i < count; ++i) all.found[i] = answers[order[i]];
}

/// The same without those that are twins of one before them, which may move as they may.
template <class Judge, class T, int N>
__attribute__((noinline, cold)) void drop_twins(const Judge& judged, const ranges<T, N>& range, configurations<T, N>& all) {
    int kept = 0, inside = 0;
    for (int i = 0; i < all.count; ++i) {
        int twin = 0;
        while (twin < kept && judged.compare(range, all.found[i].theta, all.found[twin].theta) == relation::different) ++twin;
        if (twin < kept) {
            all.found[twin].free |= all.found[i].free;
            all.found[twin].family = all.found[twin].family || all.found[i].family;
            continue;
        }
        inside += i < all.inside;
        all.found[kept++] = all.found[i];
    }
    all.count = kept;
    all.inside = inside;
}

}  // namespace closed_form

/// The answers among candidates: `next(nth, candidates)` fills list after list, and returns whether more follow.
template <class T, int N, int M, class Target, class Next>
void find_among(const chain<T, N, M>& arm, const solved_arm<T, N>& solved, const ranges<T, N>& range, const Target& asked,
                const T* near, const T* held_values, T position_tolerance, T orientation_tolerance, const Next& next,
                configurations<T, N>& all) {
    all.count = all.inside = 0;
    with_kind(asked, [&](auto kind) {
        if constexpr (kind() != target_kind::task) {
            const closed_form::judge<kind(), T, N, M> judged(arm, solved, asked, position_tolerance, orientation_tolerance);
            T span[capacity(N)];
            closed_form::find_spans(arm, range, span);
            configuration<T, N> answers[most_configurations];
            int count = 0;
            bool twins = false, more = true;
            for (int nth = 0; more; ++nth) {
                closed_form::candidate_list<T> candidates;
                more = next(nth, candidates);
                count = closed_form::verify(judged, solved, range, arm.coordinates(), near, held_values, span, candidates,
                                            answers, count, twins);
            }
            closed_form::arrange(answers, count, all);
            if (twins) closed_form::drop_twins(judged, range, all);
        }
    });
}

/// All configurations that meet the target. Each continuous family has one member, with its free joint as in `near`.
///
/// `solved`: the arm's family for this kind of target and, for an approach, this tool axis. near (n,): the reference
/// for distances, and the values of free joints. held_values: θ of the held joints. Tolerances are in m and rad; each
/// answer meets the target to rounding if it can.
template <class T, int N, int M, class Target>
void find_all(const chain<T, N, M>& arm, const solved_arm<T, N>& solved, const ranges<T, N>& range, const Target& asked,
              const T* near, const T* held_values, T position_tolerance, T orientation_tolerance,
              configurations<T, N>& all) {
    unsigned open = 0;
    const auto next = [&](int nth, closed_form::candidate_list<T>& found) {
        closed_form::find_candidates(solved, asked, near, held_values, closed_form::default_slack<T>, open, nth, found);
        return open != 0 && nth + 1 < closed_form::values_tried;
    };
    find_among(arm, solved, range, asked, near, held_values, position_tolerance, orientation_tolerance, next, all);
}

TWISTARM_END
