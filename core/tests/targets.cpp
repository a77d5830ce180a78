// Targets: how far a pose misses them, and the slope of what a search makes vanish, both by the definitions.
#include "twistarm/ik/target.hpp"

#include "arms.hpp"
#include "twistarm/ik/residual.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::matrix;
using tests::real;

namespace {
constexpr double weight = 0.2;  // of a squared radian beside a squared metre, as in a search
constexpr real step = 1e-5L;

/// Near the half turn R − Rᵀ fades, and squared errors of rotations [rad²] with it; a search is far from its end there.
constexpr double near_half_turn = 1e-6;

void draw_unit(tests::generator& random, double v[3]) {
    for (int k = 0; k < 3; ++k) v[k] = random.between(-1, 1);
    const double size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; ++k) v[k] /= size;
}

matrix drawn_pose(tests::generator& random) {
    double xi[6];
    for (double& component : xi) component = random.between(-2, 2);
    return tests::exponential(xi, 1);
}

/// The goal turned by φ u in its own axes and moved by d in the base's.
matrix displaced(const matrix& goal, const double phi[3], const double d[3]) {
    matrix g = goal * tests::rotation(phi);
    for (int k = 0; k < 3; ++k) g.a[k][3] += d[k];
    return g;
}

/// A goal, and a pose turned from it by a known angle about a known axis and moved by a known offset.
template <class T> struct displacement {
    double angle, u[3], phi[3], d[3];
    matrix goal, g;
    frame<T> asked, there;

    displacement(tests::generator& random, double by) : angle(by), goal(drawn_pose(random)) {
        draw_unit(random, u);
        for (int k = 0; k < 3; ++k) {
            phi[k] = angle * u[k];
            d[k] = random.between(-0.5, 0.5);
        }
        g = displaced(goal, phi, d);
        asked = tests::to_frame<T>(goal);
        there = tests::to_frame<T>(g);
    }
    double distance() const { return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]); }
};

template <class T> void check_errors(const target_errors<T>& found, double position, double angle, double enough) {
    CHECK(std::fabs(static_cast<double>(found.position) - position) < enough, "%g, expected %g",
          static_cast<double>(found.position), position);
    CHECK(std::fabs(static_cast<double>(found.orientation) - angle) < enough, "%g, expected %g",
          static_cast<double>(found.orientation), angle);
}

/// A tool axis across the turn points `angle` away from where it pointed in the goal.
template <class T> void test_approach(const displacement<T>& moved, tests::generator& random, double enough) {
    double any[3], axis[3];
    draw_unit(random, any);
    cross(moved.u, any, axis);
    const double size = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    for (double& component : axis) component /= size;
    real pointed[3];
    tests::turn(moved.goal, axis, pointed);
    T direction[3], tool_axis[3];
    for (int k = 0; k < 3; ++k) {
        direction[k] = static_cast<T>(pointed[k]);
        tool_axis[k] = static_cast<T>(axis[k]);
    }
    const auto asked = approach_target(moved.asked.p, direction, tool_axis);
    check_errors(errors_at(asked, moved.there), moved.distance(), moved.angle, enough);
}

/// Only what lies beyond each tolerance counts, along the goal's axes or the base's; from π on a rotation is free.
template <class T> void test_task(const displacement<T>& moved, tests::generator& random, double enough) {
    T tolerance[6], written[6];
    for (int k = 0; k < 6; ++k) {
        const bool free = random.uniform() < 0.3;
        tolerance[k] = static_cast<T>(free ? INFINITY : (random.uniform() < 0.4 ? 0 : 0.2));
        written[k] = free && k >= 3 ? T(3.2) : tolerance[k];
    }
    real d[3], phi[3];
    tests::turn(tests::inverse(moved.goal), moved.d, d);
    for (int k = 0; k < 3; ++k) phi[k] = moved.phi[k];
    check_errors(errors_at(task_target(moved.asked, written, false), moved.there),
                 static_cast<double>(tests::beyond(d, tolerance)),
                 static_cast<double>(tests::beyond(phi, tolerance + 3)), enough);
    for (int k = 0; k < 3; ++k) d[k] = moved.d[k];
    tests::turn(moved.goal, moved.phi, phi);
    check_errors(errors_at(task_target(moved.asked, written, true), moved.there),
                 static_cast<double>(tests::beyond(d, tolerance)),
                 static_cast<double>(tests::beyond(phi, tolerance + 3)), enough);
}

template <class T> void test_errors(double enough) {
    tests::generator random;
    const double angles[] = {0, 1e-9, 1e-5, 0.3, 1.04, 1.05, 2.0, 2.59, 2.61, 3.1, 3.14159265};
    for (int repeat = 0; repeat < 40; ++repeat)
        for (const double angle : angles) {
            const displacement<T> moved(random, angle);
            check_errors(errors_at(pose_target(moved.asked), moved.there), moved.distance(), angle, enough);
            check_errors(errors_at(position_target(moved.asked.p), moved.there), moved.distance(), 0, enough);
            test_approach(moved, random, enough);
            test_task(moved, random, enough);
        }
}

/// Half a turn exactly: the angle is π, whatever axis is told.
void test_half_turns() {
    for (int k = 0; k < 3; ++k) {
        double phi[3] = {}, nothing[3] = {};
        phi[k] = 3.14159265358979323846;
        const auto g = tests::to_frame<double>(displaced(tests::identity(), phi, nothing));
        const auto off = errors_at(pose_target(identity_frame<double>()), g);
        CHECK(std::fabs(off.orientation - phi[k]) < 1e-14, "%.17g", off.orientation);
    }
}

/// What a search minimises: ½ (distance² + w · 8 (1 − cos φ/2)), for a task half the squared excess.
real objective(const target<double>& asked, const matrix& g) {
    const tests::misses off = tests::missed(asked, g);
    const real turned = asked.kind == target_kind::task ? off.orientation * off.orientation
                                                        : 8 * (1 - std::cos(off.orientation / 2));
    return (off.position * off.position + weight * turned) / 2;
}

target<double> drawn_target(target_kind kind, tests::generator& random) {
    const auto goal = tests::to_frame<double>(drawn_pose(random));
    if (kind == target_kind::pose) return pose_target(goal);
    if (kind == target_kind::position) return position_target(goal.p);
    double axis[3], direction[3], tolerance[6];
    draw_unit(random, axis);
    draw_unit(random, direction);
    if (kind == target_kind::approach) return approach_target(goal.p, direction, axis);
    for (double& each : tolerance) each = random.uniform() < 0.3 ? 0 : (random.uniform() < 0.5 ? 0.1 : INFINITY);
    return task_target(goal, tolerance, random.uniform() < 0.5);
}

/// Jᵀ e against central differences of the objective, and the squared errors against those of the definitions.
template <target_kind Kind, int N> void test_slope(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    if (!fits<N, N>(general)) return;
    const auto arm = narrowed<double, N, N>(general);
    using V = pack<double, 8>;
    V theta[capacity(N)] = {};
    for (int k = 0; k < source.coordinates; ++k)
        for (int l = 0; l < 8; ++l) theta[k].set(l, random.between(-3, 3));
    const auto asked = drawn_target(Kind, random);
    const auto aims = aim_in_every_lane<V>(aim_at(arm, asked));
    frame<V> g;
    column<V> columns[capacity(N)];
    residual<V, N, rows_of(Kind)> at;
    walk_with_columns(arm, aims.base, aims.tip, theta, g, columns);
    residual_of<Kind, N>(g, columns, source.coordinates, aims, std::sqrt(weight), at);
    for (int l = 0; l < 8; ++l) {
        real there[most_joints];
        for (int k = 0; k < source.coordinates; ++k) there[k] = theta[k][l];
        const tests::misses off = tests::missed(asked, source.fk(there));
        const real turned = Kind == target_kind::task ? off.orientation : 2 * std::sin(off.orientation / 2);
        const double farther = static_cast<double>(at.position_squared[l] - off.position * off.position);
        CHECK(std::fabs(farther) < 1e-12, "lane %d: %g", l, farther);
        const tests::misses whole = tests::missed(pose_target(asked.goal), source.fk(there));
        const real angle = Kind == target_kind::task ? whole.orientation : off.orientation;
        const double apart = static_cast<double>(std::fabs(at.rotation_squared[l] - turned * turned));
        CHECK(apart < (angle < 2.6L ? 1e-12 : near_half_turn), "kind %d, angle %g: %g", static_cast<int>(Kind),
              static_cast<double>(angle), apart);
        if (angle > 3.1L) continue;  // differences would straddle the half turn
        for (int k = 0; k < source.coordinates; ++k) {
            double slope = 0;
            for (int r = 0; r < rows_of(Kind); ++r) slope += at.J[k][r][l] * at.e[r][l];
            there[k] += step;
            const real ahead = objective(asked, source.fk(there));
            there[k] -= 2 * step;
            const real behind = objective(asked, source.fk(there));
            there[k] += step;
            const double expected = static_cast<double>((ahead - behind) / (2 * step));
            CHECK(std::fabs(slope - expected) < 2e-8, "kind %d, n = %d, coordinate %d: %g, expected %g",
                  static_cast<int>(Kind), source.coordinates, k, slope, expected);
        }
    }
}

template <int N> void test_slopes(int n, tests::wiring wired) {
    tests::generator random;
    for (int i = 0; i < 10; ++i) {
        const drawn_arm arm(random, n, wired);
        test_slope<target_kind::pose, N>(arm, random);
        test_slope<target_kind::position, N>(arm, random);
        test_slope<target_kind::approach, N>(arm, random);
        test_slope<target_kind::task, N>(arm, random);
    }
}

/// Near the half turn the chord keeps its length, 2 sin(φ/2), and its axis up to the sign.
void test_chords_near_half_turns() {
    tests::generator random;
    for (const double short_of : {1e-2, 1e-3, 1.1e-3, 1e-6, 1e-9, 0.0}) {
        double u[3], phi[3];
        draw_unit(random, u);
        for (int k = 0; k < 3; ++k) phi[k] = (3.14159265358979323846 - short_of) * u[k];
        const auto R = tests::to_frame<double>(tests::rotation(phi));
        double chord[3];
        detail::chord_of(R, chord);
        const double size = 2 * std::sin(0.5 * (3.14159265358979323846 - short_of));
        const double side = dot(chord, u) < 0 ? -1 : 1;
        for (int k = 0; k < 3; ++k)
            CHECK(std::fabs(side * chord[k] - size * u[k]) < 1e-9, "%g short of a half turn", short_of);
        if (short_of > 1e-7) CHECK(side == 1, "%g short of a half turn the side is known", short_of);
    }
}
}  // namespace

int main() {
    test_errors<double>(2e-12);
    test_errors<float>(2e-3);
    test_half_turns();
    test_slopes<dynamic>(4, tests::wiring::plain);
    test_slopes<6>(6, tests::wiring::plain);
    test_slopes<dynamic>(5, tests::wiring::followers);
    test_chords_near_half_turns();
    return tests::verdict("targets");
}
