// The axis of one joint, and its action on points, directions and planes. The joint turns about the axis or slides
// along it.
#pragma once

#include "../kinematics/frame.hpp"
#include "../numeric/elementary.hpp"

TWISTARM_BEGIN

namespace closed_form {

using twistarm::lane;
using twistarm::select;

/// A few things, at most `Most` of them; of packs each is `there` in some lanes.
template <class Item, int Most, class Mask = bool> struct few {
    Item items[Most];
    Mask there[Most];
    int count = 0;

    void add(const Item& item, const Mask& where) {
        if (count == Most || !any(where)) return;
        there[count] = where;
        items[count++] = item;
    }
    void add(const Item& item) { add(item, true); }
    const Item* begin() const { return items; }
    const Item* end() const { return items + count; }
};

/// A line along the unit vector w through the point o [m], which the joint turns about or slides along.
template <class T> struct joint_axis {
    T w[3], o[3];
    bool slides;
};

/// A joint's value: a turn as cosine and sine, a slide as length [m]; the other part is that of 0. `free`: any other
/// value also works, with other values of the rest. For packs: one joint in several configurations.
template <class V> struct joint_value {
    V cosine, sine, length;
    mask_of<V> free;

    joint_value() = default;
    TWISTARM_INLINE joint_value(V c, V s, V l) : joint_value(c, s, l, in_every_lane<V>(false)) {}
    TWISTARM_INLINE joint_value(V c, V s, V l, mask_of<V> any) : cosine(c), sine(s), length(l), free(any) {}
    /// The same in every lane.
    template <class T>
    TWISTARM_INLINE explicit joint_value(const joint_value<T>& one)
        : joint_value(V(one.cosine), V(one.sine), V(one.length), in_every_lane<V>(one.free)) {}
};

template <class V> joint_value<V> set_free(joint_value<V> value) {
    value.free = in_every_lane<V>(true);
    return value;
}

template <class V> TWISTARM_INLINE joint_value<V> slid(V length) { return {V(1), V(0), length}; }

/// The turn with this cosine and sine, up to a common factor. Both 0 give the turn 0.
template <class V> TWISTARM_INLINE joint_value<V> rotated(V cosine, V sine) {
    const V zero = V(0), one = V(1), square = cosine * cosine + sine * sine;
    const auto turns = square > zero;
    const V scale = one / sqrt(select(turns, square, one));
    return {select(turns, cosine * scale, one), select(turns, sine * scale, zero), zero};
}

template <class T> joint_value<T> rotated_by(T angle) {
    joint_value<T> value{T(1), T(0), T(0)};
    sincos(angle, value.sine, value.cosine);
    return value;
}

template <class T> joint_value<T> value_of(const joint_axis<T>& axis, T x) { return axis.slides ? slid(x) : rotated_by(x); }

/// x [rad or m], turns in [−π, π].
template <class T, class V> TWISTARM_INLINE V coordinate_of(const joint_axis<T>& axis, const joint_value<V>& value) {
    return axis.slides ? value.length : arctangent(value.sine, value.cosine);
}

template <class V> TWISTARM_INLINE joint_value<V> back(const joint_value<V>& value) {
    return {value.cosine, -value.sine, -value.length, value.free};
}

/// One turn after another.
template <class A, class B>
TWISTARM_INLINE joint_value<wider<A, B>> operator+(const joint_value<A>& a, const joint_value<B>& b) {
    return {a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine, a.length + b.length};
}

/// a where the mask holds, else b.
template <class T, int L, class V = pack<T, L>>
TWISTARM_INLINE joint_value<V> select(const mask<T, L>& m, const joint_value<V>& a, const joint_value<V>& b) {
    return {select(m, a.cosine, b.cosine), select(m, a.sine, b.sine), select(m, a.length, b.length), select(m, a.free, b.free)};
}

/// One lane, and a pack with one(l) in lane l.
template <class V> TWISTARM_INLINE joint_value<scalar_of<V>> lane(const joint_value<V>& x, int i) {
    return {lane(x.cosine, i), lane(x.sine, i), lane(x.length, i), (bits(x.free) >> i & 1U) != 0};
}
template <class V, class One> TWISTARM_INLINE joint_value<V> in_lanes(const One& one) {
    joint_value<V> x;
    unsigned free = 0;
    for (int l = 0; l < number<V>::lanes; ++l) {
        const joint_value<scalar_of<V>>& value = one(l);
        set_lane(x.cosine, l, value.cosine);
        set_lane(x.sine, l, value.sine);
        set_lane(x.length, l, value.length);
        free |= static_cast<unsigned>(value.free) << l;
    }
    x.free = lanes_of<V>(free);
    return x;
}

/// A direction parted by a unit vector w: `along` w, `across` it, and w × `across`.
template <class V> struct parted {
    V along[3], across[3], rotated[3];

    template <class T> TWISTARM_INLINE parted(const T w[3], const V v[3]) {
        const V share = dot(w, v);
        for (int k = 0; k < 3; ++k) {
            along[k] = share * w[k];
            across[k] = v[k] - along[k];
        }
        cross(w, v, rotated);
    }
};

/// v ← e^{ŵx} v: Rodrigues' formula. MLS §2.2.1, eq. 2.14.
template <class T, class V> TWISTARM_INLINE void move_direction(const joint_axis<T>& axis, const joint_value<V>& x, V v[3]) {
    if (axis.slides) return;
    const parted<V> parts(axis.w, v);
    for (int k = 0; k < 3; ++k) v[k] = parts.along[k] + x.cosine * parts.across[k] + x.sine * parts.rotated[k];
}

/// p ← E(x) p.
template <class T, class V> TWISTARM_INLINE void move_point(const joint_axis<T>& axis, const joint_value<V>& x, V p[3]) {
    if (axis.slides) {
        for (int k = 0; k < 3; ++k) p[k] = p[k] + x.length * axis.w[k];
        return;
    }
    for (int k = 0; k < 3; ++k) p[k] = p[k] - axis.o[k];
    move_direction(axis, x, p);
    for (int k = 0; k < 3; ++k) p[k] = p[k] + axis.o[k];
}

/// g ← E(x) g.
template <class T, class V> void move_frame(const joint_axis<T>& axis, const joint_value<V>& x, frame<V>& g) {
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

/// A point v [m], or the plane of all x with v · x = d and a unit vector v. (−v, −d) is a different plane.
template <class V> struct feature {
    bool plane;
    V v[3], d;
};

template <class T> feature<T> point_at(const T p[3]) { return {false, {p[0], p[1], p[2]}, T(0)}; }

/// g X: n' = R n, d' = d + n' · p for a plane.
template <class V, class T> feature<V> moved(const frame<V>& g, const feature<T>& X) {
    feature<V> Y{X.plane, {}, V(X.d)};
    rotate(g, X.v, Y.v);
    if (X.plane) Y.d = X.d + dot(Y.v, g.p);
    for (int k = 0; k < 3 && !X.plane; ++k) Y.v[k] = Y.v[k] + g.p[k];
    return Y;
}

/// E(x) X.
template <class T, class V, class A>
feature<V> moved(const joint_axis<T>& axis, const joint_value<V>& x, const feature<A>& X) {
    feature<V> Y{X.plane, {V(X.v[0]), V(X.v[1]), V(X.v[2])}, V(X.d)};
    if (!X.plane) {
        move_point(axis, x, Y.v);
    } else if (axis.slides) {
        Y.d = X.d + x.length * dot(axis.w, X.v);
    } else {
        move_direction(axis, x, Y.v);
        Y.d = X.d + (dot(Y.v, axis.o) - dot(X.v, axis.o));
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
