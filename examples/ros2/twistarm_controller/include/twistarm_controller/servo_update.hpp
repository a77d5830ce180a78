// One cycle of the controller as a pure function: what was measured and commanded goes in, positions and rates come out.
//
// No ROS, no heap, no exceptions. What is not finite in a command, a state or dt is answered by twistarm::servo_step,
// which is at rest then and says so by its `cause`; here stands what that cannot see: how old things are, whether anybody
// allows motion, and whether the arm is where it was told to be.
#pragma once

#include <twistarm/twistarm.hpp>

namespace twistarm_controller {

/// Why the arm was not told to do what is commanded; the first that holds.
enum class stopped_by { nothing, no_state, stale_state, strayed, interlock, late_cycle, stale_command, held };

/// What each of them means, for logs.
inline const char* text(stopped_by reason) {
    constexpr const char* texts[] = {
        "", "no joint state has arrived", "the joint state is too old",
        "the arm is not where it was commanded to be: stop, see why, and enable again", "motion is not enabled",
        "the cycle came too late", "the command is too old",
        "release the controls first: they were held when the arm was enabled"};
    return texts[static_cast<int>(reason)];
}

/// Told once. Times [s]; tolerance: how far a joint may be from where it was commanded [rad, m].
template <class T> struct update_settings {
    T period, command_timeout = T(0.2), state_timeout = T(0.2), max_dt = T(0.1), tolerance = T(0.2);
};

/// What a cycle begins with: the joints as measured, what is commanded, how old both are [s], dt since the last cycle.
template <class T, int N> struct update_input {
    T theta[twistarm::capacity(N)], state_age, command_age, dt;
    twistarm::servo_command<T, N> command;
    bool enabled;
};

/// What is kept from cycle to cycle. Begin with update_memory<T, N>{}: that starts where the arm is measured.
/// held: a command goes on from while motion was not enabled.
template <class T, int N> struct update_memory {
    twistarm::servo_state<T, N> state;
    bool started, blind, strayed, held;
};

/// What a cycle ends with. The setpoint is memory.state: theta where to be, theta_dot until then.
template <class T> struct update_output {
    twistarm::servo_output<T> servo;
    stopped_by reason;
    bool valid;  ///< whether there is a setpoint: false before the first joint state
};

namespace detail {
/// Whether 0 ≤ age ≤ timeout; not where it is NaN, nor where time went back.
template <class T> bool fresh(T age, T timeout) { return age >= T(0) && age <= timeout; }

/// Whether every joint says a number: ros2_control's say NaN before they were read.
template <class T, int N> bool usable(const T* theta, int n) {
    for (int k = 0; k < n; ++k)
        if (!(theta[k] - theta[k] == T(0))) return false;
    return true;
}

template <class T, int N> bool at_rest(const twistarm::servo_state<T, N>& state, int n) {
    for (int k = 0; k < n; ++k)
        if (state.theta_dot[k] != T(0)) return false;
    return true;
}

/// Whether a command asks for no motion; a pose always asks for it.
template <class T, int N> bool released(const twistarm::servo_command<T, N>& command, int n) {
    const bool jogs = command.kind == twistarm::servo_kind::jog;
    const T* const rates = jogs ? command.rates : command.twist;
    for (int k = 0; k < (jogs ? n : 6); ++k)
        if (rates[k] != T(0)) return command.kind == twistarm::servo_kind::none;
    return command.kind != twistarm::servo_kind::pose;
}

template <class T, int N>
bool away(const twistarm::servo_state<T, N>& state, const T* theta, T tolerance, int n) {
    for (int k = 0; k < n; ++k) {
        const T far = theta[k] - state.theta[k];
        if (far > tolerance || far < -tolerance) return true;
    }
    return false;
}

template <class T, int N>
stopped_by why_not(const update_settings<T>& settings, const update_input<T, N>& in, const update_memory<T, N>& memory) {
    if (!memory.started) return stopped_by::no_state;
    if (memory.blind) return stopped_by::stale_state;
    if (memory.strayed) return stopped_by::strayed;
    if (!in.enabled) return stopped_by::interlock;
    if (in.dt > settings.max_dt) return stopped_by::late_cycle;
    if (!fresh(in.command_age, settings.command_timeout)) return stopped_by::stale_command;
    if (memory.held) return stopped_by::held;
    return stopped_by::nothing;
}
}  // namespace detail

/// One cycle. The servo starts where the arm is measured, and anew where the joint state comes back to an arm at rest;
/// between these it integrates what it commands. Whatever stops it brings it to rest along its limits; an arm that
/// strayed stays stopped until `enabled` was false. A command that goes on from while it was false counts as none until
/// the controls are released.
template <class T, int N, int M>
void update(const twistarm::chain<T, N, M>& arm, const twistarm::servo_bounds<T, N>& bounds,
            const update_settings<T>& settings, const update_input<T, N>& in, update_memory<T, N>& memory,
            update_output<T>& out) {
    const int n = arm.coordinates();
    const bool seen = detail::fresh(in.state_age, settings.state_timeout) && detail::usable<T, N>(in.theta, n);
    const bool anew = !memory.started || memory.blind || (memory.strayed && !in.enabled);
    if (seen && anew && detail::at_rest(memory.state, n)) {
        const bool held = memory.held;
        memory = update_memory<T, N>{};
        memory.held = held;
        for (int k = 0; k < n; ++k) memory.state.theta[k] = in.theta[k];
        memory.started = true;
    }
    memory.blind = memory.started && !seen;
    memory.strayed = memory.strayed || (memory.started && seen && detail::away(memory.state, in.theta, settings.tolerance, n));
    const bool commanded = detail::fresh(in.command_age, settings.command_timeout) && !detail::released(in.command, n);
    memory.held = commanded && (memory.held || !in.enabled);
    out.reason = detail::why_not(settings, in, memory);
    out.valid = memory.started;
    if (!out.valid) return;
    twistarm::servo_command<T, N> command{};
    if (out.reason == stopped_by::nothing) command = in.command;
    const T dt = in.dt > settings.max_dt ? settings.period : in.dt;
    twistarm::servo_step(arm, bounds, command, dt, memory.state, out.servo);
}
}  // namespace twistarm_controller
