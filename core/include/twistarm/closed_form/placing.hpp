// Places a point or a plane with up to three joints: all x with E₁(x₁) ⋯ Eₖ(xₖ) X = Y.
//
// The middle joint keeps two numbers of what it moves, so E₃(x₃) X and E₁(x₁)⁻¹ Y must agree in them. For a point p and
// a turn about (w, o) they are w · (p − o) and ‖p − o‖²; for a slide, the two coordinates normal to w. For a plane (n,
// d) they are w · n and d − n · o; for a slide, two components of n. These are two conditions on x₁ and x₃. x₂ is the
// remaining turn or slide (subproblem 1). For points, Pieper (1968) solves the first three joints of an arm with a
// spherical wrist this way. For planes it solves three parallel axes.
#pragma once

#include "two_conditions.hpp"

TWISTARM_BEGIN

namespace closed_form {

/// A turn hardly moves a point that is nearer to its axis than this [m], or a direction that is as near to parallel. A
/// double root has half of the digits and can end here. Any first value of the turn is then good enough.
template <class T> constexpr T on_axis = is_double<T> ? T(1e-7) : T(1e-4);

/// Values of up to three joints.
template <class V> struct placement {
    joint_value<V> x[3];
};

template <class V> using placements = few<placement<V>, 8, mask_of<V>>;

/// x with E(x) X = Y as near as can be; `near`, free, where any would do. Subproblem 1, MLS §3.3.2, for planes and slides too.
template <class T, class A, class B>
joint_value<wider<A, B>> settle(const joint_axis<T>& axis, const feature<A>& X, const feature<B>& Y, const joint_value<T>& near) {
    using V = wider<A, B>;
    const joint_value<V> any_value(set_free(near));
    if (axis.slides && X.plane) {
        const V share = V(dot(axis.w, X.v));
        return select(absolute(share) < V(nothing<T>), any_value, slid((Y.d - X.d) / share));
    }
    if (axis.slides) {
        const V away[3] = {Y.v[0] - X.v[0], Y.v[1] - X.v[1], Y.v[2] - X.v[2]};
        return slid(dot(axis.w, away));
    }
    A a[3], rotated_a[3];
    B b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = X.plane ? X.v[k] : X.v[k] - axis.o[k];
        b[k] = Y.plane ? Y.v[k] : Y.v[k] - axis.o[k];
    }
    const A along_a = dot(axis.w, a);
    const B along_b = dot(axis.w, b);
    for (int k = 0; k < 3; ++k) {
        a[k] = a[k] - along_a * axis.w[k];
        b[k] = b[k] - along_b * axis.w[k];
    }
    const V shorter = least(V(dot(a, a)), V(dot(b, b)));
    cross(axis.w, a, rotated_a);
    return select(shorter < V(on_axis<T> * on_axis<T>), any_value, rotated(dot(a, b), dot(rotated_a, b)));
}

namespace detail {
/// The two numbers of X that moving along the middle joint does not change.
template <class T, class V> void kept_numbers(const joint_axis<T>& middle, const feature<V>& X, V kept[2]) {
    if (middle.slides) {
        T u[3], v[3];
        across(middle.w, u, v);
        kept[0] = dot(u, X.v);
        kept[1] = dot(v, X.v);
    } else if (X.plane) {
        kept[0] = dot(middle.w, X.v);
        kept[1] = X.d - dot(X.v, middle.o);
    } else {
        const V away[3] = {X.v[0] - middle.o[0], X.v[1] - middle.o[1], X.v[2] - middle.o[2]};
        kept[0] = dot(middle.w, away);
        kept[1] = dot(away, away);
    }
}

/// The kept numbers of E(sense · x) X: the constant part, and the parts in cos x and sin x, or in x and x² for a slide.
template <class T> struct kept_along {
    T constant[2], A[2][2];

    kept_along(const joint_axis<T>& middle, const joint_axis<T>& axis, const feature<T>& X, T sense) {
        T still[3], first[3], second[3] = {T(0), T(0), T(0)};
        if (axis.slides) {
            for (int k = 0; k < 3; ++k) {
                still[k] = X.v[k];
                first[k] = X.plane ? T(0) : sense * axis.w[k];
            }
        } else {
            const T from[3] = {X.v[0] - (X.plane ? T(0) : axis.o[0]), X.v[1] - (X.plane ? T(0) : axis.o[1]),
                               X.v[2] - (X.plane ? T(0) : axis.o[2])};
            const parted<T> parts(axis.w, from);
            for (int k = 0; k < 3; ++k) {
                still[k] = parts.along[k] + (X.plane ? T(0) : axis.o[k]);
                first[k] = parts.across[k];
                second[k] = sense * parts.rotated[k];
            }
        }
        if (middle.slides) {
            T u[3], v[3];
            across(middle.w, u, v);
            set(0, dot(u, still), dot(u, first), dot(u, second));
            set(1, dot(v, still), dot(v, first), dot(v, second));
        } else if (X.plane) {
            set(0, dot(middle.w, still), dot(middle.w, first), dot(middle.w, second));
            if (axis.slides) {
                set(1, X.d - dot(X.v, middle.o), sense * dot(X.v, axis.w), T(0));
            } else {
                const T lever[3] = {axis.o[0] - middle.o[0], axis.o[1] - middle.o[1], axis.o[2] - middle.o[2]};
                set(1, X.d - dot(X.v, axis.o) + dot(still, lever), dot(first, lever), dot(second, lever));
            }
        } else {
            for (int k = 0; k < 3; ++k) still[k] -= middle.o[k];
            set(0, dot(middle.w, still), dot(middle.w, first), dot(middle.w, second));
            const T square = dot(first, first), base = dot(still, still);
            if (axis.slides) set(1, base, T(2) * dot(still, first), square);
            else set(1, base + square, T(2) * dot(still, first), T(2) * dot(still, second));
        }
    }

private:
    void set(int row, T still, T first, T second) {
        constant[row] = still;
        A[row][0] = first;
        A[row][1] = second;
    }
};

/// The first joint is the middle one: nothing stands before it.
template <class T, class V>
void place_by_two(const joint_axis<T>* axes, const feature<T>& X, const feature<V>& Y, const joint_value<T>* near,
                  V slack, placements<V>& found) {
    const kept_along<T> along(axes[0], axes[1], X, T(1));
    V e[2];
    kept_numbers(axes[0], Y, e);
    side<T> last{{}, axes[1].slides, near[1]};
    for (int i = 0; i < 2; ++i) {
        e[i] = e[i] - along.constant[i];
        for (int k = 0; k < 2; ++k) last.A[i][k] = along.A[i][k];
    }
    const roots<V, 4> y = one_joint(last, e, slack);
    for (int r = 0; r < y.count; ++r)
        found.add({{settle(axes[0], moved(axes[1], y.items[r], X), Y, near[0]), y.items[r], {}}}, y.there[r]);
}

template <class T>
void place_by_three(const joint_axis<T>* axes, const feature<T>& X, const feature<T>& Y, const joint_value<T>* near,
                    T slack, placements<T>& found) {
    const kept_along<T> before(axes[1], axes[0], Y, T(-1)), behind(axes[1], axes[2], X, T(1));
    side<T> first{{}, axes[0].slides, near[0]}, last{{}, axes[2].slides, near[2]};
    T e[2];
    for (int i = 0; i < 2; ++i) {
        e[i] = before.constant[i] - behind.constant[i];
        for (int k = 0; k < 2; ++k) {
            first.A[i][k] = -before.A[i][k];
            last.A[i][k] = behind.A[i][k];
        }
    }
    constexpr int lanes = lanes_at_once<T, 4>;
    using V = pack<T, lanes>;
    const pairs<T> beside = two_conditions(first, last, e, slack);
    for (int start = 0; start < beside.count; start += lanes) {
        const int count = least(lanes, beside.count - start);
        const auto at = [&](int l) { return beside.items[start + (l < count ? l : 0)]; };
        const joint_value<V> x = in_lanes<V>([&](int l) { return at(l).x; }), y = in_lanes<V>([&](int l) { return at(l).y; });
        const joint_value<V> middle = settle(axes[1], moved(axes[2], y, X), moved(axes[0], back(x), Y), near[1]);
        for (int l = 0; l < count; ++l) found.add({{at(l).x, lane(middle, l), at(l).y}});
    }
}
}  // namespace detail

/// All x with E₁(x₁) ⋯ Eₖ(xₖ) X = Y, k ≤ 3. With too few joints, in the least-squares sense.
///
/// Where any value would do, a joint takes that of `near`. What just misses by `slack` counts. In the lanes of a pack Y is
/// at several places, for at most two joints.
template <class T, class V>
placements<V> place(const joint_axis<T>* axes, int count, const feature<T>& X, const feature<V>& Y,
                  const joint_value<T>* near, V slack) {
    placements<V> found;
    const auto always = in_every_lane<V>(true);
    if (count == 0) found.add({}, always);
    if (count == 1) found.add({{settle(axes[0], X, Y, near[0]), {}, {}}}, always);
    if (count == 2) detail::place_by_two(axes, X, Y, near, slack, found);
    if constexpr (number<V>::lanes == 1)
        if (count == 3) detail::place_by_three(axes, X, Y, near, slack, found);
    return found;
}

}  // namespace closed_form

TWISTARM_END
