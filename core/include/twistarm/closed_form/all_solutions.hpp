// Every configuration that meets a target, by the closed form of the arm's family, each verified by forward kinematics.
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

/// θ by whole turns as near to `near` as the limits allow, which it may pass by `slack` and is then brought to; false where
/// it is farther outside.
template <class T, int N>
bool nearest_copy(const ranges<T, N>& range, int n, const T* theta, const T* near, T slack, T* copy, bool& cut) {
    const auto turns = [](T x) { return static_cast<double>(x) * (1.0 / whole_turn); };
    cut = false;
    for (int k = 0; k < n; ++k) {
        const T lower = range.lower[k], upper = range.upper[k];
        copy[k] = theta[k];
        if (range.periodic[k]) {
            const double wanted = __builtin_rint(turns(near[k] - theta[k]));
            const double least_count = __builtin_ceil(turns(lower - slack - theta[k]));
            const double most_count = __builtin_floor(turns(upper + slack - theta[k]));
            const double count = greatest(least(wanted, most_count), least_count);
            copy[k] = static_cast<T>(static_cast<double>(theta[k]) + whole_turn * count);
        }
        const T clipped = clamped(copy[k], lower, upper);
        if (!(absolute(clipped - copy[k]) <= slack)) return false;
        cut = cut || clipped != copy[k];
        copy[k] = clipped;
    }
    return true;
}

/// θ by whole turns inside the limits, as near to `near` as they allow; false where it is outside, and then unchanged.
///
/// A copy that passes a limit by rounding is brought to the limit, if the target is met there too; if it is not, other
/// copies are left.
template <class Judge, class T, int N>
bool bring_within(const Judge& judged, const ranges<T, N>& range, int n, const T* near, T* theta) {
    T copy[capacity(N)];
    const T slacks[2] = {precision<T>::at_limit, precision<T>::on_limit};
    for (const T slack : slacks) {
        bool cut = false;
        if (!nearest_copy(range, n, theta, near, slack, copy, cut)) return false;
        if (cut && !judged.meets(copy)) continue;
        for (int k = 0; k < n; ++k) theta[k] = copy[k];
        return true;
    }
    return false;
}

/// The largest joint difference, in shares of the joint's range, 2π or 1 m where it has none.
template <class T, int N, int M>
T distance(const chain<T, N, M>& arm, const ranges<T, N>& range, const T* theta, const T* near) {
    T largest = T(0);
    for (int k = 0; k < arm.coordinates(); ++k) {
        T span = range.upper[k] - range.lower[k];
        if (!(span > T(0)) || span - span != T(0)) span = arm.links[k].turn == T(0) ? T(1) : T(whole_turn);
        largest = greatest(largest, absolute(theta[k] - near[k]) / span);
    }
    return largest;
}

/// A configuration into its place: those inside before the others, and among them by distance.
template <class T, int N> void put(configurations<T, N>& all, const configuration<T, N>& one) {
    if (all.count == most_configurations) return;
    int at = all.count++;
    if (one.inside) {
        int place = all.inside++;
        for (; at > place; --at) all.found[at] = all.found[at - 1];
        for (; at > 0 && one.distance < all.found[at - 1].distance; --at) all.found[at] = all.found[at - 1];
    }
    all.found[at] = one;
}

/// How many answers there are with the different ones among the candidates behind the first `count`.
///
/// Members of a continuous family are added only where none of the first moves the same joints: those at the value at hand
/// stand for the others.
template <class Judge, class T, int N>
int verify(const Judge& judged, const solved_arm<T, N>& solved, const ranges<T, N>& range, int n, const T* held_values,
           const candidate_list<T>& candidates, T (*answers)[capacity(N)], std::uint32_t* moving, int count) {
    constexpr int lanes = lanes_at_once<T>;
    using V = pack<T, lanes>;
    const int before = count;
    for (int first = 0; first < candidates.count; first += lanes) {
        V theta[capacity(N)];
        for (int h = 0; h < solved.held_count; ++h) theta[solved.held[h]] = V(held_values[h]);
        for (int i = 0; i < solved.family.count; ++i) {
            const int k = solved.joint[i];
            if (k < 0) continue;
            V cosine, sine, length;
            for (int l = 0; l < lanes; ++l) {
                const int c = first + l < candidates.count ? first + l : first;
                const joint_value<T>& x = candidates.items[c].x[i];
                set_lane(cosine, l, x.cosine);
                set_lane(sine, l, x.sine);
                set_lane(length, l, x.length);
            }
            theta[k] = (solved.family.axes[i].slides ? length : arctangent(sine, cosine)) / solved.rate[k];
        }
        unsigned done = 0, near = 0;
        judged.step(theta, done, near);
        for (int l = 0; l < lanes && first + l < candidates.count && count < most_configurations; ++l) {
            T* const answer = answers[count];
            const bool regular = (done >> l & 1U) != 0, free_to_move = candidates.items[first + l].free(solved.family.count) != 0;
            // With a joint at a value at hand the others may be far from where Newton's method takes them all.
            if (!regular && !free_to_move && (near >> l & 1U) == 0) continue;
            for (int k = 0; k < n; ++k) answer[k] = lane(theta[k], l);
            if (!regular && !judged.correct(answer, free_to_move ? precision<T>::steps : 3)) continue;
            bool known = false;
            for (int other = 0; other < count && !known; ++other) known = judged.same(range, answer, answers[other]);
            if (known) continue;
            const std::uint32_t family = regular ? 0 : judged.self_motion(answer);
            for (int other = 0; other < before && family != 0 && !known; ++other) known = moving[other] == family;
            if (!known) moving[count++] = family;
        }
    }
    return count;
}

}  // namespace closed_form

/// Every configuration that meets the target, and, where an answer is one of a continuous family, the one at hand.
///
/// `solved`: what has been recognised of the arm, for this kind of target and, of an approach, this tool axis. near (n,):
/// where distances are counted from, and where a joint stands for which any value would do. held_values: θ of the joints
/// that are held. Tolerances in m and rad; each answer is met to rounding where it can be.
template <class T, int N, int M, class Target>
void find_all(const chain<T, N, M>& arm, const solved_arm<T, N>& solved, const ranges<T, N>& range, const Target& asked,
              const T* near, const T* held_values, T position_tolerance, T orientation_tolerance,
              configurations<T, N>& all) {
    all.count = all.inside = 0;
    with_kind(asked, [&](auto kind) {
        if constexpr (kind() != target_kind::task) {
            const closed_form::judge<kind(), T, N, M> judged(arm, solved, asked, position_tolerance, orientation_tolerance);
            const int n = arm.coordinates();
            T answers[most_configurations][capacity(N)];
            std::uint32_t moving[most_configurations];
            int count = 0;
            unsigned open = 0;
            for (int nth = 0; nth == 0 || (open != 0 && nth < closed_form::values_tried); ++nth) {
                closed_form::candidate_list<T> candidates;
                closed_form::find_candidates(solved, asked, near, held_values, closed_form::default_slack<T>, open, nth,
                                             candidates);
                count = closed_form::verify(judged, solved, range, n, held_values, candidates, answers, moving, count);
            }
            for (int i = 0; i < count; ++i) {
                configuration<T, N> one;
                for (int k = 0; k < n; ++k) one.theta[k] = answers[i][k];
                one.free = moving[i] | solved.idle;
                one.family = moving[i] != 0;
                one.inside = closed_form::bring_within(judged, range, n, near, one.theta);
                one.distance = closed_form::distance(arm, range, one.theta, near);
                closed_form::put(all, one);
            }
        }
    });
}

TWISTARM_END
