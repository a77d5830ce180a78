// Motion limits: drives at random steps of time, in which no motor and no joint may pass a position, a velocity or an
// acceleration, and from which the arm stops in time and moves away again.
#include "motions.hpp"

using namespace twistarm;
using tests::far;

namespace {
constexpr int steps = 200;

template <class T> constexpr double rounding = sizeof(T) == 8 ? 1e-11 : 2e-5;

/// An arm that is moved by what `keep_within` leaves of what is wanted, every row watched.
template <class T, int N> struct moving_arm {
    const motion_limits<T, N>& limits;
    T theta[capacity(N)] = {}, theta_dot[capacity(N)] = {};

    void step(const T* wanted, T dt) {
        const int n = limits.coordinates;
        T before[capacity(N)] = {};
        for (int k = 0; k < n; ++k) {
            before[k] = theta_dot[k];
            theta_dot[k] = wanted[k];
        }
        keep_within(limits, theta, before, dt, theta_dot);
        for (int k = 0; k < n; ++k) theta[k] += dt * theta_dot[k];
        tests::check_limits(limits, theta, before, theta_dot, dt, rounding<T>);
    }

    bool rests() const {
        for (int k = 0; k < limits.coordinates; ++k)
            if (theta_dot[k] != T(0)) return false;
        return true;
    }

    double distance() const {
        double sum = 0;
        for (int k = 0; k < limits.coordinates; ++k) sum += static_cast<double>(theta[k] * theta[k]);
        return std::sqrt(sum);
    }
};

/// The longest that a row's share of a straight stop takes.
template <class T, int N> double time_to_stop(const motion_limits<T, N>& limits, const T* theta_dot) {
    double longest = 0;
    for (int r = 0; r < limits.rows(); ++r)
        longest = std::fmax(longest, static_cast<double>(std::fabs(tests::row(limits, r, theta_dot, true))) /
                                         static_cast<double>(limits.acceleration[r]));
    return longest;
}

template <class T, int N> void test_drives(tests::generator& random, int motors, int n) {
    const auto limits = tests::drawn_limits<T, N>(random, motors, n);
    moving_arm<T, N> arm{limits};
    T wanted[capacity(N)] = {};
    for (int i = 0; i < steps; ++i) {
        const double fast = random.uniform() < 0.1 ? 100 : 4;
        for (int k = 0; k < n && i % 20 == 0; ++k) wanted[k] = static_cast<T>(random.between(-fast, fast));
        arm.step(wanted, static_cast<T>(std::exp(random.between(std::log(1e-3), std::log(0.1)))));
    }
    const T dt = T(0.01), rest[capacity(N)] = {};
    const double stops_in = time_to_stop(limits, arm.theta_dot) / static_cast<double>(dt) + 1.01;
    for (int i = 0; i < static_cast<int>(stops_in); ++i) arm.step(rest, dt);
    CHECK(arm.rests(), "%d + %d rows: still moving after %g steps", motors, n, stops_in);
    const double before = arm.distance();
    for (int k = 0; k < n; ++k) wanted[k] = -arm.theta[k];
    arm.step(wanted, dt);
    arm.step(wanted, dt);
    CHECK(before < 1e-3 || arm.distance() < before, "%d + %d rows: cannot go back inside from %g", motors, n, before);
}

/// All that may be had is had: one joint at 2 rad/s² to its velocity, and on to its very limit.
template <class T> void test_nothing_is_wasted() {
    motion_limits<T, 1> limits{};
    limits.coordinates = 1;
    limits.lower[0] = T(-1);
    limits.upper[0] = T(1);
    limits.velocity[0] = T(0.5);
    limits.acceleration[0] = T(2);
    moving_arm<T, 1> arm{limits};
    const T wanted = T(3), dt = T(0.01);
    for (int i = 0; i < 25; ++i) arm.step(&wanted, dt);
    CHECK(std::fabs(static_cast<double>(arm.theta_dot[0]) - 0.5) < 1e-6, "%g", static_cast<double>(arm.theta_dot[0]));
    // Speed v is braked over v²/2a = 62.5 mm in 0.25 s; the rest of the way at full speed takes 1.75 s.
    for (int i = 0; i < 200; ++i) arm.step(&wanted, dt);
    CHECK(std::fabs(static_cast<double>(arm.theta[0]) - 1) < 2e-4, "%.9g", static_cast<double>(arm.theta[0]));
    for (int i = 0; i < 100; ++i) arm.step(&wanted, dt);
    CHECK(std::fabs(static_cast<double>(arm.theta[0]) - 1) < 1e-6, "%.9g", static_cast<double>(arm.theta[0]));
}

/// A motor that stands at its limit does not mind what moves the others, nor rounding that seems to move it.
template <class T> void test_rounding_at_a_limit(tests::generator& random, double acceleration) {
    motion_limits<T, 3> limits{};
    limits.motors = 1;
    limits.coordinates = 3;
    for (int r = 0; r < 4; ++r) {
        limits.lower[r] = T(-far);
        limits.upper[r] = r == 0 ? T(0) : T(far);
        limits.velocity[r] = T(far);
        limits.acceleration[r] = static_cast<T>(acceleration);
    }
    for (int repeat = 0; repeat < 100; ++repeat) {
        moving_arm<T, 3> arm{limits};
        T wanted[3] = {static_cast<T>(random.between(0.3, 1)), static_cast<T>(random.between(-1, -0.3)), T(0)};
        for (int k = 0; k < 3; ++k) limits.C[0][k] = static_cast<T>(random.between(1, 3));
        wanted[2] = -(limits.C[0][0] * wanted[0] + limits.C[0][1] * wanted[1]) / limits.C[0][2];
        for (int i = 0; i < 40; ++i) arm.step(wanted, T(0.01));
        for (int k = 0; k < 3; ++k)
            CHECK(std::fabs(static_cast<double>(arm.theta_dot[k] - wanted[k])) < rounding<T>,
                  "joint %d moves at %g, not %g", k, static_cast<double>(arm.theta_dot[k]),
                  static_cast<double>(wanted[k]));
    }
}
}  // namespace

int main() {
    tests::generator random;
    for (int repeat = 0; repeat < 40; ++repeat) {
        for (int n = 1; n <= 8; ++n) {
            test_drives<double, dynamic>(random, repeat % 3, n);
            test_drives<float, dynamic>(random, repeat % 3, n);
        }
        test_drives<double, dynamic>(random, most_joints, most_joints);
        test_drives<double, 4>(random, 2, 4);
    }
    test_nothing_is_wasted<double>();
    test_nothing_is_wasted<float>();
    for (const double acceleration : {far, 10.0}) {
        test_rounding_at_a_limit<double>(random, acceleration);
        test_rounding_at_a_limit<float>(random, acceleration);
    }
    return tests::verdict("motion_limits");
}
