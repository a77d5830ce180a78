// The servo: drives at random through singularities and into limits, rest and the way back. What it does with a command
// Python's tests hold to the law as it is written down.
#include "driven_arm.hpp"

using namespace twistarm;
using tests::driven_arm;
using tests::drawn_command;
using tests::hold;
using tests::reversed;
using tests::wiring;

namespace {
/// Some time under one command; the largest rate on the way.
template <class T, int N, int M>
double drive(driven_arm<T, N, M>& driven, const servo_command<T, N>& command, T dt) {
    double fastest = 0;
    for (int i = 0; i < 100; ++i) {
        driven.step(command, dt);
        fastest = std::fmax(fastest, driven.speed());
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
        // A posture beside a singular one needs so much for a unit of twist.
        CHECK(driven.speed() < 300 * size, "n = %d: moves at %g for %g", driven.n, driven.speed(), size);
    }
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
    return tests::verdict("servo");
}
