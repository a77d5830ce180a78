// Limits of joints and motors at random, and the judge of motions: every limit, row by row in long double.
#pragma once

#include "check.hpp"
#include "plain.hpp"
#include "twistarm/kinematics/motion_limits.hpp"

namespace tests {
constexpr double far = INFINITY;

/// Joints with limits of every kind, and some motors that each drive several of them. 0 is inside.
template <class T, int N>
twistarm::motion_limits<T, N> drawn_limits(generator& random, int motors, int n) {
    twistarm::motion_limits<T, N> limits{};
    limits.motors = motors;
    limits.coordinates = n;
    for (int r = 0; r < motors; ++r) {
        limits.c[r] = static_cast<T>(random.between(-1, 1));
        for (int k = 0; k < n; ++k) limits.C[r][k] = static_cast<T>(random.uniform() < 0.4 ? 0 : random.between(-3, 3));
    }
    for (int r = 0; r < motors + n; ++r) {
        const double at_zero = r < motors ? static_cast<double>(limits.c[r]) : 0;
        const auto drawn = [&](double unlimited, double given) {
            return static_cast<T>(random.uniform() < 0.15 ? unlimited : given);
        };
        limits.lower[r] = drawn(-far, at_zero - random.between(0.05, 2));
        limits.upper[r] = drawn(far, at_zero + random.between(0.05, 2));
        limits.velocity[r] = drawn(far, random.between(0.2, 3));
        limits.acceleration[r] = drawn(far, random.between(0.5, 20));
    }
    return limits;
}

/// Row r of x = C θ + c, or of its rate, in long double.
template <class T, int N>
real row(const twistarm::motion_limits<T, N>& limits, int r, const T* theta, bool rate) {
    if (r >= limits.motors) return static_cast<real>(theta[r - limits.motors]);
    real sum = rate ? 0 : static_cast<real>(limits.c[r]);
    for (int k = 0; k < limits.coordinates; ++k) sum += static_cast<real>(limits.C[r][k]) * static_cast<real>(theta[k]);
    return sum;
}

/// No row beyond a position, a velocity or, from `before` to `after` in dt, an acceleration; `slack` is for rounding.
template <class T, int N>
void check_limits(const twistarm::motion_limits<T, N>& limits, const T* theta, const T* before, const T* after, T dt,
                  double slack) {
    for (int r = 0; r < limits.rows(); ++r) {
        const auto x = static_cast<double>(row(limits, r, theta, false));
        const real now = row(limits, r, after, true), then = row(limits, r, before, true);
        const auto speed = static_cast<double>(std::fabs(now)), change = static_cast<double>(std::fabs(now - then));
        const auto lower = static_cast<double>(limits.lower[r]), upper = static_cast<double>(limits.upper[r]);
        const auto most = static_cast<double>(limits.velocity[r]);
        const auto room = static_cast<double>(limits.acceleration[r] * dt);
        CHECK(x >= lower - slack && x <= upper + slack, "row %d of %d + %d at %.9g, not in [%g, %g]", r, limits.motors,
              limits.coordinates, x, lower, upper);
        CHECK(speed <= most + slack, "row %d of %d + %d moves at %.9g, not %g", r, limits.motors, limits.coordinates,
              speed, most);
        CHECK(change <= room + slack, "row %d of %d + %d changes by %.9g, not %g", r, limits.motors, limits.coordinates,
              change, room);
    }
}
}  // namespace tests
