// Limits on the intervals of a grid along a path: rows a x0 + b x1 ≤ 1 of x = ṡ² at both ends. They keep every velocity
// and acceleration limit on the whole interval, with x linear in s.
//
// The acceleration p' s̈ + p'' x is a polynomial in s of degree d − 1, the squared velocity p'² x one of degree 2 d −
// 1. Each of their Bernstein coefficients gives a row, because it is linear in x0 and x1.
#pragma once

#include "../kinematics/chain.hpp"
#include "path_velocity.hpp"

TWISTARM_BEGIN

/// A path for its limits: `rows` polynomials p of s on each of `pieces`, and the limits of their rates.
template <class T> struct limited_path {
    int degree, pieces, rows;
    const T* breakpoints;   ///< (pieces + 1)
    const T* coefficients;  ///< (degree + 1, pieces, rows), highest power of s − breakpoints[i] first
    const T *velocity, *acceleration;  ///< (rows), infinite where there is none
    const T* ceiling;  ///< the largest ṡ on each piece
};

/// Limits a s̈ + b ṡ² ≤ 1 at the points of a grid, such as those of torques: Pham & Pham 2018, §II.
template <class T> struct second_order_rows {
    int rows;
    const T *a, *b;  ///< (points, rows)
};

namespace detail {
constexpr int most_path_degree = 5, most_path_rows = 2 * most_joints;
constexpr int most_second_order_rows = 2 * most_path_rows;  // Each effort has a limit on both sides.

/// Pascal's triangle.
template <class T> constexpr T choose(int n, int k) {
    T product = T(1);
    for (int i = 1; i <= k; ++i) product = product * static_cast<T>(n - k + i) / static_cast<T>(i);
    return product;
}
}  // namespace detail

/// The rows of the intervals in order. The returned arrays are valid until the next call.
template <class T> class interval_limits {
public:
    static bool fits(const limited_path<T>& path) {
        return path.degree >= 2 && path.degree <= detail::most_path_degree && path.pieces >= 1 && path.rows >= 1 &&
               path.rows <= detail::most_path_rows;
    }
    static bool fits(const second_order_rows<T>& more) {
        return more.rows >= 0 && more.rows <= detail::most_second_order_rows;
    }

    interval_limits(const limited_path<T>& path, const T* grid, const second_order_rows<T>& more)
        : path_(path), grid_(grid), more_(more) {
        for (int r = 0; r < path.rows; ++r) {
            per_velocity_[r] = T(1) / path.velocity[r];
            per_acceleration_[r] = T(1) / path.acceleration[r];
        }
        const int d = path.degree, e = d - 1;
        for (int k = 0; k <= e; ++k)
            for (int i = 0; i <= k; ++i) {
                tangent_[k][i] = detail::choose<T>(k, i) / detail::choose<T>(e, i);
                bend_[k][i] = i < e && k < e ? detail::choose<T>(k, i) / detail::choose<T>(e - 1, i) : T(0);
            }
        for (int i = 0; i <= e; ++i)
            for (int j = 0; j <= e; ++j)
                square_[i][j] = detail::choose<T>(e, i) * detail::choose<T>(e, j) / detail::choose<T>(2 * e, i + j);
    }

    velocity_rows<T> operator()(int i) {
        enter(i);
        const int d = path_.degree, e = d - 1, n = path_.rows;
        const T per_2h = T(1) / (T(2) * (grid_[i + 1] - grid_[i]));
        count_ = 0;
        for (int k = 0; k < d; ++k)
            for (int r = 0; r < n; ++r) {
                const T speeding = dp_[k][r] * per_2h;
                const T before = k < e ? ddp_[k][r] * static_cast<T>(e - k) / static_cast<T>(e) : T(0);
                const T after = k > 0 ? ddp_[k - 1][r] * static_cast<T>(k) / static_cast<T>(e) : T(0);
                add((before - speeding) * per_acceleration_[r], (after + speeding) * per_acceleration_[r]);
                add((speeding - before) * per_acceleration_[r], -(after + speeding) * per_acceleration_[r]);
            }
        for (int r = 0; r < n; ++r) {
            T last = T(0);
            for (int k = 0; k <= 2 * e + 1; ++k) {
                T squared = T(0);
                for (int m = k > e ? k - e : 0; m <= e && m <= k; ++m) squared += square_[m][k - m] * dp_[m][r] * dp_[k - m][r];
                squared *= per_velocity_[r] * per_velocity_[r];
                const T whole = static_cast<T>(2 * e + 1);
                add(squared * static_cast<T>(2 * e + 1 - k) / whole, last * static_cast<T>(k) / whole);
                last = squared;
            }
        }
        const T cap = T(1) / (path_.ceiling[piece_] * path_.ceiling[piece_]);
        add(cap, T(0));
        add(T(0), cap);
        if (more_.rows > 0) add_second_order(i, per_2h);
        return {a_, b_, count_};
    }

    /// How far the interval uses the limit that it uses most, 1 for up to it.
    T share(int i, T x0, T x1) {
        enter(i);
        const int e = path_.degree - 1, n = path_.rows;
        const T s_ddot = (x1 - x0) / (T(2) * (grid_[i + 1] - grid_[i])), half = T(0.5);
        T most = half * (x0 + x1) / (path_.ceiling[piece_] * path_.ceiling[piece_]);
        for (int r = 0; r < n; ++r) {
            const T v0 = dp_[0][r] * per_velocity_[r], v1 = dp_[e][r] * per_velocity_[r];
            const T a0 = dp_[0][r] * s_ddot + ddp_[0][r] * x0, a1 = dp_[e][r] * s_ddot + ddp_[e - 1][r] * x1;
            const T velocity = half * (v0 * v0 * x0 + v1 * v1 * x1);
            const T acceleration = half * (absolute(a0) + absolute(a1)) * per_acceleration_[r];
            if (velocity > most) most = velocity;
            if (acceleration > most) most = acceleration;
        }
        for (int r = 0; r < more_.rows; ++r) {
            const int from = i * more_.rows + r, to = from + more_.rows;
            const T begin = more_.a[from] * s_ddot + more_.b[from] * x0, end = more_.a[to] * s_ddot + more_.b[to] * x1;
            most = greatest(most, half * (greatest(begin, T(0)) + greatest(end, T(0))));
        }
        return most;
    }

private:
    void add_second_order(int i, T per_2h) {
        for (int end = 0; end < 2; ++end) {
            const T *a = more_.a + (i + end) * more_.rows, *b = more_.b + (i + end) * more_.rows;
            for (int r = 0; r < more_.rows; ++r) add((end ? T(0) : b[r]) - a[r] * per_2h, (end ? b[r] : T(0)) + a[r] * per_2h);
        }
    }

    void add(T a, T b) {
        a_[count_] = a;
        b_[count_++] = b;
    }

    /// Bernstein coefficients of p' and p'' on the interval.
    void enter(int i) {
        const int d = path_.degree, n = path_.rows;
        const T h = grid_[i + 1] - grid_[i], middle = grid_[i] + T(0.5) * h;
        while (piece_ > 0 && path_.breakpoints[piece_] > middle) --piece_;
        while (piece_ < path_.pieces - 1 && path_.breakpoints[piece_ + 1] < middle) ++piece_;
        const T sigma = grid_[i] - path_.breakpoints[piece_];
        T here[detail::most_path_degree + 1];
        for (int r = 0; r < n; ++r) {
            for (int k = 0; k <= d; ++k) here[k] = path_.coefficients[(k * path_.pieces + piece_) * n + r];
            // Taylor's shift: the lowest power comes right first.
            for (int stop = d; stop > 0; --stop)
                for (int k = 1; k <= stop; ++k) here[k] += here[k - 1] * sigma;
            T first[detail::most_path_degree] = {}, second[detail::most_path_degree] = {}, power = T(1);
            for (int k = 0; k < d; ++k) {
                first[k] = static_cast<T>(k + 1) * here[d - 1 - k] * power;
                if (k < d - 1) second[k] = static_cast<T>((k + 2) * (k + 1)) * here[d - 2 - k] * power;
                power *= h;
            }
            for (int k = 0; k < d; ++k) {
                T tangent = T(0), bend = T(0);
                for (int m = 0; m <= k; ++m) {
                    tangent += tangent_[k][m] * first[m];
                    bend += bend_[k][m] * second[m];
                }
                dp_[k][r] = tangent;
                ddp_[k][r] = bend;
            }
        }
    }

    static constexpr int D = detail::most_path_degree, R = detail::most_path_rows;
    const limited_path<T>& path_;
    const T* grid_;
    const second_order_rows<T> more_;
    int piece_ = 0, count_ = 0;
    T per_velocity_[R], per_acceleration_[R];
    T tangent_[D][D] = {}, bend_[D][D] = {}, square_[D][D];
    T dp_[D][R], ddp_[D][R];
    static constexpr int most_rows = 4 * D * R + 2 + 2 * detail::most_second_order_rows;
    T a_[most_rows], b_[most_rows];
};

TWISTARM_END
