// The moving average of a law s(t) with a constant s̈ on each interval of a grid: s_w(t) = (1/w) ∫ s(τ) dτ over
// [t − w, t]. Its jerk is limited, and it takes w longer. How much of its limits a path uses with it.
//
// Derivatives of s_w are difference quotients: (s(t) − s(t − w)) / w, and so on.
#pragma once

#include "interval_limits.hpp"

TWISTARM_BEGIN

/// A law at rest before and after it: x = ṡ² at `count` + 1 points of a grid from s = 0 on, `count` ≥ 1.
template <class T> struct grid_law {
    int count;
    const T *grid, *x;
};

namespace detail {
/// Instants nearer than this part of the whole are one.
template <class T> constexpr T apart = T(sizeof(T) == 8 ? 1e-12 : 1e-6);

/// The end of a piece is looked at so little before it.
template <class T> constexpr T before_the_end = T(1) - T(sizeof(T) == 8 ? 1e-9 : 1e-5);

/// A law in time, with its integral, and the average over a window.
template <class T> class average {
public:
    average(const grid_law<T>& law, T window, T* scratch)
        : law_(law), window_(window), time_(scratch), speed_(time_ + law.count + 1), area_(speed_ + law.count + 1) {
        time_[0] = area_[0] = T(0);
        for (int i = 0; i <= law.count; ++i) speed_[i] = sqrt(law.x[i]);
        for (int i = 0; i < law.count; ++i) {
            const T h = law.grid[i + 1] - law.grid[i];
            time_[i + 1] = time_[i] + T(2) * h / (speed_[i] + speed_[i + 1]);
            area_[i + 1] = state_in(i, time_[i + 1]).area;
        }
    }

    T duration() const { return time_[law_.count] + window_; }

    /// The next knot after t: the end of an interval, or its echo one window later. Both indices advance to t.
    T next_knot(T t) {
        const T least = t + apart<T> * duration();
        while (now_ < law_.count && time_[now_ + 1] <= least) ++now_;
        while (before_ < law_.count && time_[before_ + 1] + window_ <= least) ++before_;
        const T own = now_ < law_.count ? time_[now_ + 1] : duration();
        const T echo = before_ < law_.count ? time_[before_ + 1] + window_ : duration();
        return own < echo ? own : echo;
    }

    /// s_w and its first three derivatives at t, between the knots of the last `next_knot`.
    void at(T t, T s[4]) const {
        const state late = state_in(now_, t), early = state_in(before_, t - window_);
        s[0] = (late.area - early.area) / window_;
        s[1] = (late.s - early.s) / window_;
        s[2] = (late.speed - early.speed) / window_;
        s[3] = (late.rate - early.rate) / window_;
    }

private:
    struct state {
        T area, s, speed, rate;
    };

    /// Interval −1 is before the law, interval `count` after it.
    state state_in(int i, T t) const {
        if (i < 0) return {T(0), T(0), T(0), T(0)};
        const T tau = t - time_[i], s = law_.grid[i];
        if (i == law_.count) return {area_[i] + s * tau, s, T(0), T(0)};
        const T h = law_.grid[i + 1] - law_.grid[i], half = T(0.25) * (law_.x[i + 1] - law_.x[i]) / h;
        return {area_[i] + (s + (speed_[i] / T(2) + half * tau / T(3)) * tau) * tau,
                s + (speed_[i] + half * tau) * tau, speed_[i] + T(2) * half * tau, T(2) * half};
    }

    const grid_law<T>& law_;
    T window_, *time_, *speed_, *area_;
    int now_ = -1, before_ = -1;
};

/// What a path uses of its limits of velocity, acceleration and jerk.
template <class T> class used_limits {
public:
    used_limits(const limited_path<T>& path, const T* jerk, const grid_law<T>& law, const second_order_rows<T>& more,
                T* shares, T* fastest)
        : path_(path), law_(law), more_(more), shares_(shares), fastest_(fastest) {
        for (int i = 0; i < 3 * path.pieces; ++i) shares[i] = T(0);
        for (int i = 0; i < path.pieces; ++i) fastest[i] = T(0);
        const T* limits[] = {path.velocity, path.acceleration, jerk};
        for (int order = 0; order < 3; ++order)
            for (int r = 0; r < path.rows; ++r) per_limit_[order][r] = T(1) / limits[order][r];
    }

    /// Note the rates p' ṡ, p'' ṡ² + p' s̈ and p''' ṡ³ + 3 p'' ṡ s̈ + p' s⃛ at s and its derivatives. Rows of second
    /// order count as accelerations, and are linear between grid points.
    void note(const T s[4]) {
        while (piece_ < path_.pieces - 1 && path_.breakpoints[piece_ + 1] <= s[0]) ++piece_;
        while (piece_ > 0 && path_.breakpoints[piece_] > s[0]) --piece_;
        const T sigma = s[0] - path_.breakpoints[piece_], v = s[1];
        const int n = path_.rows;
        T p[R] = {}, p1[R] = {}, p2[R] = {}, p3[R] = {}, worst[3] = {};
        for (int k = 0; k <= path_.degree; ++k)
            for (int r = 0; r < n; ++r) {
                p3[r] = p3[r] * sigma + T(3) * p2[r];
                p2[r] = p2[r] * sigma + T(2) * p1[r];
                p1[r] = p1[r] * sigma + p[r];
                p[r] = p[r] * sigma + path_.coefficients[(k * path_.pieces + piece_) * n + r];
            }
        for (int r = 0; r < n; ++r) {
            const T rates[] = {p1[r] * v, p2[r] * v * v + p1[r] * s[2],
                               (p3[r] * v * v + T(3) * p2[r] * s[2]) * v + p1[r] * s[3]};
            for (int order = 0; order < 3; ++order)
                worst[order] = greatest(worst[order], absolute(rates[order]) * per_limit_[order][r]);
        }
        if (more_.rows > 0) worst[1] = greatest(worst[1], most_of_rows(s));
        for (int order = 0; order < 3; ++order) {
            T& most = shares_[order * path_.pieces + piece_];
            most = greatest(most, worst[order]);
        }
        fastest_[piece_] = greatest(fastest_[piece_], v);
    }

private:
    /// The greatest a s̈ + b ṡ² of the rows at s.
    T most_of_rows(const T s[4]) {
        while (interval_ < law_.count - 1 && law_.grid[interval_ + 1] <= s[0]) ++interval_;
        while (interval_ > 0 && law_.grid[interval_] > s[0]) --interval_;
        const T* const here = law_.grid + interval_;
        const T u = (s[0] - here[0]) / (here[1] - here[0]);
        T most = T(0);
        for (int r = 0; r < more_.rows; ++r) {
            const int from = interval_ * more_.rows + r, to = from + more_.rows;
            const T a = more_.a[from] + u * (more_.a[to] - more_.a[from]);
            const T b = more_.b[from] + u * (more_.b[to] - more_.b[from]);
            most = greatest(most, a * s[2] + b * s[1] * s[1]);
        }
        return most;
    }

    static constexpr int R = most_path_rows;
    const limited_path<T>& path_;
    const grid_law<T>& law_;
    const second_order_rows<T>& more_;
    T *shares_, *fastest_, per_limit_[3][R];
    int piece_ = 0, interval_ = 0;
};
}  // namespace detail

/// What shares of the limits of velocity, acceleration and jerk (rows) the averaged law uses on each piece of the path,
/// `shares` (3, pieces), and the largest ṡ there, `fastest` (pieces). It looks at both ends and the middle of each
/// part. Parts end at the knots of the law, and about where pieces of the path do. `scratch` holds 3 (count + 1).
template <class T>
void shares_of_average(const limited_path<T>& path, const T* jerk, const grid_law<T>& law,
                       const second_order_rows<T>& more, T window, T* scratch, T* shares, T* fastest) {
    detail::average<T> average(law, window, scratch);
    detail::used_limits<T> used(path, jerk, law, more, shares, fastest);
    T s[4], to = T(0);
    int inner = 1;
    for (T begin = T(0), end; begin < average.duration(); begin = end) {
        const T from = to;
        end = average.next_knot(begin);
        average.at(end, s);
        to = s[0];
        for (T part = begin; part < end;) {
            T last = end;
            if (inner < path.pieces && path.breakpoints[inner] < to) {
                last = begin + (path.breakpoints[inner++] - from) / (to - from) * (end - begin);
                if (!(last > part)) continue;
            }
            for (const T share : {T(0), T(0.5), detail::before_the_end<T>}) {
                average.at(part + share * (last - part), s);
                used.note(s);
            }
            part = last;
        }
    }
}

TWISTARM_END
