// A group of joints that leaves a point or a plane unmoved: all x with E₁(x₁) ⋯ Eₖ(xₖ) = E, k ≤ 3.
//
// The joints are numbers of type T. E and x are of type V: T, or a pack of T for several E at once.
#pragma once

#include "placing.hpp"

TWISTARM_BEGIN

namespace closed_form {

/// Successive joints and what they leave unmoved: the point where their axes meet, or a plane. The plane is normal to
/// parallel turn axes and contains the slide axes.
template <class T> struct group {
    const joint_axis<T>* axes;
    int count;
    feature<T> kept;
};

namespace detail {
/// The turn about w that takes u, across it, to `there`.
template <class T, class V> joint_value<V> turn_between(const T w[3], const T u[3], const V there[3]) {
    T v[3];
    cross(w, u, v);
    return rotated(dot(u, there), dot(v, there));
}

/// The middle joint has moved the last axis; x₁ turns it to where E takes it. The last joint makes the remaining turn.
/// `between`: the value of the middle joint, or null.
template <class T, class V>
void first_and_last(const group<T>& wrist, const frame<V>& E, const V middle[3], const joint_value<V>* between,
                    const joint_value<T>& near, const mask_of<V>& where, placements<V>& found) {
    const joint_axis<T>&first = wrist.axes[0], &last = wrist.axes[wrist.count - 1];
    T u[3], v[3];
    V there[3];
    rotate(E, last.w, there);
    const feature<V> from{true, {middle[0], middle[1], middle[2]}, V(0)}, to{true, {there[0], there[1], there[2]}, V(0)};
    const joint_value<V> x = settle(first, from, to, near);
    across(last.w, u, v);
    rotate(E, u, there);
    move_direction(first, back(x), there);
    if (between != nullptr) move_direction(wrist.axes[1], back(*between), there);
    const joint_value<V> rest = turn_between(last.w, u, there);
    found.add(between == nullptr ? placement<V>{{x, rest, {}}} : placement<V>{{x, *between, rest}}, where);
}

/// The angle between unit vectors.
template <class T, class V> V angle_between(const T a[3], const V b[3]) {
    V c[3];
    cross(a, b, c);
    return arctangent(sqrt(dot(c, c)), dot(a, b));
}

/// The turns of `last` about the middle axis to where its angle from `first` is that of `goal`.
///
/// The three directions are a triangle on the sphere with the sides α, γ and β. Its half-angle formulas give the angle
/// at the middle axis to rounding, even if it is small. Its cosine would lose half of the digits near a singular wrist.
template <class T, class V>
roots<V, 2> middle_turns(const joint_axis<T>& middle, const T first[3], const T last[3], const V goal[3], V slack) {
    roots<V, 2> found;
    const V zero = V(0), beta = angle_between(first, goal);
    const T alpha = angle_between(middle.w, first), gamma = angle_between(middle.w, last);
    const V s = T(0.5) * (alpha + beta + gamma), angles[4] = {s - alpha, s - gamma, s, s - beta};
    V sines[4], cosine;
    for (int i = 0; i < 4; ++i) sincos(angles[i], sines[i], cosine);
    const V sine_squared = sines[0] * sines[1], cosine_squared = sines[2] * sines[3];
    const joint_value<V> half = rotated(sqrt(greatest(cosine_squared, zero)), sqrt(greatest(sine_squared, zero)));
    const feature<T> from{true, {last[0], last[1], last[2]}, T(0)}, to{true, {first[0], first[1], first[2]}, T(0)};
    joint_value<T> aligned = settle(middle, from, to, joint_value<T>{T(1), T(0), T(0)});
    aligned.free = false;
    const auto there = least(sine_squared, cosine_squared) >= -slack;
    found.add(aligned + half + half, there);
    found.add(aligned + back(half) + back(half), there & (sine_squared > zero) & (cosine_squared > zero));
    return found;
}

/// Axes that meet. Of three, the angle from w₁ to R w₃ gives x₂; x₁ turns e^{ŵ₂x₂} w₃ to R w₃; x₃ is the remaining
/// turn. If x₂ brings w₃ along w₁, the wrist is singular and x₁ is free.
template <class T, class V>
void rotating(const group<T>& wrist, const frame<V>& E, const joint_value<T>* near, V slack, placements<V>& found) {
    const joint_axis<T>* axes = wrist.axes;
    const auto always = in_every_lane<V>(true);
    V there[3];
    if (wrist.count == 1) {
        T u[3], v[3];
        across(axes[0].w, u, v);
        rotate(E, u, there);
        found.add({{turn_between(axes[0].w, u, there), {}, {}}}, always);
    } else if (wrist.count == 0) {
        found.add({}, always);
    } else if (wrist.count == 2) {
        const V middle[3] = {V(axes[1].w[0]), V(axes[1].w[1]), V(axes[1].w[2])};
        first_and_last(wrist, E, middle, static_cast<const joint_value<V>*>(nullptr), near[0], always, found);
    } else {
        rotate(E, axes[2].w, there);
        const roots<V, 2> turns = middle_turns(axes[1], axes[0].w, axes[2].w, there, slack);
        for (int r = 0; r < turns.count; ++r) {
            V middle[3] = {V(axes[2].w[0]), V(axes[2].w[1]), V(axes[2].w[2])};
            move_direction(axes[1], turns.items[r], middle);
            first_and_last(wrist, E, middle, &turns.items[r], near[0], turns.there[r], found);
        }
    }
}

/// Lengths along `count` directions whose sum comes nearest to `wanted`, by Gram–Schmidt. A direction that depends on
/// the earlier ones gets 0.
template <class V> void lengths_along(V (*directions)[3], int count, const V wanted[3], V* lengths) {
    using T = scalar_of<V>;
    V q[3][3], r[3][3], left[3] = {wanted[0], wanted[1], wanted[2]}, share[3];
    for (int i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) q[i][k] = directions[i][k];
        for (int j = 0; j < i; ++j) {
            r[j][i] = dot(q[j], q[i]);
            for (int k = 0; k < 3; ++k) q[i][k] = q[i][k] - r[j][i] * q[j][k];
        }
        r[i][i] = sqrt(dot(q[i], q[i]));
        const auto other = r[i][i] > V(nothing<T>);
        r[i][i] = select(other, r[i][i], V(1));
        for (int k = 0; k < 3; ++k) q[i][k] = select(other, q[i][k] / r[i][i], V(0));
        share[i] = dot(q[i], left);
        for (int k = 0; k < 3; ++k) left[k] = left[k] - share[i] * q[i][k];
    }
    for (int i = count - 1; i >= 0; --i) {
        lengths[i] = share[i];
        for (int j = i + 1; j < count; ++j) lengths[i] = lengths[i] - r[i][j] * lengths[j];
        lengths[i] = lengths[i] / r[i][i];
    }
}

/// Sets the slides, which are at 0. They are linear in the image of the origin under E, so least squares gives them.
template <class T, class V> void set_slides(const joint_axis<T>* axes, int count, const frame<V>& E, joint_value<V>* x) {
    V directions[3][3], there[3] = {V(0), V(0), V(0)}, lengths[3];
    int slides[3], found = 0;
    for (int i = count - 1; i >= 0; --i) {
        move_point(axes[i], x[i], there);
        for (int s = 0; s < found; ++s) move_direction(axes[i], x[i], directions[s]);
        if (!axes[i].slides || found == 3) continue;
        for (int k = 0; k < 3; ++k) directions[found][k] = V(axes[i].w[k]);
        slides[found++] = i;
    }
    const V wanted[3] = {E.p[0] - there[0], E.p[1] - there[1], E.p[2] - there[2]};
    lengths_along(directions, found, wanted, lengths);
    for (int s = 0; s < found; ++s) x[slides[s]] = slid(lengths[s]);
}

/// Joints that turn about the normal and slide across it: their angles add up. A single turn has the whole angle, and
/// the slides are two lengths in the plane. With more turns, the joints before the last turn take a point of its axis
/// to where E takes it.
template <class T, class V>
void sliding(const group<T>& plane, const frame<V>& E, const joint_value<T>* near, V slack, placements<V>& found) {
    const T* const normal = plane.kept.v;
    T u[3], v[3];
    V there[3];
    int last = -1, turning = 0;
    for (int i = 0; i < plane.count; ++i)
        if (!plane.axes[i].slides) {
            last = i;
            ++turning;
        }
    if (last < 0) return;
    const auto sensed = [&](int i, joint_value<V> x) {
        if (dot(plane.axes[i].w, normal) < T(0)) x.sine = -x.sine;
        return x;
    };
    across(normal, u, v);
    rotate(E, u, there);
    const joint_value<V> whole = rotated(dot(u, there), dot(v, there));
    if (turning == 1) {
        placement<V> one{};
        for (int i = 0; i < plane.count; ++i) one.x[i] = i == last ? sensed(last, whole) : slid(V(0));
        set_slides(plane.axes, plane.count, E, one.x);
        found.add(one, in_every_lane<V>(true));
        return;
    }
    if (last < plane.count - 1) {  // the same group seen from the other end
        const int end = plane.count - 1;
        joint_axis<T> axes[3];
        joint_value<T> wanted[3];
        for (int i = 0; i <= end; ++i) {
            axes[i] = plane.axes[end - i];
            wanted[i] = back(near[end - i]);
        }
        placements<V> backward;
        sliding(group<T>{axes, plane.count, plane.kept}, inverse(E), wanted, slack, backward);
        for (int r = 0; r < backward.count; ++r) {
            placement<V> forward{};
            for (int i = 0; i <= end; ++i) forward.x[i] = back(backward.items[r].x[end - i]);
            found.add(forward, backward.there[r]);
        }
        return;
    }
    const feature<T> X = point_at(plane.axes[last].o);
    found = place(plane.axes, last, X, moved(E, X), near, slack);
    for (int r = 0; r < found.count; ++r) {
        placement<V>& item = found.items[r];
        joint_value<V> left = whole;
        for (int i = 0; i < last; ++i)
            if (!plane.axes[i].slides) left = left + back(sensed(i, item.x[i]));
        item.x[last] = sensed(last, left);
    }
}
}  // namespace detail

/// All x with E₁(x₁) ⋯ Eₖ(xₖ) = E, for a group that leaves what it keeps alone.
template <class T, class V>
placements<V> within(const group<T>& joints, const frame<V>& E, const joint_value<T>* near, V slack) {
    placements<V> found;
    if (joints.kept.plane) detail::sliding(joints, E, near, slack, found);
    else detail::rotating(joints, E, near, slack, found);
    return found;
}

}  // namespace closed_form

TWISTARM_END
