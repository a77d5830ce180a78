// A family's closed form: all candidates for x with E₁(x₁) ⋯ Eₖ(xₖ) = G.
//
// E_L, E_K, E_R are the products of the joints before the group, in it and after it: E_K = E_L⁻¹ G E_R⁻¹. E_K does not
// move the point or plane X, so E_L X = G E_R⁻¹ X. Seen from G, the joints after the group come before the others. So a
// single chain of at most three joints has to place X.
#pragma once

#include "group.hpp"

TWISTARM_BEGIN

/// Unknowns of a closed form, at most.
constexpr int most_unknowns = 6;

/// An arm's axes in the order of the solution. Those in [first, last) are the group that leaves `kept` unmoved. The
/// group has at most three joints, and so has the rest. With at most three turns and three slides whose group keeps
/// nothing, the group has all of them.
template <class T> struct fitted_family {
    int count, first, last;
    closed_form::keeps keeps;
    closed_form::joint_axis<T> axes[most_unknowns];
    closed_form::feature<T> kept;
};

namespace closed_form {

/// A candidate with a smaller error [m, or numbers of a rotation] is an answer up to rounding.
template <class T> constexpr T rounded = is_double<T> ? T(1e-12) : T(1e-5);

/// The number of values tried for a free joint if its current value gives no answer. They cover a turn, or a length of
/// 2π m, evenly, the nearest first.
constexpr int values_tried = 16;

/// x [rad, m] in the order of the family's axes, and which of them are free, as bits.
template <class T> struct candidate {
    T x[most_unknowns];
    unsigned free;
};

constexpr int most_candidates = 64;
template <class T> using candidate_list = few<candidate<T>, most_candidates>;

namespace detail {
/// Whether E₁(x₁) ⋯ Eₖ(xₖ) is G.
template <class T> bool is_reached(const fitted_family<T>& family, const candidate<T>& item, const frame<T>& G) {
    frame<T> g = identity_frame<T>();
    for (int i = family.count - 1; i >= 0; --i) move_frame(family.axes[i], value_of(family.axes[i], item.x[i]), g);
    T off = T(0);
    for (int k = 0; k < 3; ++k)
        off = greatest(off, greatest(greatest(absolute(g.x[k] - G.x[k]), absolute(g.y[k] - G.y[k])),
                                     greatest(absolute(g.z[k] - G.z[k]), absolute(g.p[k] - G.p[k]))));
    return off <= rounded<T>;
}

/// At most three turns in different directions and at most three slides, in any order. The rotation gives the turns.
template <class T>
void find_decoupled(const fitted_family<T>& family, const frame<T>& G, const joint_value<T>* near, T slack, bool free_ones,
                    candidate_list<T>& found) {
    joint_axis<T> axes[3];
    joint_value<T> wanted[3];
    int turning[3], count = 0;
    for (int i = 0; i < family.count; ++i)
        if (!family.axes[i].slides && count < 3) {
            axes[count] = family.axes[i];
            wanted[count] = near[i];
            turning[count++] = i;
        }
    placements<T> turns;
    rotating(group<T>{axes, count, family.kept}, G, wanted, slack, turns);
    for (const placement<T>& item : turns) {
        joint_value<T> x[most_unknowns];
        for (int i = 0; i < family.count; ++i) x[i] = slid(T(0));
        for (int i = 0; i < count; ++i) x[turning[i]] = item.x[i];
        set_slides(family.axes, family.count, G, x);
        candidate<T> one{{}, 0};
        for (int i = 0; i < family.count; ++i) {
            one.x[i] = coordinate_of(family.axes[i], x[i]);
            one.free |= static_cast<unsigned>(x[i].free) << i;
        }
        if (!free_ones || one.free != 0) found.add(one);
    }
}

/// The candidates of several placings of the kept point or plane, from `start` on, side by side in the lanes of V.
template <class V, class T>
void find_behind(const fitted_family<T>& family, const group<T>& inner, const frame<T>& G, const joint_axis<T>* chain,
                 const placements<T>& outer, int start, const joint_value<T>* near, T slack, bool free_ones,
                 candidate_list<T>& found) {
    constexpr int lanes = number<V>::lanes;
    const int before = family.first, behind = family.count - family.last, count = least(lanes, outer.count - start);
    candidate<V> item;
    unsigned beside_free[lanes] = {}, inside_free[lanes];
    V inner_slack = V(slack);
    // G E_R⁻¹ = (motions of the axes behind, seen through G)⁻¹ G, and E_L⁻¹ goes before it.
    frame<V> E = converted<V>(G);
    for (int i = 0; i < behind + before; ++i) {
        const int at = i < behind ? family.last + i : i - behind;
        const joint_value<V> x = in_lanes<V>([&](int l) { return outer.items[start + (l < count ? l : 0)].x[i]; });
        for (unsigned any = bits(x.free), l = 0; any != 0; any >>= 1U, ++l) beside_free[l] |= (any & 1U) << at;
        inner_slack = select(x.free, V(nearest<T>), inner_slack);
        move_frame(chain[i], back(x), E);
        item.x[at] = coordinate_of(family.axes[at], x);
    }
    const placements<V> inside = within(inner, E, near + family.first, inner_slack);
    for (int r = 0; r < inside.count; ++r) {
        const placement<V>& more = inside.items[r];
        for (int l = 0; l < lanes; ++l) inside_free[l] = beside_free[l];
        for (int i = 0; i < inner.count; ++i) {
            item.x[before + i] = coordinate_of(inner.axes[i], more.x[i]);
            for (unsigned all = bits(more.x[i].free), l = 0; all != 0; all >>= 1U, ++l)
                inside_free[l] |= (all & 1U) << (before + i);
        }
        for (int l = 0; l < count; ++l) {
            if ((bits(inside.there[r]) >> l & 1U) == 0 || (free_ones && inside_free[l] == 0)) continue;
            candidate<T> one;
            for (int i = 0; i < family.count; ++i) one.x[i] = lane(item.x[i], l);
            one.free = inside_free[l];
            found.add(one);
        }
    }
}

/// The candidates with free joints at `near`; with `free_ones`, only those that have a free joint.
template <class T>
void find_with(const fitted_family<T>& family, const frame<T>& G, const joint_value<T>* near, T slack, bool free_ones,
               candidate_list<T>& found) {
    if (family.keeps == keeps::nothing) return find_decoupled(family, G, near, slack, free_ones, found);
    const int before = family.first, behind = family.count - family.last;
    joint_axis<T> chain[3];
    joint_value<T> wanted[3];
    for (int i = 0; i < behind; ++i) {
        chain[i] = seen(family.axes[family.last + i], G);
        wanted[i] = near[family.last + i];
    }
    for (int i = 0; i < before; ++i) {
        chain[behind + i] = family.axes[i];
        wanted[behind + i] = near[i];
    }
    const group<T> inner{family.axes + family.first, family.last - family.first, family.kept};
    const placements<T> outer = place(chain, before + behind, family.kept, moved(G, family.kept), wanted, slack);
    constexpr int lanes = lanes_at_once<T, 4>;
    for (int start = 0; start < outer.count; start += lanes)
        find_behind<pack<T, lanes>>(family, inner, G, chain, outer, start, near, slack, free_ones, found);
}
}  // namespace detail

/// A superset of the x with E₁(x₁) ⋯ Eₖ(xₖ) = G. Forward kinematics decides which are roots.
///
/// A free joint has its value in `near`, in the family's order. Returns, as bits, the free joints of candidates that
/// may become an answer with another value.
template <class T>
unsigned find_candidates(const fitted_family<T>& family, const frame<T>& G, const joint_value<T>* near, T slack,
                         candidate_list<T>& found) {
    detail::find_with(family, G, near, slack, false, found);
    unsigned open = 0;
    for (const candidate<T>& item : found)
        if (item.free != 0 && !detail::is_reached(family, item, G)) open |= item.free;
    return open;
}

/// The candidates with a free joint, with the `open` joints at the nth of the tried values.
template <class T>
void find_elsewhere(const fitted_family<T>& family, const frame<T>& G, const joint_value<T>* near, T slack, unsigned open,
                    int nth, candidate_list<T>& found) {
    const T away = T(whole_turn / values_tried * ((nth + 1) / 2) * (nth % 2 == 0 ? -1 : 1));
    joint_value<T> tried[most_unknowns];
    for (int i = 0; i < family.count; ++i)
        tried[i] = (open >> i & 1U) == 0 ? near[i] : near[i] + value_of(family.axes[i], away);
    detail::find_with(family, G, tried, slack, true, found);
}

}  // namespace closed_form

TWISTARM_END
