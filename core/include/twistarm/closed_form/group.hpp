// A group of joints that leaves a point or a plane alone: all x with E₁(x₁) ⋯ Eₖ(xₖ) = E, k ≤ 3.
#pragma once

#include "placing.hpp"

TWISTARM_BEGIN

namespace closed_form {

/// Joints that follow one another, and what they leave alone: the point in which axes meet, or a plane across axes that are
/// parallel, and along those that slide.
template <class T> struct group {
    const joint_axis<T>* axes;
    int count;
    feature<T> kept;
};

namespace detail {
/// The turn about w that takes u, across it, to `there`.
template <class T> joint_value<T> turn_between(const T w[3], const T u[3], const T there[3]) {
    T v[3];
    cross(w, u, v);
    return turned(dot(u, there), dot(v, there));
}

/// x₁ turns `middle`, where the joint in the middle has brought the last axis, to where E takes it; the last turns what is
/// left. `between`: the value of the joint in the middle, or null.
template <class T>
void first_and_last(const group<T>& wrist, const frame<T>& E, const T middle[3], const joint_value<T>* between,
                    const joint_value<T>& near, placings<T>& found) {
    const joint_axis<T>&first = wrist.axes[0], &last = wrist.axes[wrist.count - 1];
    T there[3], u[3], v[3];
    rotate(E, last.w, there);
    const feature<T> from{true, {middle[0], middle[1], middle[2]}, T(0)}, to{true, {there[0], there[1], there[2]}, T(0)};
    const joint_value<T> x = settle(first, from, to, near);
    across(last.w, u, v);
    rotate(E, u, there);
    move_direction(first, back(x), there);
    if (between != nullptr) move_direction(wrist.axes[1], back(*between), there);
    const joint_value<T> rest = turn_between(last.w, u, there);
    found.add(between == nullptr ? placed<T>{{x, rest, {}}} : placed<T>{{x, *between, rest}});
}

/// Axes that meet: of three, w₁ · R w₃ = w₁ · e^{ŵ₂x₂} w₃ gives x₂; then x₁ turns e^{ŵ₂x₂} w₃ to R w₃, and x₃ is the turn
/// that is left. Where x₂ brings w₃ along w₁ the wrist is singular: x₁ is free.
template <class T>
void rotating(const group<T>& wrist, const frame<T>& E, const joint_value<T>* near, T slack, placings<T>& found) {
    const joint_axis<T>* axes = wrist.axes;
    T u[3], there[3];
    if (wrist.count == 1) {
        T v[3];
        across(axes[0].w, u, v);
        rotate(E, u, there);
        found.add({{turn_between(axes[0].w, u, there), {}, {}}});
    } else if (wrist.count == 2) {
        first_and_last(wrist, E, axes[1].w, static_cast<const joint_value<T>*>(nullptr), near[0], found);
    } else {
        const parted<T> parts(axes[1].w, axes[2].w);
        rotate(E, axes[2].w, there);
        const T wanted = dot(axes[0].w, there) - dot(axes[0].w, parts.along);
        for (const joint_value<T>& x :
             harmonic(dot(axes[0].w, parts.across), dot(axes[0].w, parts.turned), wanted, T(1), slack)) {
            T middle[3] = {axes[2].w[0], axes[2].w[1], axes[2].w[2]};
            move_direction(axes[1], x, middle);
            first_and_last(wrist, E, middle, &x, near[0], found);
        }
    }
}

/// The one turn, and slides by least squares.
template <class T>
placed<T> one_turn(const group<T>& plane, int turning, const joint_value<T>& angle, const frame<T>& E) {
    placed<T> found{};
    found.x[turning] = angle;
    T left[3], directions[2][3];
    int slides[2], count = 0;
    for (int k = 0; k < 3; ++k) left[k] = plane.axes[turning].o[k];
    move_direction(plane.axes[turning], angle, left);
    for (int k = 0; k < 3; ++k) left[k] += E.p[k] - plane.axes[turning].o[k];
    for (int i = 0; i < plane.count; ++i) {
        if (i == turning || count == 2) continue;
        for (int k = 0; k < 3; ++k) directions[count][k] = plane.axes[i].w[k];
        if (i > turning) move_direction(plane.axes[turning], angle, directions[count]);
        slides[count++] = i;
    }
    if (count == 1) found.x[slides[0]] = slid(dot(directions[0], left));
    if (count == 2) {
        const T between = dot(directions[0], directions[1]), rest = T(1) - between * between;
        const T a = dot(directions[0], left), b = dot(directions[1], left);
        found.x[slides[0]] = slid(rest > T(0) ? (a - between * b) / rest : a);
        found.x[slides[1]] = slid(rest > T(0) ? (b - between * a) / rest : T(0));
    }
    return found;
}

/// Joints that turn about the normal and slide across it: the angles add up. With one turn it is the whole angle, and the
/// slides are two lengths in the plane; else the joints before the last turn take a point of its axis where E takes it.
template <class T>
void sliding(const group<T>& plane, const frame<T>& E, const joint_value<T>* near, T slack, placings<T>& found) {
    const T* const normal = plane.kept.v;
    T u[3], v[3], there[3];
    int last = -1, turning = 0;
    for (int i = 0; i < plane.count; ++i)
        if (!plane.axes[i].slides) {
            last = i;
            ++turning;
        }
    if (last < 0) return;
    const auto sensed = [&](int i, joint_value<T> x) {
        if (dot(plane.axes[i].w, normal) < T(0)) x.sine = -x.sine;
        return x;
    };
    across(normal, u, v);
    rotate(E, u, there);
    const joint_value<T> whole = turned(dot(u, there), dot(v, there));
    if (turning == 1) {
        found.add(one_turn(plane, last, sensed(last, whole), E));
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
        placings<T> backward;
        sliding(group<T>{axes, plane.count, plane.kept}, inverse(E), wanted, slack, backward);
        for (const placed<T>& each : backward) {
            placed<T> forward{};
            for (int i = 0; i <= end; ++i) forward.x[i] = back(each.x[end - i]);
            found.add(forward);
        }
        return;
    }
    const feature<T> X = point_at(plane.axes[last].o);
    for (placed<T> each : place(plane.axes, last, X, moved(E, X), near, slack)) {
        joint_value<T> left = whole;
        for (int i = 0; i < last; ++i)
            if (!plane.axes[i].slides) left = left + back(sensed(i, each.x[i]));
        each.x[last] = sensed(last, left);
        found.add(each);
    }
}
}  // namespace detail

/// All x with E₁(x₁) ⋯ Eₖ(xₖ) = E, for a group that leaves what it keeps alone.
template <class T>
placings<T> within(const group<T>& joints, const frame<T>& E, const joint_value<T>* near, T slack) {
    placings<T> found;
    if (joints.kept.plane) detail::sliding(joints, E, near, slack, found);
    else detail::rotating(joints, E, near, slack, found);
    return found;
}

}  // namespace closed_form

TWISTARM_END
