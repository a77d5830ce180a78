#include "servo.hpp"

#include <algorithm>
#include <cmath>

namespace bindings {

namespace {

constexpr double most = 1e6;  // as in control/servo/state.py

bool moderate(const Numbers& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
        if (!(std::fabs(values.data()[k]) <= most)) return false;
    return true;
}

}  // namespace

Servo::Servo(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle C, nb::handle c, nb::handle lower,
             nb::handle upper, nb::handle velocity, nb::handle acceleration, nb::handle unit, nb::handle ready,
             double length, double below, double damping, bool stops) {
    const Numbers S(screws), g(home), A(coupling), motors(C), offset(c), scale(unit), posture(ready);
    require(S.plain() && S.dimensions() == 2 && S.shape(0) == 6, "screws must be float64 (6, m)");
    require(A.plain() && A.dimensions() == 2 && A.shape(0) == S.shape(1), "coupling must be float64 (m, n)");
    require(g.is(4, 4), "home must be float64 (4, 4)");
    n_ = A.shape(1);
    require(motors.plain() && motors.dimensions() == 2 && motors.shape(1) == n_, "C must be float64 (k, n)");
    const std::size_t count = motors.shape(0);
    require(count <= twistarm::most_joints && offset.is(count), "c must be float64 (k,), k at most 64");
    require(scale.is(n_) && posture.is(n_), "unit and ready must be float64 (n,)");
    const Numbers limits[] = {Numbers(lower), Numbers(upper), Numbers(velocity), Numbers(acceleration)};
    for (const Numbers& values : limits) require(values.is(count + n_), "each limit must be float64 (k + n,)");
    require(servo_.read({static_cast<int>(S.shape(1)), static_cast<int>(n_), static_cast<int>(count), S.data(), g.data(),
                         A.data(), motors.data(), offset.data(),
                         {limits[0].data(), limits[1].data(), limits[2].data(), limits[3].data()}, scale.data(),
                         posture.data(), length, below, damping, stops}),
            "a chain has 1 to 64 coordinates and moving joints");
    theta_shape_ = nb::int_(n_);
    six_ = nb::int_(6);
    pose_ = nb::make_tuple(4, 4);
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
    const Numbers x(theta), v(theta_dot), held_pose(held), given(numbers);
    const auto of = static_cast<twistarm::servo_kind>(kind);
    const bool holds = flags > 1U, holding = !held.is_none(), commanded = of != twistarm::servo_kind::none;
    if (!(dt > 0.0) || !std::isfinite(dt) || !(period >= 0.0 && period <= most)) return nb::none();
    if (!x.is(n_) || !v.is(n_) || !moderate(x) || !moderate(v)) return nb::none();
    if (holding && !(held_pose.is(4, 4) && held_pose.finite())) return nb::none();
    if (commanded && !(given.is(static_cast<std::size_t>(servo_.width(of))) && given.finite())) return nb::none();
    const ServoCommand command = servo_.command(of, flags, commanded ? given.data() : nullptr);
    ServoState state = servo_.state(command, x.data(), v.data(), holding ? held_pose.data() : nullptr, period);
    twistarm::servo_output<double> out;
    Near pairs;
    if (!near.is_none()) require(read(near, pairs), "near must be float64 (k, n + 2)");
    twistarm::servo_step(servo_.chain, servo_.bounds, command, dt, state, out, near.is_none() ? nullptr : &pairs);
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
