// Every configuration by a closed form: polynomials with roots that were put in, and arms of each family whose
// configurations, drawn at random, singular or stretched, have to be among those that are found.
#include "twistarm/closed_form/all_solutions.hpp"

#include "arms.hpp"

using namespace twistarm;
using tests::real;

namespace {
template <class T> constexpr double exact = sizeof(T) == 8 ? 1e-9 : 2e-4;

// -- polynomials -----------------------------------------------------------------------------------------------------

/// Roots of (t - a)(t - b)((t - re)² + im²), each to be found so well.
template <class T> void test_quartic(double a, double b, double re, double im, double tolerance) {
    const double pair[3] = {re * re + im * im, -2 * re, 1}, both[3] = {a * b, -a - b, 1};
    T p[5] = {};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) p[i + k] += static_cast<T>(3 * pair[i] * both[k]);
    closed_form::complex_number<T> t[4];
    closed_form::quartic_roots(p, t);
    const double wanted[4][2] = {{a, 0}, {b, 0}, {re, im}, {re, -im}};
    for (const auto& root : wanted) {
        double nearest = 1e9;
        for (const auto& each : t)
            nearest = std::fmin(nearest, std::hypot(static_cast<double>(each.re) - root[0], static_cast<double>(each.im) - root[1]));
        CHECK(nearest <= tolerance, "(%g, %g) of %g, %g, %g ± %g i is missed by %g", root[0], root[1], a, b, re, im, nearest);
    }
}

template <class T> void test_quartics(tests::generator& random) {
    const bool fine = sizeof(T) == 8;
    for (int repeat = 0; repeat < 200; ++repeat)
        test_quartic<T>(random.between(-2, -1), random.between(1, 2), random.between(-0.5, 0.5), random.between(0.5, 2),
                        fine ? 1e-11 : 2e-3);
    test_quartic<T>(1, 1, -0.5, 0.7, fine ? 1e-6 : 5e-3);  // a double root keeps half of the digits
    test_quartic<T>(1, 1, 1, 0, fine ? 1e-3 : 5e-2);       // a fourfold one a quarter
    test_quartic<T>(0, 0, 0, 1, fine ? 1e-6 : 5e-3);
}

/// An equation with the angle x among its zeros, or touching zero there.
template <class T> void test_second_harmonic(tests::generator& random, bool touches) {
    closed_form::second_harmonic<T> equation{};
    const double x = random.between(-3, 3), c = std::cos(x), s = std::sin(x);
    for (T& each : equation.k) each = static_cast<T>(random.between(-1, 1));
    if (touches) {  // 1 - cos(y - x), times itself and a bit
        const T numbers[6] = {T(1), static_cast<T>(-2 * c), static_cast<T>(-2 * s), static_cast<T>(c * c), static_cast<T>(2 * c * s), static_cast<T>(s * s)};
        for (int i = 0; i < 6; ++i) equation.k[i] = numbers[i];
    }
    equation.k[0] -= equation.at(static_cast<T>(c), static_cast<T>(s));
    double nearest = 1e9;
    for (const auto& each : equation.zeros(closed_form::default_slack<T>))
        nearest = std::fmin(nearest, std::hypot(static_cast<double>(each.cosine) - c, static_cast<double>(each.sine) - s));
    CHECK(nearest <= (touches ? 0.1 : (sizeof(T) == 8 ? 1e-8 : 2e-2)), "%g is missed by %g", x, nearest);
}

// -- arms ------------------------------------------------------------------------------------------------------------

enum class kind_of_arm { wrist, parallel, scara };

/// An arm of six joints, or of four (scara), that belongs to a family.
struct family_arm : tests::drawn_arm {
    fitted_family<double> family{};
    closed_form::joint_axis<double> lines[6];

    family_arm(tests::generator& random, kind_of_arm kind)
        : drawn_arm(random, kind == kind_of_arm::scara ? 4 : 6, tests::wiring::plain) {
        for (int i = 0; i < joints; ++i) draw(random, i, false);
        family.count = joints;
        family.first = kind == kind_of_arm::parallel ? 1 : 3;
        family.last = family.first + 3;
        family.keeps = closed_form::keeps::point;
        if (kind == kind_of_arm::scara) make_scara(random);
        else if (kind == kind_of_arm::parallel) make_parallel(family.first);
        else make_meeting(family.first);
        for (int i = 0; i < joints; ++i) {
            write(i);
            family.axes[i] = lines[i];
        }
    }

    template <class T, int N> solved_arm<T, N> solved() const {
        solved_arm<T, N> all{};
        all.family.count = family.count;
        all.family.first = family.first;
        all.family.last = family.last;
        all.family.keeps = family.keeps;
        all.family.kept = {family.kept.plane, {}, T(0)};
        for (int k = 0; k < 3; ++k) all.family.kept.v[k] = static_cast<T>(family.kept.v[k]);
        for (int i = 0; i < joints; ++i) {
            all.rate[i] = T(1);
            closed_form::joint_axis<T> line{{}, {}, lines[i].slides};
            for (int k = 0; k < 3; ++k) {
                line.w[k] = static_cast<T>(lines[i].w[k]);
                line.o[k] = static_cast<T>(lines[i].o[k]);
            }
            all.joint[i] = i;
            all.family.axes[i] = line;
        }
        all.home = frame_from_rows<T>(home);
        return all;
    }

private:
    void draw(tests::generator& random, int i, bool slides) {
        double size = 0;
        while (size < 0.1) {
            for (double& each : lines[i].w) each = random.between(-1, 1);
            size = std::sqrt(dot(lines[i].w, lines[i].w));
        }
        for (int k = 0; k < 3; ++k) {
            lines[i].w[k] /= size;
            lines[i].o[k] = random.between(-0.5, 0.5);
        }
        lines[i].slides = slides;
    }
    void make_meeting(int first) {
        for (int k = 0; k < 3; ++k) {
            lines[first + 1].o[k] = lines[first + 2].o[k] = lines[first].o[k];
            family.kept.v[k] = lines[first].o[k];
        }
    }
    void make_parallel(int first) {
        family.keeps = closed_form::keeps::plane;
        family.kept.plane = true;
        for (int k = 0; k < 3; ++k) {
            lines[first + 1].w[k] = lines[first].w[k];
            lines[first + 2].w[k] = -lines[first].w[k];
            family.kept.v[k] = lines[first].w[k];
        }
    }
    /// Three parallel axes, and a slide in another direction behind them.
    void make_scara(tests::generator& random) {
        family.first = 0;
        family.last = 3;
        make_parallel(0);
        draw(random, 3, true);
    }
    void write(int i) {
        double moment[3];
        cross(lines[i].o, lines[i].w, moment);
        for (int k = 0; k < 3; ++k) {
            twists[i][k] = lines[i].slides ? lines[i].w[k] : moment[k];
            twists[i][k + 3] = lines[i].slides ? 0 : lines[i].w[k];
        }
        for (int k = 0; k < 6; ++k) screws[k * joints + i] = twists[i][k];
    }
};

/// The largest element of plain forward kinematics at θ less the pose.
template <class T> double missed(const family_arm& source, const T* theta, const tests::matrix& g) {
    const tests::matrix there = source.fk(theta);
    double worst = 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 4; ++k) worst = std::fmax(worst, static_cast<double>(std::fabs(there.a[i][k] - g.a[i][k])));
    return worst;
}

template <class T, int N> struct tried {
    chain<T, N, N> arm;
    ranges<T, N> range;
    solved_arm<T, N> solved;

    explicit tried(const family_arm& source) : arm{}, solved(source.solved<T, N>()) {
        chain<double, dynamic, dynamic> general{};
        CHECK(chain_from_screws(source.model(), general), "arm");
        arm = narrowed<T, N, N>(general);
        double lower[most_joints], upper[most_joints];
        for (int k = 0; k < source.joints; ++k) {
            lower[k] = -4;
            upper[k] = 4;
        }
        range = ranges_of(arm, lower, upper, lower, upper);
    }

    configurations<T, N> all(const frame<T>& g, const T* near) const {
        configurations<T, N> found;
        const T none_held = T(0);
        const T tolerance = static_cast<T>(exact<T>);
        find_all(arm, solved, range, pose_target(g), near, &none_held, tolerance, tolerance, found);
        return found;
    }
};

template <class T, int N> void test_configuration(const family_arm& source, const tried<T, N>& solver, const T* theta) {
    const int n = source.joints;
    const tests::matrix g = source.fk(theta);
    T near[most_joints] = {};
    const configurations<T, N> found = solver.all(tests::to_frame<T>(g), near);
    bool known = false;
    for (int i = 0; i < found.count; ++i) {
        const configuration<T, N>& one = found.found[i];
        const double off = missed(source, one.theta, g);
        CHECK(off <= 3 * exact<T>, "configuration %d of %d misses by %g", i, found.count, off);
        CHECK(i == 0 || !one.inside || one.distance >= found.found[i - 1].distance, "%d is nearer than the one before", i);
        CHECK(one.inside == (i < found.inside), "those inside stand first");
        double apart = 0;
        for (int k = 0; k < n; ++k) {
            const double away = static_cast<double>(one.theta[k] - theta[k]);
            const double turns = source.lines[k].slides ? 0 : std::nearbyint(away / whole_turn);
            apart = std::fmax(apart, std::fabs(away - turns * whole_turn));
            CHECK(!one.inside || std::fabs(static_cast<double>(one.theta[k])) <= 4, "outside the limits");
        }
        known = known || one.free != 0 || apart < (sizeof(T) == 8 ? 1e-4 : 5e-2);
        for (int other = 0; other < i; ++other) {
            double between = 0;
            T halfway[most_joints];
            for (int k = 0; k < n; ++k) {
                halfway[k] = T(0.5) * (one.theta[k] + found.found[other].theta[k]);
                between = std::fmax(between, std::fabs(static_cast<double>(one.theta[k] - found.found[other].theta[k])));
            }
            CHECK(between > 9e-3 || missed(source, halfway, g) > 0.5 * exact<T>, "%d and %d are one", other, i);
        }
    }
    CHECK(known, "what made the target is not among %d (%g %g %g %g %g %g)", found.count, static_cast<double>(theta[0]),
          static_cast<double>(theta[1]), static_cast<double>(theta[2]), static_cast<double>(theta[3]),
          static_cast<double>(theta[4]), static_cast<double>(theta[5]));
}

template <class T, int N> void test_arm(tests::generator& random, kind_of_arm kind, int configurations_tried) {
    const family_arm source(random, kind);
    const tried<T, N> solver(source);
    for (int i = 0; i < configurations_tried; ++i) {
        T theta[most_joints] = {};
        for (int k = 0; k < source.joints; ++k) theta[k] = static_cast<T>(random.between(-3, 3));
        test_configuration(source, solver, theta);
    }
}

}  // namespace

int main() {
    tests::generator random;
    test_quartics<double>(random);
    test_quartics<float>(random);
    for (int repeat = 0; repeat < 200; ++repeat) {
        test_second_harmonic<double>(random, repeat % 4 == 0);
        test_second_harmonic<float>(random, repeat % 4 == 0);
    }
    for (int repeat = 0; repeat < 15; ++repeat) {
        for (const kind_of_arm kind : {kind_of_arm::wrist, kind_of_arm::parallel}) {
            test_arm<double, 6>(random, kind, 10);
            test_arm<double, dynamic>(random, kind, 3);
            test_arm<float, 6>(random, kind, 2);
        }
        test_arm<double, 4>(random, kind_of_arm::scara, 10);
        test_arm<float, 4>(random, kind_of_arm::scara, 3);
    }
    return tests::verdict("closed_form");
}
