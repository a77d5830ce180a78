// Posture: among the configurations that meet a target, a redundant arm's choice of the one nearest to it.
#pragma once

#include "searches.hpp"

TWISTARM_BEGIN

namespace detail {
constexpr int most_posture_steps = 100, most_corrections = 6;
template <class T> constexpr T least_share = T(1e-3);  ///< of a step, before it is given up
template <class T> constexpr T negligible_step = T(sizeof(T) == 8 ? 1e-7 : 1e-4);       ///< [rad, m]
template <class T> constexpr T singular_shift = T(sizeof(T) == 8 ? 1e-10 : 1e-6);    ///< keeps J Jᵀ invertible
template <class T> constexpr T corrected = T(sizeof(T) == 8 ? 1e-22 : 1e-11);        ///< E on the target, [m²]

template <class T> constexpr T corrected_inexactly = T(sizeof(T) == 8 ? 1e-14 : 1e-10);  ///< [m²]

/// The target as its answer meets it, if the answer is only within loose tolerances.
template <class T, int N, int M>
target<T> reached_target(const chain<T, N, M>& arm, const target<T>& asked, const T* theta) {
    const frame<T> g = forward(arm, theta);
    target<T> kept = asked;
    for (int k = 0; k < 3; ++k) kept.goal.p[k] = g.p[k];
    if (asked.kind == target_kind::pose) kept.goal = g;
    if (asked.kind == target_kind::approach) rotate(g, asked.tool_axis, kept.direction);
    return kept;
}

template <class T> T squared_distance(const T* a, const T* b, int n) {
    T sum = T(0);
    for (int k = 0; k < n; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
    return sum;
}

/// Steps along the configurations that meet one target, toward θ_p (n,), inside the limits.
template <target_kind Kind, class T, int N, int M> struct posture_walk {
    static constexpr int rows = rows_of(Kind);

    const chain<T, N, M>& arm;
    const ranges<T, N>& range;
    const T* posture;
    T enough;  ///< E on the target [m²]
    aim<T> aims;
    residual<T, N, rows> at;
    bool free[capacity(N)];
    T last[capacity(N)], last_way[capacity(N)];  ///< where the step before began, and its way down
    bool begun;

    int size() const { return arm.coordinates(); }

    /// Error and rows at θ; E.
    T look(const T* theta) {
        frame<T> g;
        column<T> columns[capacity(N)];
        walk_with_columns(arm, aims.base, aims.tip, theta, g, columns);
        residual_of<Kind, N>(g, columns, size(), aims, T(1), at);
        return at.position_squared + at.rotation_squared;
    }

    /// d − Jᵀ (J Jᵀ)⁻¹ (J d + r) on the free coordinates: the step d' nearest to d with J d' = −r.
    void project(const T* r, T* d) const {
        T H[rows][rows], y[rows];
        for (int a = 0; a < rows; ++a) {
            y[a] = r[a];
            for (int b = 0; b <= a; ++b) H[a][b] = a == b ? singular_shift<T> : T(0);
            for (int i = 0; i < size(); ++i) {
                if (!free[i]) continue;
                y[a] += at.J[i][a] * d[i];
                for (int b = 0; b <= a; ++b) H[a][b] += at.J[i][a] * at.J[i][b];
            }
        }
        solve_ldl(H, y, rows);
        for (int i = 0; i < size(); ++i)
            for (int a = 0; a < rows; ++a) d[i] = free[i] ? d[i] - at.J[i][a] * y[a] : T(0);
    }

    bool leads_out(const T* theta, int i, T d) const {
        return (theta[i] <= range.lower[i] && d < T(0)) || (theta[i] >= range.upper[i] && d > T(0));
    }

    /// The way toward the posture that neither the target nor a bound resists; its longest component.
    T downhill(const T* theta, T* d) {
        const T nothing[rows] = {};
        for (int i = 0; i < size(); ++i) free[i] = true;
        for (bool again = true; again;) {
            again = false;
            for (int i = 0; i < size(); ++i) d[i] = free[i] ? posture[i] - theta[i] : T(0);
            project(nothing, d);
            for (int i = 0; i < size(); ++i)
                if (free[i] && leads_out(theta, i, d[i])) {
                    free[i] = false;
                    again = true;
                }
        }
        project(nothing, d);  // again: near a singularity `singular_shift` leaves something of what J d resists
        T longest = T(0);
        for (int i = 0; i < size(); ++i) longest = greatest(longest, absolute(d[i]));
        return longest;
    }

    /// θ brought back onto the target, inside the limits; whether it is there.
    bool correct(T* theta) {
        for (int k = 0; k < most_corrections; ++k) {
            for (int i = 0; i < size(); ++i) theta[i] = clamped(theta[i], range.lower[i], range.upper[i]);
            if (look(theta) <= enough) return true;
            for (int i = 0; i < size(); ++i) free[i] = theta[i] > range.lower[i] && theta[i] < range.upper[i];
            T d[capacity(N)] = {};
            project(at.e, d);
            for (int i = 0; i < size(); ++i) theta[i] += d[i];
        }
        return false;
    }

    /// The part of d to go: ‖s‖²/(s · y), with s the previous step and y the decrease of d by it. It is the inverse of
    /// the curvature along s. Source: J. Barzilai & J. Borwein, Two-point step size gradient methods, IMA J. Numer.
    /// Anal. 8, 1988.
    T share_of(const T* theta, const T* d) {
        T moved = T(0), bent = T(0);
        for (int i = 0; i < size(); ++i) {
            const T s = theta[i] - last[i];
            moved += s * s;
            bent += s * (last_way[i] - d[i]);
            last[i] = theta[i];
            last_way[i] = d[i];
        }
        const bool known = begun && bent > T(0);
        begun = true;
        return known ? moved / bent : T(1);
    }

    /// One step, shortened until it leads nearer and its correction is no longer than the step. A longer correction
    /// means another branch. False if no length works.
    bool step(T* theta) {
        T d[capacity(N)], ahead[capacity(N)], trial[capacity(N)];
        look(theta);
        const T longest = downhill(theta, d), before = squared_distance(theta, posture, size());
        if (longest <= negligible_step<T>) return false;
        const T shortest = least_share<T> * negligible_step<T>;
        for (T share = least(share_of(theta, d), T(0.5) / longest); share * longest > shortest; share *= T(0.5)) {
            for (int i = 0; i < size(); ++i) ahead[i] = trial[i] = theta[i] + share * d[i];
            if (!correct(trial) || squared_distance(trial, posture, size()) >= before) continue;
            if (squared_distance(trial, ahead, size()) > squared_distance(ahead, theta, size())) continue;
            for (int i = 0; i < size(); ++i) theta[i] = trial[i];
            wrap_near(range, size(), posture, theta);
            return true;
        }
        return false;
    }
};

template <target_kind Kind, class T, int N, int M, class Stopped>
void walk_to_posture(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                     const target<T>& asked, const T* posture, bool exact, Stopped& stopped, T* theta) {
    const T tolerance = T(0.5) * least(settings.position_tolerance, settings.orientation_tolerance);
    posture_walk<Kind, T, N, M> walk{
        arm, range, posture, least(corrected<T>, tolerance * tolerance), aim_at(arm, asked), {}, {}, {}, {}, false};
    if (!exact) walk.enough = corrected_inexactly<T>;
    for (int k = 0; k < most_posture_steps && !stopped() && walk.step(theta); ++k) continue;
}
}  // namespace detail

/// Moves an answer to a local minimum of ‖θ − θ_p‖² (rad, m) inside the limits among the configurations that meet the
/// target. Each step is θ_p − θ projected onto the null space of the target's rows, then corrected onto the target. The
/// answer stays if no minimum is found, or none nearer to the posture. Source: the gradient projection of J. B. Rosen,
/// The gradient projection method for nonlinear programming II, SIAM J. 9, 1961.
template <class T, int N, int M, class Stopped>
void approach_posture(const chain<T, N, M>& arm, const ranges<T, N>& range, const search_settings<T>& settings,
                      const target<T>& asked, const T* posture, Stopped& stopped, solution<T, N>& found) {
    solution<T, N> moved = found;
    wrap_near(range, arm.coordinates(), posture, moved.theta);
    const bool exact = is_exact(found, settings) || asked.kind == target_kind::task;
    const target<T> kept = exact ? asked : detail::reached_target(arm, asked, found.theta);
    with_kind(asked.kind, [&](auto kind) {
        detail::walk_to_posture<kind()>(arm, range, settings, kept, posture, exact, stopped, moved.theta);
    });
    if (judge(arm, range, settings, asked, posture, moved)) found = moved;
}

TWISTARM_END
