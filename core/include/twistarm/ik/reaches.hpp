// Lengths in reaches of the arm: the unit of inverse kinematics, so that the size of an arm changes no answer.
#pragma once

#include "ranges.hpp"
#include "searches.hpp"
#include "target.hpp"

TWISTARM_BEGIN

/// Units between SI and reaches. Every function returns what it is given in the other unit.
template <class T, int N> struct reaches {
    int n;
    T metres;                                    ///< the unit of length [m]
    T unit[capacity(N)], per_unit[capacity(N)];  ///< of θ: `metres` where a coordinate moves slides alone, else 1
    T lower[capacity(N)], upper[capacity(N)];    ///< limits in SI

    template <class Target> Target asked(Target given) const {
        for (int a = 0; a < 3; ++a) {
            given.goal.p[a] *= T(1) / metres;
            given.tolerance[a] *= T(1) / metres;
        }
        return given;
    }
    const T* theta(const T* given, T* in_reaches) const {
        for (int k = 0; k < n; ++k) in_reaches[k] = given[k] * per_unit[k];
        return in_reaches;
    }
    /// θ in SI. What was `inside` the limits stays inside.
    void back(const T* in_reaches, bool inside, T* theta) const {
        for (int k = 0; k < n; ++k) {
            theta[k] = in_reaches[k] * unit[k];
            if (inside) theta[k] = clamped(theta[k], lower[k], upper[k]);
        }
    }
};

/// The units of an arm with these limits (n,) and this reach [m]; without a finite reach above 0 the unit is 1 m.
template <class T, int N, int M, class S>
reaches<T, N> reaches_of(const chain<T, N, M>& arm, const S* lower, const S* upper, T reach) {
    reaches<T, N> units{};
    units.n = arm.coordinates();
    units.metres = reach > T(0) && reach < T(__builtin_inf()) ? reach : T(1);
    for (int k = 0; k < units.n; ++k) {
        bool slides = false, turns = false;
        for (int i = 0; i < arm.joints(); ++i) {
            if (arm.identity ? i != k : arm.coupling[i][k] == T(0)) continue;
            slides = true;
            turns = turns || arm.links[i].turn != T(0);
        }
        units.unit[k] = slides && !turns ? units.metres : T(1);
        units.per_unit[k] = T(1) / units.unit[k];
        units.lower[k] = static_cast<T>(lower[k]);
        units.upper[k] = static_cast<T>(upper[k]);
    }
    return units;
}

/// The chain in reaches. A slide's own coordinate x is in reaches too, one that turns as well stays in rad.
template <class T, int N, int M> chain<T, N, M> in_reaches(const reaches<T, N>& units, chain<T, N, M> arm) {
    const T per_metre = T(1) / units.metres;
    for (int a = 0; a < 3; ++a) {
        arm.base.p[a] *= per_metre;
        arm.tip.p[a] *= per_metre;
    }
    for (int i = 0; i < arm.joints(); ++i) {
        link<T>& joint = arm.links[i];
        const T own = joint.turn == T(0) ? units.metres : T(1);
        for (int a = 0; a < 3; ++a) joint.offset[a] *= per_metre;
        if (own == T(1)) joint.slide *= per_metre;
        for (int k = 0; k < units.n; ++k) arm.coupling[i][k] *= units.unit[k] / own;
    }
    return arm;
}

/// The ranges in reaches, of the chain in reaches.
template <class T, int N, int M>
ranges<T, N> in_reaches(const reaches<T, N>& units, const chain<T, N, M>& scaled, ranges<T, N> range) {
    T* const every[] = {range.lower, range.upper, range.start_lower, range.start_upper};
    for (T* bounds : every) units.theta(bounds, bounds);
    detail::find_most_velocity(scaled, range);
    see_starts(scaled, range);
    return range;
}

/// The answer in SI.
template <class T, int N> solution<T, N> in_metres(const reaches<T, N>& units, solution<T, N> found) {
    units.back(found.theta, true, found.theta);
    found.position_error *= units.metres;
    found.start_error.position *= units.metres * units.metres;
    return found;
}

TWISTARM_END
