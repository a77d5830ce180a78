// An arm under the servo, watched at each step, and commands at random.
#pragma once

#include "arms.hpp"
#include "motions.hpp"
#include "twistarm/servo/servo.hpp"

namespace tests {
using twistarm::capacity;
using twistarm::dynamic;
using twistarm::servo_command;
using twistarm::servo_kind;

template <class T> constexpr bool precise = sizeof(T) == 8;
template <class T> constexpr double rounding = precise<T> ? 1e-11 : 2e-5;

/// An arm, its limits, and a servo that is watched.
template <class T, int N, int M> struct driven_arm {
    drawn_arm source;
    twistarm::chain<T, N, M> arm;
    twistarm::servo_bounds<T, N> bounds{};
    twistarm::servo_state<T, N> state{};
    twistarm::servo_output<T> out{};
    T before[capacity(N)] = {}, dt = T(0);
    int n;

    driven_arm(generator& random, int count, wiring wired, int motors)
        : source(random, count, wired), n(source.coordinates) {
        twistarm::chain<double, dynamic, dynamic> whole{};
        while (!twistarm::chain_from_screws(source.model(), whole) || !twistarm::fits<N, M>(whole))
            source = drawn_arm(random, count, wired);
        arm = twistarm::narrowed<T, N, M>(whole);
        bounds.motion = drawn_limits<T, N>(random, motors, n);
        bounds.length = T(0.7);
        bounds.below = T(0.04);
        for (int k = 0; k < n; ++k) {
            const double* twist = source.twists[k];
            const bool slides = twist[3] == 0 && twist[4] == 0 && twist[5] == 0;
            bounds.unit[k] = slides ? bounds.length : T(1);
            bounds.ready[k] = static_cast<T>(random.between(-0.04, 0.04));
        }
    }

    void step(const servo_command<T, N>& command, T time) {
        dt = time;
        for (int k = 0; k < n; ++k) before[k] = state.theta_dot[k];
        twistarm::servo_step(arm, bounds, command, dt, state, out);
        for (int k = 0; k < n; ++k)
            CHECK(std::isfinite(state.theta[k]) && std::isfinite(state.theta_dot[k]), "n = %d, joint %d", n, k);
        for (const T lost : out.lost) CHECK(std::isfinite(lost), "n = %d: %g lost", n, static_cast<double>(lost));
        CHECK(out.scale >= T(0) && out.scale <= T(1), "n = %d: scale %g", n, static_cast<double>(out.scale));
        CHECK(out.row >= -1 && out.row < bounds.motion.rows(), "n = %d: row %d", n, out.row);
        check_limits(bounds.motion, state.theta, before, state.theta_dot, dt, rounding<T>);
    }

    /// The largest rate of a joint.
    double speed() const {
        double most = 0;
        for (int k = 0; k < n; ++k) most = std::fmax(most, std::fabs(static_cast<double>(state.theta_dot[k])));
        return most;
    }

    /// Motors slow the arm as a whole: one at its limit lets nothing move that would move it on.
    bool stands_at_a_motors_limit() const {
        for (int r = 0; r < bounds.motion.motors; ++r) {
            const T x = bounds.motion.place(r, state.theta), slack = T(1e-3);
            if (x < bounds.motion.lower[r] + slack || x > bounds.motion.upper[r] - slack) return true;
        }
        return false;
    }

    void come_to_rest() {
        const servo_command<T, N> none{};
        for (int i = 0; i < 5000 && speed() > 0; ++i) step(none, T(0.01));
        CHECK(speed() == 0, "n = %d: moves at %g", n, speed());
    }

};

template <class T, int N> servo_command<T, N> drawn_twist(generator& random) {
    servo_command<T, N> command{};
    command.kind = servo_kind::twist;
    command.base_axes = random.uniform() < 0.5;
    for (int k = 0; k < 6; ++k) command.twist[k] = static_cast<T>((k < 3 ? 0.3 : 1) * random.between(-1, 1));
    return command;
}

template <class T, int N> void hold(servo_command<T, N>& command, int first, int last) {
    for (int k = first; k < last; ++k) {
        command.held[k] = true;
        command.twist[k] = T(0);
    }
}

template <class T, int N, int M>
servo_command<T, N> drawn_command(generator& random, const driven_arm<T, N, M>& driven) {
    const double kind = random.uniform();
    servo_command<T, N> command = drawn_twist<T, N>(random);
    if (kind < 0.2) hold(command, 3, 6);
    else if (kind < 0.3) hold(command, 0, 3);
    else if (kind < 0.4) hold(command, 2, 4);
    else if (kind < 0.6) command.kind = servo_kind::jog;
    else if (kind < 0.75) command.kind = servo_kind::pose;
    if (command.kind == servo_kind::pose && random.uniform() < 0.8)
        for (T& component : command.twist) component = T(0);
    T theta[capacity(N)];
    for (int k = 0; k < driven.n; ++k) {
        command.rates[k] = static_cast<T>(random.between(-2, 2));
        theta[k] = driven.state.theta[k] + static_cast<T>(random.between(-0.3, 0.3));
    }
    command.goal = twistarm::forward(driven.arm, theta);
    command.linear_speed = T(0.25);
    command.angular_speed = T(1);
    return command;
}

template <class T, int N> servo_command<T, N> reversed(servo_command<T, N> command) {
    for (T& component : command.twist) component = -component;
    for (T& rate : command.rates) rate = -rate;
    return command;
}

}  // namespace tests
