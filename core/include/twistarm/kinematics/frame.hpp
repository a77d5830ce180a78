// Rigid motions as four columns: a frame's axes x, y, z and its origin p, in another frame.
#pragma once

#include "../numeric/lanes.hpp"

TWISTARM_BEGIN

/// A pose g = [x y z p; 0 0 0 1], its rotation by columns; p [m].
template <class V> struct frame {
    V x[3], y[3], z[3], p[3];
};

template <class A, class B> TWISTARM_INLINE wider<A, B> dot(const A a[3], const B b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// c = a × b.
template <class A, class B> TWISTARM_INLINE void cross(const A a[3], const B b[3], wider<A, B> c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/// out = R v, R the rotation of g.
template <class V, class A> TWISTARM_INLINE void rotate(const frame<V>& g, const A v[3], V out[3]) {
    V rotated[3];
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) rotated[k] = g.x[k] * v[0] + g.y[k] * v[1] + g.z[k] * v[2];
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) out[k] = rotated[k];
}

/// out = Rᵀ v.
template <class V> TWISTARM_INLINE void rotate_back(const frame<V>& g, const V v[3], V out[3]) {
    const V rotated[3] = {dot(g.x, v), dot(g.y, v), dot(g.z, v)};
    for (int k = 0; k < 3; ++k) out[k] = rotated[k];
}

/// a b.
template <class V> TWISTARM_INLINE frame<V> product(const frame<V>& a, const frame<V>& b) {
    frame<V> c;
    rotate(a, b.x, c.x);
    rotate(a, b.y, c.y);
    rotate(a, b.z, c.z);
    rotate(a, b.p, c.p);
    TWISTARM_UNROLL
    for (int k = 0; k < 3; ++k) c.p[k] = c.p[k] + a.p[k];
    return c;
}

/// g⁻¹ = (Rᵀ, −Rᵀ p).
template <class V> TWISTARM_INLINE frame<V> inverse(const frame<V>& g) {
    frame<V> c;
    const V* columns[3] = {g.x, g.y, g.z};
    for (int k = 0; k < 3; ++k) {
        c.x[k] = columns[k][0];
        c.y[k] = columns[k][1];
        c.z[k] = columns[k][2];
    }
    rotate_back(g, g.p, c.p);
    for (int k = 0; k < 3; ++k) c.p[k] = -c.p[k];
    return c;
}

/// The identity.
template <class V> TWISTARM_INLINE frame<V> identity_frame() {
    frame<V> g;
    for (int k = 0; k < 3; ++k) {
        g.x[k] = V(k == 0 ? 1 : 0);
        g.y[k] = V(k == 1 ? 1 : 0);
        g.z[k] = V(k == 2 ? 1 : 0);
        g.p[k] = V(0);
    }
    return g;
}

/// The frame of a 4×4 (or the upper 3×4 of one), row-major, and back, bottom row included.
template <class T, class S> TWISTARM_INLINE frame<T> frame_from_rows(const S* rows) {
    frame<T> g;
    for (int k = 0; k < 3; ++k) {
        g.x[k] = static_cast<T>(rows[4 * k]);
        g.y[k] = static_cast<T>(rows[4 * k + 1]);
        g.z[k] = static_cast<T>(rows[4 * k + 2]);
        g.p[k] = static_cast<T>(rows[4 * k + 3]);
    }
    return g;
}
template <class T, class S> TWISTARM_INLINE void frame_to_rows(const frame<T>& g, S* rows) {
    for (int k = 0; k < 3; ++k) {
        rows[4 * k] = static_cast<S>(g.x[k]);
        rows[4 * k + 1] = static_cast<S>(g.y[k]);
        rows[4 * k + 2] = static_cast<S>(g.z[k]);
        rows[4 * k + 3] = static_cast<S>(g.p[k]);
        rows[12 + k] = S(0);
    }
    rows[15] = S(1);
}

/// A frame in other numbers: another precision, or the same in every lane.
template <class V, class T> TWISTARM_INLINE frame<V> converted(const frame<T>& g) {
    frame<V> c;
    for (int k = 0; k < 3; ++k) {
        c.x[k] = V(static_cast<scalar_of<V>>(g.x[k]));
        c.y[k] = V(static_cast<scalar_of<V>>(g.y[k]));
        c.z[k] = V(static_cast<scalar_of<V>>(g.z[k]));
        c.p[k] = V(static_cast<scalar_of<V>>(g.p[k]));
    }
    return c;
}

/// One lane of a frame of packs.
template <class V, class T> TWISTARM_INLINE void set_lane(frame<V>& g, int i, const frame<T>& value) {
    for (int k = 0; k < 3; ++k) {
        set_lane(g.x[k], i, value.x[k]);
        set_lane(g.y[k], i, value.y[k]);
        set_lane(g.z[k], i, value.z[k]);
        set_lane(g.p[k], i, value.p[k]);
    }
}

TWISTARM_END
