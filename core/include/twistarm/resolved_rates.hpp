// Joint rates for a twist (resolved motion rate control), damped where the arm is nearly singular.
//
// D. E. Whitney, Resolved motion rate control of manipulators and human prostheses, IEEE T-MMS 10(2), 1969. Everything
// here is scaled to radians: metres are measured in a length, and a slide's rates too. The readable twin is
// src/twistarm/servo/resolved_rates.py.
#pragma once

#include "kinematics.hpp"
#include "motion_limits.hpp"
#include "singular_directions.hpp"

TWISTARM_BEGIN

/// What a servo needs to know of an arm beside its chain.
///
/// unit: what a coordinate's scaled number is multiplied by, 1 or `length` for a slide. ready: where a singular arm looks
/// for the way out. length [m]: what compares metres with radians. below: singular values less than this are damped.
template <class T, int N> struct servo_bounds {
    motion_limits<T, N> motion;
    T unit[capacity(N)], ready[capacity(N)];
    T length, below;
};

/// Tool rates by levels: which components of the twist, in tool or in base axes, go before which others.
struct servo_levels {
    int count, size[3], component[3][6];
};

/// Joint rates; how much damping bends the twist, and takes of it; the joint that moves most for that, −1 for none.
template <class T, int N> struct resolved {
    T rates[capacity(N)];
    T bent, taken;
    int joint;
};

namespace servo_detail {
template <class T> constexpr T no_motion = T(1e-3);      // singular values below this count as none
template <class T> constexpr T rise_whole = T(0.1);      // dσ per scaled rad: from here on a motion leaves a singularity
template <class T> constexpr T rise_least = T(0.02);     // … and from here on it does so in part
template <class T> constexpr T beside = T(0.05);         // how far beside a posture one looks for lacking directions
template <class T> constexpr T slight = T(0.3);          // cosines below this are damped
constexpr int five = 5;                                  // joints from which on singularities are the whole twist's
template <class T> constexpr T tilt = T(0.1);            // leads that way off any singularity
template <class T> constexpr T nothing = T(sizeof(T) == 8 ? 1e-12 : 1e-6);  // slower scaled rates are rounding
template <class T> constexpr T difference = T(sizeof(T) == 8 ? 1e-4 : 4e-3);

template <class T> T norm(const T* values, int count) {
    T sum = T(0);
    for (int k = 0; k < count; ++k) sum += values[k] * values[k];
    return sqrt(sum);
}

template <class T> T dot6(const T* a, const T* b) {
    T sum = T(0);
    for (int i = 0; i < 6; ++i) sum += a[i] * b[i];
    return sum;
}

/// A singular direction of some rows: joints v move the tool by σ u; aside: found beside the posture, σ here is 0.
template <class T, int N> struct direction {
    T u[6], v[capacity(N)], sigma;
    bool aside;
};

template <class T, int N, int M> struct rate_solver {
    const chain<T, N, M>& arm;
    const servo_bounds<T, N>& bounds;
    const servo_levels& levels;
    bool base_axes;
    T dt;
    T ahead[capacity(N)], toward[capacity(N)];
    six_rows<T, N> J, J_beside;
    bool has_beside, has_whole;  // whether `found` is of all joints
    direction<T, N> found[12];
    int count;

    int n() const { return arm.coordinates(); }

    rate_solver(const chain<T, N, M>& arm_, const servo_bounds<T, N>& bounds_, const servo_levels& levels_, bool base,
                const T* posture, T step)
        : arm(arm_), bounds(bounds_), levels(levels_), base_axes(base), dt(step), has_beside(false), has_whole(false), count(0) {
        T length = T(0);
        for (int k = 0; k < n(); ++k) {
            ahead[k] = posture[k];
            toward[k] = (bounds.ready[k] - posture[k]) / bounds.unit[k] + (k % 2 == 0 ? tilt<T> : -tilt<T>);
            length += toward[k] * toward[k];
        }
        length = greatest(sqrt(length), nothing<T>);
        for (int k = 0; k < n(); ++k) toward[k] = toward[k] / length;
        jacobian(nullptr, T(0), J);
    }

    /// The scaled rows at the posture displaced by size · way.
    void jacobian(const T* way, T size, six_rows<T, N>& rows) const {
        T theta[capacity(N)];
        for (int k = 0; k < n(); ++k) theta[k] = ahead[k] + (way == nullptr ? T(0) : bounds.unit[k] * size * way[k]);
        column<T> columns[capacity(N)];
        const frame<T> g = forward_with_body_jacobian(arm, theta, columns);
        for (int k = 0; k < n(); ++k) {
            if (base_axes) {
                rotate(g, columns[k].v, columns[k].v);
                rotate(g, columns[k].w, columns[k].w);
            }
            for (int i = 0; i < 3; ++i) {
                rows[i][k] = columns[k].v[i] * (bounds.unit[k] / bounds.length);
                rows[i + 3][k] = columns[k].w[i] * bounds.unit[k];
            }
        }
    }

    T times(const six_rows<T, N>& rows, int row, const T* rates) const {
        T sum = T(0);
        for (int k = 0; k < n(); ++k) sum += rows[row][k] * rates[k];
        return sum;
    }

    /// Adds the directions of some rows of `all`, without the fixed joints and those found from `first` to `last`.
    void decompose(const six_rows<T, N>& all, const int* component, int size, const bool* free, int last, bool aside) {
        six_rows<T, N> rows;
        T X[6][6];
        for (int i = 0; i < size; ++i) {
            for (int k = 0; k < n(); ++k) rows[i][k] = free[k] ? all[component[i]][k] : T(0);
            for (int d = 0; d < last; ++d) {
                const T along = times(rows, i, found[d].v);
                for (int k = 0; k < n(); ++k) rows[i][k] -= along * found[d].v[k];
            }
        }
        make_orthogonal<T, N>(rows, size, n(), X);
        for (int i = 0; i < size && count < 12; ++i) {
            T sigma = T(0);
            for (int k = 0; k < n(); ++k) sigma += rows[i][k] * rows[i][k];
            sigma = sqrt(sigma);
            if (!(sigma > no_motion<T>)) continue;
            direction<T, N>& next = found[count++];
            for (int j = 0; j < 6; ++j) next.u[j] = T(0);
            for (int j = 0; j < size; ++j) next.u[component[j]] = X[j][i];
            for (int k = 0; k < n(); ++k) next.v[k] = rows[i][k] / sigma;
            next.sigma = sigma;
            next.aside = aside;
        }
    }

    /// The directions of a level; those that this very posture lacks are read off one a little beside.
    void find(const int* component, int size, const bool* free, int movable) {
        const int first = count;
        decompose(J, component, size, free, first, false);
        if (count - first >= (size < movable - first ? size : movable - first)) return;
        if (!has_beside) jacobian(toward, beside<T>, J_beside);
        has_beside = true;
        six_rows<T, N> rest;
        for (int i = 0; i < 6; ++i)
            for (int k = 0; k < n(); ++k) rest[i][k] = J_beside[i][k];
        for (int d = first; d < count; ++d)
            for (int k = 0; k < n(); ++k) {
                T along = T(0);
                for (int i = 0; i < 6; ++i) along += found[d].u[i] * rest[i][k];
                for (int i = 0; i < 6; ++i) rest[i][k] -= found[d].u[i] * along;
            }
        decompose(rest, component, size, free, count, true);
    }

    /// dσ per scaled radian along v: uᵀ (∂J/∂v) v, less what the levels before make up of their share of (∂J/∂v) v.
    T rise(const direction<T, N>& along, int before) const {
        six_rows<T, N> there;
        jacobian(along.v, difference<T>, there);
        T bend[6], risen = T(0);
        for (int i = 0; i < 6; ++i) {
            bend[i] = (times(there, i, along.v) - times(J, i, along.v)) / difference<T>;
            risen += along.u[i] * bend[i];
        }
        for (int d = 0; d < before; ++d) {
            T moved = T(0), theirs = T(0);
            for (int i = 0; i < 6; ++i) {
                moved += along.u[i] * times(J, i, found[d].v);
                theirs += found[d].u[i] * bend[i];
            }
            risen -= moved * theirs / greatest(found[d].sigma, bounds.below);
        }
        return risen;
    }

    /// What a share of the twist is multiplied by to get rates along v, and how much of it is then done, 0 … 1.
    ///
    /// 1/σ from ε = `below` on. Under it, where the motion approaches the singularity, 4s / (ε² + 3s²): damped least
    /// squares with λ² = (ε² − s²)/4 (A. A. Maciejewski & C. A. Klein, J. Robotic Systems 5(6), 1988); s runs from 0 to ε
    /// while σ does from no_motion. Where the motion leaves it, 1/ε. It must be able to stop halfway to the singularity.
    T gain(const direction<T, N>& along, T share, int before, T& done) const {
        const T below = bounds.below;
        done = T(1);
        if (along.sigma >= below && !along.aside) return T(1) / along.sigma;
        const T rises = rise(along, before) * (share > T(0) ? T(1) : share < T(0) ? T(-1) : T(0));
        const T leaving = clamped((rises - rise_least<T>) / (rise_whole<T> - rise_least<T>), T(0), T(1));
        const T s = along.aside ? T(0) : below * (along.sigma - no_motion<T>) / (below - no_motion<T>);
        T damped = T(4) * s / (below * below + T(3) * s * s);
        if (rises < T(0)) {
            T rates[capacity(N)];
            for (int k = 0; k < n(); ++k) rates[k] = along.v[k] * bounds.unit[k];
            const T way = T(0.5) * s / -rises, stop = stopping_time(bounds.motion, rates);
            damped = least(damped, T(2) * way / (dt + sqrt(dt * dt + T(2) * stop * way)) / absolute(share));
        }
        done = s * damped + leaving * (T(1) - s * damped);
        return damped + leaving * (T(1) / below - damped);
    }

    /// Adds the rates for a share along a direction, of `total` = |asked|² in all; `before` directions go before it.
    void add(const direction<T, N>& along, T share, int before, T total, resolved<T, N>& out, T& gravest) const {
        T done;
        const T amount = gain(along, share, before, done) * share, part = share * share / greatest(total, T(1e-30));
        for (int k = 0; k < n(); ++k) out.rates[k] += amount * along.v[k];
        out.bent += T(4) * done * (T(1) - done) * part;
        out.taken += (T(1) - done) * part;
        if (!((T(1) - done) * part > gravest)) return;
        gravest = (T(1) - done) * part;
        out.joint = 0;
        for (int k = 1; k < n(); ++k)
            if (absolute(along.v[k]) > absolute(along.v[out.joint])) out.joint = k;
    }

    /// What the rates leave of what is asked, and its square.
    T rest(const T* asked, const T* rates, T* left) const {
        T square = T(0);
        for (int i = 0; i < 6; ++i) {
            left[i] = asked[i] - times(J, i, rates);
            square += left[i] * left[i];
        }
        return square;
    }

    /// The shares of the directions found that meet each level after those before, damped where that takes too much.
    void prior_shares(const T* left, T* shares) const {
        six_rows<T, 6> used;
        int taken = 0;
        for (int d = 0; d < count; ++d) shares[d] = T(0);
        for (int level = 0; level < levels.count; ++level) {
            const int size = levels.size[level], before = taken;
            six_rows<T, 6> rows;
            T X[6][6], open[6];
            for (int i = 0; i < size; ++i) {
                const int component = levels.component[level][i];
                open[i] = left[component];
                for (int d = 0; d < count; ++d) {
                    rows[i][d] = found[d].u[component];
                    open[i] -= rows[i][d] * shares[d];
                }
                for (int q = 0; q < before; ++q) {
                    T along = T(0);
                    for (int d = 0; d < count; ++d) along += rows[i][d] * used[q][d];
                    for (int d = 0; d < count; ++d) rows[i][d] -= along * used[q][d];
                }
            }
            make_orthogonal<T, 6>(rows, size, count, X);
            for (int i = 0; i < size && taken < 6; ++i) {
                const T c = norm(rows[i], count);
                if (!(c > no_motion<T>)) continue;
                T part = T(0);
                for (int j = 0; j < size; ++j) part += X[j][i] * open[j];
                for (int d = 0; d < count; ++d) {
                    used[taken][d] = rows[i][d] / c;
                    shares[d] += inverse_cosine(c) * part * used[taken][d];
                }
                ++taken;
            }
        }
    }

    /// 1/c; below `slight` 4d / (slight² + 3d²), with d from 0 to `slight` while c goes there from no_motion.
    static T inverse_cosine(T c) {
        if (c >= slight<T>) return T(1) / c;
        const T d = slight<T> * (c - no_motion<T>) / (slight<T> - no_motion<T>);
        return T(4) * d / (slight<T> * slight<T> + T(3) * d * d);
    }

    /// The joint rates for `asked`; joints that are not free keep theirs.
    ///
    /// Where an arm moves its tool in fewer than six directions, the twist is that which meets the levels as well as can
    /// be, one after the other. An arm of fewer than five joints solves the levels themselves one after the other: there
    /// the position alone can be singular. Y. Nakamura, H. Hanafusa & T. Yoshikawa, IJRR 6(2), 1987.
    void operator()(const T* asked, const bool* free, const T* fixed, resolved<T, N>& out) {
        static constexpr int all[6] = {0, 1, 2, 3, 4, 5};
        int movable = 0;
        for (int k = 0; k < n(); ++k) {
            movable += free[k] ? 1 : 0;
            out.rates[k] = free[k] ? T(0) : fixed[k];
        }
        out.bent = out.taken = T(0);
        out.joint = -1;
        T gravest = T(0), left[6], shares[6];
        if (n() >= five) {
            // They hang on the posture and on what is free alone; a goal is asked for with the same twice.
            if (!has_whole || movable < n()) {
                count = 0;
                find(all, 6, free, movable);
                has_whole = movable == n();
            }
            rest(asked, out.rates, left);
            if (count == 6) {
                for (int d = 0; d < 6; ++d) shares[d] = dot6(found[d].u, left);
            } else {
                prior_shares(left, shares);
            }
            const T total = dot6(asked, asked);
            for (int d = 0; d < count; ++d) add(found[d], shares[d], 0, total, out, gravest);
            return;
        }
        count = 0;
        for (int level = 0; level < levels.count; ++level) {
            const int first = count;
            find(levels.component[level], levels.size[level], free, movable);
            // A lower level also has to make up for what the upper ones do to it, which may be more than is asked.
            const T total = greatest(dot6(asked, asked), rest(asked, out.rates, left));
            for (int d = first; d < count; ++d) add(found[d], dot6(found[d].u, left), first, total, out, gravest);
        }
    }
};
}  // namespace servo_detail

TWISTARM_END
