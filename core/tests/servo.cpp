// The servo: drives at random through singularities and into limits, what it says of the tool's motion against plain
// forward kinematics, rest, held orientation, and the way back.
#include "driven_arm.hpp"

using namespace twistarm;
using tests::driven_arm;
using tests::drawn_command;
using tests::drawn_twist;
using tests::hold;
using tests::holds;
using tests::precise;
using tests::real;
using tests::reversed;
using tests::rounding;
using tests::wiring;

namespace {
int judged = 0, moved = 0;

/// At an even speed the tool moves by scale · (asked − lost). Off singularities six joints lose nothing, and three
/// nothing of the linear part, but for the tip of its norm, which is rounded off.
template <class T, int N, int M>
void check_tool(const driven_arm<T, N, M>& driven, const T* from, const servo_command<T, N>& command, T dt) {
    ++moved;
    const double sigma = driven.least_singular_value();
    if (sigma < 0.1 || !driven.is_even()) return;
    real did[6];
    tests::tool_motion(driven.source, from, driven.state.theta, command, static_cast<double>(dt), did);
    double off = 0, asked = 0, lost[6];
    for (int k = 0; k < 6; ++k) {
        const double length = k < 3 ? static_cast<double>(driven.bounds.length) : 1;
        const auto said = static_cast<double>(driven.out.scale * (command.twist[k] - driven.out.lost[k]));
        off = std::fmax(off, std::fabs(static_cast<double>(did[k]) - said) / length);
        asked = std::fmax(asked, static_cast<double>(std::fabs(command.twist[k])) / length);
        lost[k] = static_cast<double>(std::fabs(driven.out.lost[k])) / length;
    }
    ++judged;
    const double slack = (precise<T> ? 1e-9 : 3e-5) / static_cast<double>(dt);
    CHECK(off <= 1e-3 * asked + slack, "n = %d: the tool is off by %g of %g, σ = %g, cause %d, scale %g", driven.n, off,
          asked, sigma, static_cast<int>(driven.out.cause), static_cast<double>(driven.out.scale));
    if (driven.out.cause == servo_cause::lower || driven.out.cause == servo_cause::upper || driven.n < 3) return;
    if (driven.n < 6 && driven.least_singular_value(0, 3) < 0.3) return;
    const double most = (precise<T> ? 3e-4 : 3e-3) * asked;
    for (int k = 0; k < (driven.n < 6 ? 3 : 6); ++k)
        CHECK(lost[k] <= most, "n = %d, component %d: %g of %g lost", driven.n, k, lost[k], asked);
}

/// Some time under one command; the largest rate on the way.
template <class T, int N, int M>
double drive(driven_arm<T, N, M>& driven, const servo_command<T, N>& command, T dt) {
    double fastest = 0;
    for (int i = 0; i < 100; ++i) {
        T from[capacity(N)];
        for (int k = 0; k < driven.n; ++k) from[k] = driven.state.theta[k];
        driven.step(command, dt);
        fastest = std::fmax(fastest, driven.speed());
        if (i % 7 == 0 && command.kind == servo_kind::twist && !holds(command)) check_tool(driven, from, command, dt);
    }
    return fastest;
}

/// Drives on, then the other way; between rests that must not be shut where there was a way on.
template <class T, int N, int M> void test_drive(tests::generator& random, driven_arm<T, N, M>& driven) {
    const T dt = static_cast<T>(random.uniform() < 0.5 ? 0.01 : 0.004);
    for (int leg = 0; leg < 6; ++leg) {
        const servo_command<T, N> command = drawn_command(random, driven);
        const bool from_rest = leg % 2 == 0;
        if (from_rest) driven.come_to_rest();
        const double on = drive(driven, command, dt);
        if (from_rest) driven.come_to_rest();
        const double back = drive(driven, reversed(command), dt);
        if (from_rest && command.kind != servo_kind::pose && !driven.stands_at_a_motors_limit())
            CHECK(on < 0.02 || back > 1e-3, "n = %d, kind %d: on at %g, back at %g", driven.n,
                  static_cast<int>(command.kind), on, back);
    }
}

/// Without a command to rest; then commands of nothing move nothing, to the last bit.
template <class T, int N, int M> void test_rest(driven_arm<T, N, M>& driven) {
    driven.come_to_rest();
    servo_command<T, N> nothing{};
    nothing.goal = forward(driven.arm, driven.state.theta);
    nothing.linear_speed = nothing.angular_speed = T(1);
    const auto start = driven.state;
    for (const servo_kind kind : {servo_kind::twist, servo_kind::jog, servo_kind::pose, servo_kind::twist}) {
        nothing.kind = kind;
        for (int i = 0; i < 10; ++i) driven.step(nothing, T(0.01));
        for (int k = 0; k < driven.n; ++k)
            CHECK(driven.state.theta[k] == start.theta[k], "n = %d, kind %d: joint %d moved", driven.n,
                  static_cast<int>(kind), k);
        hold(nothing, 3, 6);
        nothing.base_axes = !nothing.base_axes;
    }
    for (const double size : {1e-300, 1e-40, 1e-30, 1e-20, 1e-10, 1e-5}) {  // squares of some are 0, in float of most
        nothing.twist[0] = static_cast<T>(size);
        driven.step(nothing, T(0.01));
        CHECK(driven.speed() < 100 * size, "n = %d: moves at %g for %g", driven.n, driven.speed(), size);
    }
}

/// Limits of nothing but the rates.
template <class T, int N> void take_limits_off(motion_limits<T, N>& limits, double velocity, double acceleration) {
    for (int r = 0; r < limits.rows(); ++r) {
        limits.lower[r] = T(-tests::far);
        limits.upper[r] = T(tests::far);
        limits.velocity[r] = static_cast<T>(velocity);
        limits.acceleration[r] = static_cast<T>(acceleration);
    }
}

/// Straight pushes of up to 0.1 m/s along each axis with held orientation: it stays, as long as no singularity is near,
/// and comes back where it was turned away.
void test_held_orientation(tests::generator& random) {
    int whole = 0;
    for (int i = 0; i < 24; ++i) {
        driven_arm<double, dynamic, dynamic> driven(random, 5 + i % 3, wiring::plain, 0);
        take_limits_off(driven.bounds.motion, 2, 10);
        servo_command<double, dynamic> push = drawn_twist<double, dynamic>(random);
        hold(push, 3, 6);
        for (int k = 0; k < 3; ++k) push.twist[k] /= 3;
        const tests::matrix back = tests::inverse(driven.source.fk(driven.state.theta));
        int steps = 0;
        for (; steps < 100 && driven.least_singular_value() > 0.08 && driven.least_singular_value(3, 3) > 0.3; ++steps) {
            driven.step(push, 0.01);
            real phi[3];
            tests::logarithm(driven.source.fk(driven.state.theta) * back, phi);
            const auto turned = static_cast<double>(tests::norm(phi));
            const bool comes_back = steps >= 20 && steps < 60;
            CHECK(turned < 1e-5 || comes_back, "n = %d: turned by %g rad after %d steps", driven.n, turned, steps);
            if (steps == 19) driven.state.theta[driven.n - 1] += 1e-3;
        }
        whole += steps == 100 ? 1 : 0;
    }
    CHECK(whole >= 8, "%d of 24 pushes to the end", whole);
}

/// A planar arm that is stretched out: it bends at once when pulled back, and stretches without a jerk. Where its tool
/// must not turn on the way, that goes before the way, and bending takes four times as long.
template <class T> void test_way_out(bool held) {
    tests::generator random;
    driven_arm<T, dynamic, dynamic> driven(random, 3, wiring::plain, 0);
    const double screws[18] = {0, 0, 0, 0, -0.5, -0.9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1};
    const double home[16] = {1, 0, 0, 1.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    chain<double, dynamic, dynamic> planar{};
    CHECK(chain_from_screws({3, 3, screws, home, nullptr}, planar), "three joints");
    driven.arm = narrowed<T, dynamic, dynamic>(planar);
    take_limits_off(driven.bounds.motion, 3, 30);
    for (int k = 0; k < 3; ++k) {
        driven.bounds.unit[k] = T(1);
        driven.bounds.ready[k] = T(k == 1 ? 1 : 0);
    }
    servo_command<T, dynamic> pull{};
    pull.kind = servo_kind::twist;
    pull.base_axes = true;
    if (held) hold(pull, 3, 6);
    const auto push = [&](double speed, int steps) {
        pull.twist[0] = static_cast<T>(speed);
        for (int i = 0; i < steps; ++i) driven.step(pull, T(0.01));
        return static_cast<double>(forward(driven.arm, driven.state.theta).p[0]);
    };
    const int second = held ? 400 : 100;
    const double out = push(-0.1, second);
    CHECK(out < 1.05, "pulled for %d steps to x = %g", second, out);
    const double stretched = push(0.1, 1000);
    CHECK(stretched > 1.09 && driven.speed() < 2e-2, "stretched to x = %g, at %g rad/s", stretched, driven.speed());
    const double again = push(-0.1, second);
    CHECK(again < 1.05, "pulled again for %d steps to x = %g", second, again);
}

/// Rounding that seems to push a joint over the limit at which it stands is no reason to stop it, nor to say so: off
/// singularities the rates are those asked for, but for the little that the law's damping may take.
template <class T> void test_beside_a_limit(tests::generator& random) {
    int told = 0;
    for (int i = 0; i < 100; ++i) {
        driven_arm<T, dynamic, dynamic> driven(random, 6, wiring::plain, 0);
        const int stands = i % 6;
        take_limits_off(driven.bounds.motion, tests::far, tests::far);
        driven.bounds.motion.upper[stands] = T(0);
        if (driven.least_singular_value() < 0.1) continue;
        servo_command<T, dynamic> command{};
        command.kind = servo_kind::twist;
        column<T> J[most_joints];
        forward_with_body_jacobian(driven.arm, driven.state.theta, J);
        T rates[most_joints];
        for (int k = 0; k < 6; ++k) {
            rates[k] = k == stands ? T(0) : static_cast<T>(random.between(-0.5, 0.5));
            for (int r = 0; r < 3; ++r) {
                command.twist[r] += J[k].v[r] * rates[k];
                command.twist[r + 3] += J[k].w[r] * rates[k];
            }
        }
        driven.step(command, T(0.01));
        ++told;
        CHECK(driven.out.cause == servo_cause::none, "arm %d: cause %d", i, static_cast<int>(driven.out.cause));
        for (int k = 0; k < 6; ++k)
            CHECK(std::fabs(static_cast<double>(driven.state.theta_dot[k] - rates[k])) < 5e-3,
                  "arm %d: joint %d at %g, not %g", i, k, static_cast<double>(driven.state.theta_dot[k]),
                  static_cast<double>(rates[k]));
    }
    CHECK(told > 20, "%d arms", told);
}

/// The lines that servo.hpp begins with.
void test_usage(tests::generator& random) {
    const driven_arm<double, 6, 6> driven(random, 6, wiring::plain, 0);
    const auto& arm = driven.arm;
    const auto& bounds = driven.bounds;
    const double measured[6] = {};
    const auto send = [&](const double* theta, const double* theta_dot) {
        for (int k = 0; k < 6; ++k) CHECK(std::fabs(theta[k] - 0.01 * theta_dot[k]) < 1e-15, "joint %d", k);
        CHECK(servo_detail::norm(theta_dot, 6) > 0, "nothing moves");
    };
    twistarm::servo_state<double, 6> state{};  // at rest, where the arm was measured to be
    for (int k = 0; k < 6; ++k) state.theta[k] = measured[k];
    twistarm::servo_command<double, 6> command{};
    command.kind = twistarm::servo_kind::twist;
    command.twist[0] = 0.05;                                     // m/s along the tool's x
    command.held[3] = command.held[4] = command.held[5] = true;  // as it is turned now
    twistarm::servo_output<double> out;
    twistarm::servo_step(arm, bounds, command, 0.01, state, out);  // every 10 ms
    send(state.theta, state.theta_dot);
}

template <class T, int N, int M> void test_arms(tests::generator& random, int n, wiring wired, int motors, int count) {
    for (int i = 0; i < count; ++i) {
        driven_arm<T, N, M> driven(random, n, wired, motors);
        test_drive(random, driven);
        test_rest(driven);
    }
}
}  // namespace

int main() {
    tests::generator random;
    for (int n = 1; n <= 8; ++n) {
        test_arms<double, dynamic, dynamic>(random, n, n % 2 == 0 ? wiring::differential : wiring::plain, n % 3, 3);
        test_arms<float, dynamic, dynamic>(random, n, n % 3 == 0 ? wiring::followers : wiring::plain, n % 2, 3);
    }
    test_arms<double, dynamic, dynamic>(random, most_joints, wiring::plain, 4, 1);
    test_arms<float, 4, 6>(random, 4, wiring::followers, 1, 4);
    CHECK(3 * judged > moved, "the tool was judged in %d of %d steps", judged, moved);
    test_held_orientation(random);
    test_usage(random);
    for (const bool held : {false, true}) {
        test_way_out<double>(held);
        test_way_out<float>(held);
    }
    test_beside_a_limit<double>(random);
    test_beside_a_limit<float>(random);
    return tests::verdict("servo");
}
