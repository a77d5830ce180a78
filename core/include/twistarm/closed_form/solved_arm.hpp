// An arm's closed form for one kind of target: the family of its joints and of the turns that the target leaves free.
#pragma once

#include "../ik/aim.hpp"
#include "candidates.hpp"

TWISTARM_BEGIN

/// What twistarm's Python has recognised of an arm (src/twistarm/ik/closed_form), as numbers.
///
/// E₁(x₁) ⋯ Eₙ(xₙ) V₁ ⋯ Vₖ = g home⁻¹ with x = rate θ. V is one turn about the tool axis for an approach, and three
/// turns about the tool's origin for a position. Surplus joints are `held` at given values and move the joints after
/// them. The family's axes are those with the held joints at 0.
template <class T, int N> struct solved_arm {
    fitted_family<T> family;
    int joint[most_unknowns];  ///< which coordinate each of the family's axes is; -1: a turn that the target leaves free
    int held_count, held[capacity(N)];  ///< base to tip
    closed_form::joint_axis<T> held_axes[capacity(N)];
    T rate[capacity(N)];
    frame<T> home;
    std::uint64_t idle;  ///< coordinates, as bits, that any answer may move, because they were held though not given
};

namespace closed_form {

/// The family with the held joints at `values` of θ, and the factor of the pose after home⁻¹.
template <class T, int N>
void hold(const solved_arm<T, N>& arm, const T* values, fitted_family<T>& family, frame<T>& behind) {
    family = arm.family;
    behind = identity_frame<T>();
    if (arm.held_count == 0) return;
    frame<T> carried[capacity(N)];
    for (int h = 0; h < arm.held_count; ++h) {
        behind = product(behind, motion(arm.held_axes[h], value_of(arm.held_axes[h], arm.rate[arm.held[h]] * values[h])));
        carried[h] = behind;
    }
    int carrier = family.first;  // a slide of the group may stand elsewhere among the joints; what turns carries the normal
    while (carrier + 1 < family.last && family.axes[carrier].slides) ++carrier;
    for (int i = 0; i < family.count; ++i) {
        int h = -1;
        while (h + 1 < arm.held_count && (arm.joint[i] < 0 || arm.held[h + 1] < arm.joint[i])) ++h;
        if (h < 0) continue;
        family.axes[i] = seen(family.axes[i], carried[h]);
        if (i == carrier) family.kept = moved(carried[h], family.kept);
    }
    behind = inverse(behind);
}

/// A pose that meets the target.
template <class T> frame<T> any_pose(const target<T>& asked) {
    frame<T> g = asked.goal;
    if (asked.kind == target_kind::approach)
        g = product(twistarm::detail::rotation_onto(asked.direction), inverse(twistarm::detail::rotation_onto(asked.tool_axis)));
    for (int k = 0; k < 3; ++k) g.p[k] = asked.goal.p[k];
    return g;
}

/// The values of the family's axes at θ.
template <class T, int N> void values_at(const solved_arm<T, N>& arm, const T* theta, joint_value<T>* values) {
    constexpr int lanes = lanes_at_once<T>;
    for (int start = 0; start < most_unknowns; start += lanes) {
        const int end = least(start + lanes, most_unknowns);
        pack<T, lanes> x = T(0), sine, cosine;
        for (int i = start; i < end; ++i)
            if (i < arm.family.count && arm.joint[i] >= 0) set_lane(x, i - start, theta[arm.joint[i]] * arm.rate[arm.joint[i]]);
        sincos(x, sine, cosine);
        for (int i = start; i < end; ++i) {
            const joint_value<T> turn(lane(cosine, i - start), lane(sine, i - start), T(0));
            if (i < arm.family.count) values[i] = arm.family.axes[i].slides ? slid(lane(x, i - start)) : turn;
        }
    }
}

/// Candidates for θ (n,) from the values of the family's axes. Free joints are as in `near` (n,). With `nth` above 0:
/// only those with their `open` joints at the nth other value.
template <class T, int N>
void find_candidates(const solved_arm<T, N>& arm, const target<T>& asked, const T* near, const T* held_values, T slack,
                     unsigned& open, int nth, candidate_list<T>& found) {
    fitted_family<T> family;
    frame<T> behind;
    hold(arm, held_values, family, behind);
    joint_value<T> wanted[most_unknowns];
    values_at(arm, near, wanted);
    const frame<T> G = product(product(any_pose(asked), inverse(arm.home)), behind);
    if (nth == 0) open = find_candidates(family, G, wanted, slack, found);
    else find_elsewhere(family, G, wanted, slack, open, nth, found);
}

}  // namespace closed_form

TWISTARM_END
