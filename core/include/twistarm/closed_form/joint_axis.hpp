// The axis of one joint, which turns about a line or slides along it, and what it moves: points, directions, planes.
#pragma once

#include "../kinematics/frame.hpp"
#include "../numeric/elementary.hpp"

TWISTARM_BEGIN

namespace closed_form {

/// A few things, at most `Most` of them.
template <class Item, int Most> struct few {
    Item items[Most];
    int count = 0;

    void add(const Item& item) {
        if (count < Most) items[count++] = item;
    }
    const Item* begin() const { return items; }
    const Item* end() const { return items + count; }
};

/// A line along the unit vector w through the point o [m]: the joint turns about it, or slides along it.
template <class T> struct joint_axis {
    T w[3], o[3];
    bool slides;
};

/// Where a joint stands: a turn by its cosine and sine, a slide by its length [m]; the other is that of 0. `free`: any other
/// value would do as well, with others for the rest.
template <class T> struct joint_value {
    T cosine, sine, length;
    bool free;

    joint_value() = default;
    constexpr joint_value(T c, T s, T l, bool any = false) : cosine(c), sine(s), length(l), free(any) {}
};

template <class T> joint_value<T> set_free(joint_value<T> value) {
    value.free = true;
    return value;
}

template <class T> joint_value<T> slid(T length) { return {T(1), T(0), length}; }

/// The turn of which cosine and sine are known but for a common factor; both 0 are the turn 0.
template <class T> TWISTARM_INLINE joint_value<T> turned(T cosine, T sine) {
    const T square = cosine * cosine + sine * sine;
    if (!(square > T(0))) return {T(1), T(0), T(0)};
    const T scale = T(1) / sqrt(square);
    return {cosine * scale, sine * scale, T(0)};
}

template <class T> joint_value<T> turned_by(T angle) {
    joint_value<T> value{T(1), T(0), T(0)};
    sincos(angle, value.sine, value.cosine);
    return value;
}

template <class T> joint_value<T> value_of(const joint_axis<T>& axis, T x) { return axis.slides ? slid(x) : turned_by(x); }

template <class T> joint_value<T> back(const joint_value<T>& value) { return {value.cosine, -value.sine, -value.length, value.free}; }

/// One turn after another.
template <class T> joint_value<T> operator+(const joint_value<T>& a, const joint_value<T>& b) {
    return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine, a.length + b.length};
}

/// A direction parted by a unit vector w: `along` w, `across` it, and w × `across`.
template <class T> struct parted {
    T along[3], across[3], turned[3];

    TWISTARM_INLINE parted(const T w[3], const T v[3]) {
        const T share = dot(w, v);
        for (int k = 0; k < 3; ++k) {
            along[k] = share * w[k];
            across[k] = v[k] - along[k];
        }
        cross(w, v, turned);
    }
};

/// v ← e^{ŵx} v: Rodrigues' formula. MLS §2.2.1, eq. 2.14.
template <class T> TWISTARM_INLINE void move_direction(const joint_axis<T>& axis, const joint_value<T>& x, T v[3]) {
    if (axis.slides) return;
    const parted<T> parts(axis.w, v);
    for (int k = 0; k < 3; ++k) v[k] = parts.along[k] + x.cosine * parts.across[k] + x.sine * parts.turned[k];
}

/// p ← E(x) p.
template <class T> TWISTARM_INLINE void move_point(const joint_axis<T>& axis, const joint_value<T>& x, T p[3]) {
    if (axis.slides) {
        for (int k = 0; k < 3; ++k) p[k] += x.length * axis.w[k];
        return;
    }
    for (int k = 0; k < 3; ++k) p[k] -= axis.o[k];
    move_direction(axis, x, p);
    for (int k = 0; k < 3; ++k) p[k] += axis.o[k];
}

/// g ← E(x) g.
template <class T> void move_frame(const joint_axis<T>& axis, const joint_value<T>& x, frame<T>& g) {
    if (!axis.slides) {
        move_direction(axis, x, g.x);
        move_direction(axis, x, g.y);
        cross(g.x, g.y, g.z);
    }
    move_point(axis, x, g.p);
}

/// E(x).
template <class T> frame<T> motion(const joint_axis<T>& axis, const joint_value<T>& x) {
    frame<T> g = identity_frame<T>();
    move_frame(axis, x, g);
    return g;
}

/// out = g p for a point.
template <class T> void move_by(const frame<T>& g, const T p[3], T out[3]) {
    rotate(g, p, out);
    for (int k = 0; k < 3; ++k) out[k] += g.p[k];
}

/// The axis moved by g: g E(x) g⁻¹ is its motion.
template <class T> joint_axis<T> seen(const joint_axis<T>& axis, const frame<T>& g) {
    joint_axis<T> moved{{}, {}, axis.slides};
    rotate(g, axis.w, moved.w);
    move_by(g, axis.o, moved.o);
    return moved;
}

/// What a group of joints leaves alone.
enum class keeps { nothing, point, plane };

/// A point v [m], or the plane of the points x with v · x = d, v a unit vector; turned round it is another plane.
template <class T> struct feature {
    bool plane;
    T v[3], d;
};

template <class T> feature<T> point_at(const T p[3]) { return {false, {p[0], p[1], p[2]}, T(0)}; }

/// g X: n' = R n, d' = d + n' · p for a plane.
template <class T> feature<T> moved(const frame<T>& g, const feature<T>& X) {
    feature<T> Y = X;
    rotate(g, X.v, Y.v);
    if (X.plane) Y.d = X.d + dot(Y.v, g.p);
    for (int k = 0; k < 3 && !X.plane; ++k) Y.v[k] += g.p[k];
    return Y;
}

/// E(x) X.
template <class T> feature<T> moved(const joint_axis<T>& axis, const joint_value<T>& x, const feature<T>& X) {
    feature<T> Y = X;
    if (!X.plane) {
        move_point(axis, x, Y.v);
    } else if (axis.slides) {
        Y.d += x.length * dot(axis.w, X.v);
    } else {
        move_direction(axis, x, Y.v);
        Y.d += dot(Y.v, axis.o) - dot(X.v, axis.o);
    }
    return Y;
}

/// Unit vectors u and v = w × u that span the plane across the unit vector w.
template <class T> void across(const T w[3], T u[3], T v[3]) {
    int smallest = 0;
    for (int k = 1; k < 3; ++k)
        if (absolute(w[k]) < absolute(w[smallest])) smallest = k;
    const T e[3] = {T(smallest == 0 ? 1 : 0), T(smallest == 1 ? 1 : 0), T(smallest == 2 ? 1 : 0)};
    cross(w, e, u);
    const T size = sqrt(dot(u, u));
    for (int k = 0; k < 3; ++k) u[k] /= size;
    cross(w, u, v);
}

}  // namespace closed_form

TWISTARM_END
