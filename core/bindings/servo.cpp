#include "servo.hpp"

#include <algorithm>
#include <cmath>

namespace bindings {

namespace {

using twistarm::servo_kind;

constexpr std::size_t numbers_of_pose = 24;  // g (16), how it moves (6), linear and angular speed

constexpr double most = 1e6;  // as in control/servo/state.py

bool moderate(const Numbers& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
        if (!(std::fabs(values.data()[k]) <= most)) return false;
    return true;
}

}  // namespace

Servo::Servo(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle C, nb::handle c, nb::handle lower,
             nb::handle upper, nb::handle velocity, nb::handle acceleration, nb::handle unit, nb::handle ready,
             double length, double below, double damping, bool stops)
    : chain_{}, bounds_{} {
    const Numbers S(screws), g(home), A(coupling), motors(C), offset(c), scale(unit), posture(ready);
    require(S.plain() && S.dimensions() == 2 && S.shape(0) == 6, "screws must be float64 (6, m)");
    require(A.plain() && A.dimensions() == 2 && A.shape(0) == S.shape(1), "coupling must be float64 (m, n)");
    require(g.is(4, 4), "home must be float64 (4, 4)");
    n_ = A.shape(1);
    const twistarm::screw_model model{static_cast<int>(S.shape(1)), static_cast<int>(n_), S.data(), g.data(), A.data()};
    require(twistarm::chain_from_screws(model, chain_), "a chain has 1 to 64 coordinates and moving joints");
    require(motors.plain() && motors.dimensions() == 2 && motors.shape(1) == n_, "C must be float64 (k, n)");
    const std::size_t count = motors.shape(0);
    require(count <= twistarm::most_joints && offset.is(count), "c must be float64 (k,), k at most 64");
    require(scale.is(n_) && posture.is(n_), "unit and ready must be float64 (n,)");
    auto& motion = bounds_.motion;
    motion.motors = static_cast<int>(count);
    motion.coordinates = static_cast<int>(n_);
    for (std::size_t r = 0; r < count; ++r)
        for (std::size_t k = 0; k < n_; ++k) motion.C[r][k] = motors.data()[r * n_ + k];
    offset.copy_to(motion.c);
    const nb::handle given[] = {lower, upper, velocity, acceleration};
    double* const limits[] = {motion.lower, motion.upper, motion.velocity, motion.acceleration};
    for (int i = 0; i < 4; ++i) {
        const Numbers values(given[i]);
        require(values.is(count + n_), "each limit must be float64 (k + n,)");
        values.copy_to(limits[i]);
    }
    scale.copy_to(bounds_.unit);
    posture.copy_to(bounds_.ready);
    bounds_.length = length;
    bounds_.below = below;
    bounds_.damping = damping;
    bounds_.stops = stops;
    theta_shape_ = nb::int_(n_);
    six_ = nb::int_(6);
    pose_ = nb::make_tuple(4, 4);
}

bool Servo::read(nb::handle theta, nb::handle theta_dot, nb::handle held, State& state) const {
    const Numbers x(theta), v(theta_dot);
    if (!x.is(n_) || !v.is(n_) || !moderate(x) || !moderate(v)) return false;
    x.copy_to(state.theta);
    v.copy_to(state.theta_dot);
    if (held.is_none()) return true;
    const Numbers g(held);
    if (!g.is(4, 4) || !g.finite()) return false;
    state.held = twistarm::frame_from_rows<double>(g.data());
    return true;
}

bool Servo::read(int kind, unsigned flags, nb::handle numbers, Command& command) const {
    command.kind = static_cast<servo_kind>(kind);
    command.base_axes = (flags & 1U) != 0U;
    for (unsigned k = 0; k < 6; ++k) command.held[k] = (flags >> (k + 1U) & 1U) != 0U;
    if (command.kind == servo_kind::none) return true;
    const Numbers given(numbers);
    if (!given.plain() || !given.finite()) return false;
    switch (command.kind) {
        case servo_kind::jog:
            if (!given.is(n_)) return false;
            given.copy_to(command.rates);
            return true;
        case servo_kind::twist:
            if (!given.is(6)) return false;
            given.copy_to(command.twist);
            return true;
        case servo_kind::pose:
            if (!given.is(numbers_of_pose)) return false;
            command.goal = twistarm::frame_from_rows<double>(given.data());
            for (int k = 0; k < 6; ++k) command.twist[k] = given.data()[16 + k];
            command.linear_speed = given.data()[22];
            command.angular_speed = given.data()[23];
            return true;
        case servo_kind::none: break;
    }
    return false;
}

bool Servo::read(nb::handle near, Near& pairs) const {
    const Numbers given(near);
    if (!given.plain() || given.dimensions() != 2 || given.shape(1) != n_ + 2 || !moderate(given)) return false;
    pairs.count = static_cast<int>(std::min<std::size_t>(given.shape(0), twistarm::most_half_spaces));
    for (int i = 0; i < pairs.count; ++i) {
        const double* const row = given.data() + static_cast<std::size_t>(i) * (n_ + 2);
        std::copy(row, row + n_, pairs.rows[i]);
        pairs.room[i] = row[n_];
        pairs.time[i] = row[n_ + 1];
    }
    return true;
}

// An array that cannot be written to.
nb::object Servo::row(const double* values, std::size_t count) const {
    return frozen(count == 6 ? six_ : theta_shape_, values, count);
}

nb::object Servo::step(nb::handle theta, nb::handle theta_dot, nb::handle held, int kind, unsigned flags,
                       nb::handle numbers, double dt, double period, nb::handle near) const {
    State state{};
    Command command{};
    state.period = period;
    if (!(dt > 0.0) || !std::isfinite(dt) || !(period >= 0.0 && period <= most) || !read(theta, theta_dot, held, state) || !read(kind, flags, numbers, command))
        return nb::none();
    const bool holds = flags > 1U;
    state.holding_base_axes = command.base_axes;
    for (int k = 0; k < 6; ++k) state.holding[k] = !held.is_none() && command.held[k];
    twistarm::servo_output<double> out;
    if (near.is_none()) {
        twistarm::servo_step(chain_, bounds_, command, dt, state, out);
    } else {
        Near pairs;
        require(read(near, pairs), "near must be float64 (k, n + 2)");
        twistarm::servo_step(chain_, bounds_, command, dt, state, out, &pairs);
    }
    nb::object kept = nb::none();
    if (holds) {
        kept = NumPy::get().empty(pose_);
        twistarm::frame_to_rows(state.held, memory(kept));
        make_read_only(kept);
    }
    return nb::make_tuple(row(state.theta, n_), row(state.theta_dot, n_), kept, static_cast<int>(out.cause), out.row,
                          out.scale, row(out.lost, 6), out.lost_share, out.halted, out.remaining[0], out.remaining[1], state.period);
}

}  // namespace bindings
