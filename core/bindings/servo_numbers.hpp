// A servo and its commands from plain numbers, for Python and WebAssembly.
#pragma once

#include "twistarm/kinematics/conversion.hpp"
#include "twistarm/servo/servo.hpp"

namespace bindings {

using ServoState = twistarm::servo_state<double, twistarm::dynamic>;
using ServoCommand = twistarm::servo_command<double, twistarm::dynamic>;

// The chain's screws (6, m), home (4, 4) and coupling (m, n); the motors' rows, C (k, n) and c (k,); the limits of all
// rows (k + n,): lower, upper, velocity, acceleration; unit and ready (n,).
struct ServoNumbers {
    int joints, coordinates, motors;
    const double *screws, *home, *coupling, *C, *c, *limits[4], *unit, *ready;
    double length, below, damping;
    bool stops;
};

struct ArmServo {
    twistarm::chain<double, twistarm::dynamic, twistarm::dynamic> chain{};
    twistarm::servo_bounds<double, twistarm::dynamic> bounds{};

    // False for a chain that does not fit.
    bool read(const ServoNumbers& given) {
        const twistarm::screw_model model{given.joints, given.coordinates, given.screws, given.home, given.coupling};
        if (given.motors > twistarm::most_joints || !twistarm::chain_from_screws(model, chain)) return false;
        auto& motion = bounds.motion;
        const int n = motion.coordinates = given.coordinates, count = motion.motors = given.motors;
        for (int r = 0; r < count; ++r)
            for (int k = 0; k < n; ++k) motion.C[r][k] = given.C[r * n + k];
        copy(given.c, count, motion.c);
        double* const limits[] = {motion.lower, motion.upper, motion.velocity, motion.acceleration};
        for (int i = 0; i < 4; ++i) copy(given.limits[i], count + n, limits[i]);
        copy(given.unit, n, bounds.unit);
        copy(given.ready, n, bounds.ready);
        bounds.length = given.length;
        bounds.below = given.below;
        bounds.damping = given.damping;
        bounds.stops = given.stops;
        return true;
    }

    // How many numbers a command of this kind has.
    int width(twistarm::servo_kind kind) const {
        switch (kind) {
            case twistarm::servo_kind::jog: return bounds.motion.coordinates;
            case twistarm::servo_kind::twist: return 6;
            case twistarm::servo_kind::pose: return 24;  // g (16), how it moves (6), linear and angular speed
            case twistarm::servo_kind::none: break;
        }
        return 0;
    }

    // flags: 1 for base axes, then a bit for each held component. numbers: as many as `width` says.
    ServoCommand command(twistarm::servo_kind kind, unsigned flags, const double* numbers) const {
        ServoCommand command{};
        command.kind = kind;
        command.base_axes = (flags & 1U) != 0U;
        for (unsigned k = 0; k < 6; ++k) command.held[k] = (flags >> (k + 1U) & 1U) != 0U;
        if (kind == twistarm::servo_kind::jog) copy(numbers, bounds.motion.coordinates, command.rates);
        if (kind == twistarm::servo_kind::twist) copy(numbers, 6, command.twist);
        if (kind == twistarm::servo_kind::pose) {
            command.goal = twistarm::frame_from_rows<double>(numbers);
            copy(numbers + 16, 6, command.twist);
            command.linear_speed = numbers[22];
            command.angular_speed = numbers[23];
        }
        return command;
    }

    // The state before a step with this command. held: the pose of which it holds components, or null.
    ServoState state(const ServoCommand& command, const double* theta, const double* theta_dot, const double* held,
                     double period) const {
        ServoState state{};
        state.period = period;
        copy(theta, bounds.motion.coordinates, state.theta);
        copy(theta_dot, bounds.motion.coordinates, state.theta_dot);
        if (held != nullptr) state.held = twistarm::frame_from_rows<double>(held);
        state.holding_base_axes = command.base_axes;
        for (int k = 0; k < 6; ++k) state.holding[k] = held != nullptr && command.held[k];
        return state;
    }

private:
    static void copy(const double* from, int count, double* to) {
        for (int i = 0; i < count; ++i) to[i] = from[i];
    }
};

}  // namespace bindings
