// Whole answers: judged by plain forward kinematics, the nearest against random configurations, reasons that are known
// by construction, calls that are cut short, postures.
#include <cstring>

#include "answers.hpp"

using namespace tests;
using namespace twistarm;

namespace {
constexpr target_kind kinds[] = {target_kind::pose, target_kind::position, target_kind::approach, target_kind::task};

/// The middle of where random configurations are drawn, moved by `step` in every coordinate that is free to.
void near_the_middle(const setting& with, double step, double* theta) {
    for (int k = 0; k < with.given.n; ++k) {
        const double middle = 0.5 * (with.given.start_lower[k] + with.given.start_upper[k]);
        theta[k] = std::fmin(middle + step, with.given.upper[k]);
    }
}

/// Asks for the pose at θ, or for its position.
void ask_for(setting& with, int t, target_kind kind, const double* theta) {
    const auto goal = to_frame<double>(with.source.fk(theta));
    with.given.asked[t] = pose_target(goal);
    if (kind == target_kind::position) with.given.asked[t] = position_target(goal.p);
}

void test_targets_that_can_be_met(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    const int n = with.given.n;
    double close[most_joints];
    near_the_middle(with, 0, with.given.theta0);
    near_the_middle(with, 1e-3 / n, close);
    if (kind == target_kind::pose || kind == target_kind::position) ask_for(with, 0, kind, close);
    for (const int searches : {1, 5, 97, 130}) {
        int met = 0;
        for (int t = 0; t < count; ++t) {
            const whole out = with.answered(t, searches), again = with.answered(t, searches);
            judge(with, t, out);
            judge(with, t, with.concluded(t, searches));
            CHECK(std::memcmp(out.found.theta, again.found.theta, sizeof(double) * static_cast<std::size_t>(n)) == 0 &&
                      out.stop == again.stop,
                  "n = %d, target %d: the same call gives the same bits", n, t);
            // From one start the nearest that 32 joints come to may be one minimum of many, and limits are blamed.
            CHECK(out.found.converged || !excludes(out.stop) ||
                      (n == 32 && searches == 1 && out.stop == stop_reason::blocked_by_limits),
                  "n = %d, kind %d, target %d, %d searches: excluded by %d", n, static_cast<int>(kind), t, searches,
                  static_cast<int>(out.stop));
            CHECK(out.other_branch == (out.found.converged && on_another_branch(with, t, out)), "n = %d, target %d", n,
                  t);
            met += out.found.converged;
        }
        CHECK(searches < 97 || met == count, "n = %d, kind %d, %d searches: %d of %d", n, static_cast<int>(kind),
              searches, met, count);
    }
}

/// Targets that are met outside the limits, which leave ±0.1 about the middle of where the targets were drawn: if they
/// are not met inside too, nothing but the limits is to blame.
void test_targets_outside_the_limits(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    for (int k = 0; k < with.given.n; ++k) {
        const double middle = 0.5 * (with.given.start_lower[k] + with.given.start_upper[k]);
        with.given.lower[k] = with.given.start_lower[k] = middle - 0.1;
        with.given.upper[k] = with.given.start_upper[k] = middle + 0.1;
        for (int t = 0; t < count; ++t) with.given.theta0[t * with.given.n + k] = middle;
    }
    with.range = with.given.ranges(with.arm);
    int blocked = 0;
    for (const int searches : {1, 97}) {
        for (int t = 0; t < count; ++t) {
            const whole out = with.answered(t, searches);
            judge(with, t, out);
            CHECK(out.stop != stop_reason::out_of_reach && out.stop != stop_reason::impossible_direction,
                  "n = %d, kind %d, target %d, %d searches: %d", with.given.n, static_cast<int>(kind), t, searches,
                  static_cast<int>(out.stop));
            blocked += out.has_unlimited;
            if (searches > 1 && out.has_unlimited) check_nearest(with, t, out, random);
        }
    }
    CHECK(kind != target_kind::pose || blocked > 0, "n = %d: the limits are in nobody's way", with.given.n);
}

void test_out_of_reach(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    for (double& p : with.given.asked[0].goal.p) p = 400;
    for (double& each : with.given.asked[0].tolerance) each = std::isfinite(each) ? each : 0;
    // A slide without limits would go there.
    for (int k = 0; k < with.given.n; ++k) {
        with.given.lower[k] = std::fmax(with.given.lower[k], -10);
        with.given.upper[k] = std::fmin(with.given.upper[k], 10);
    }
    with.range = with.given.ranges(with.arm);
    for (const int searches : {1, 5, 130}) {
        const whole out = with.answered(0, searches);
        judge(with, 0, out, 1e-9);
        CHECK(!out.found.converged && out.found.position_error > 1, "400 m away");
        if (excludes(out.stop)) check_nearest(with, 0, out, random);
    }
}

/// However soon the time is up: an answer inside the limits that says of itself what is true.
void test_calls_cut_short(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    for (double& p : with.given.asked[0].goal.p) p = 400;
    int ended = 0, late = 0;
    for (long looks = 0; looks < 20000; looks += 1 + looks / 3) {
        const whole out = with.answered(0, 97, nullptr, looks);
        judge(with, 0, out, 1e-9);
        (out.stop == stop_reason::timed_out ? late : ended) += 1;
    }
    CHECK(ended > 0 && (late > 0 || !std::isfinite(with.given.asked[0].tolerance[0])), "%d calls ended, %d late", ended,
          late);
}

/// The answer nearest to a posture still meets the target; where the posture itself meets it, that is where it leads.
void test_postures(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    const int n = with.given.n;
    for (int t = 0; t < count; ++t) {
        double posture[most_joints];
        for (int k = 0; k < n; ++k) posture[k] = random.between(with.given.start_lower[k], with.given.start_upper[k]);
        const whole plain = with.answered(t, 97), out = with.answered(t, 97, posture);
        judge(with, t, out);
        CHECK(out.found.converged == plain.found.converged, "n = %d, target %d: a posture decides", n, t);
        CHECK(apart(out.found.theta, posture, n) <= apart(plain.found.theta, posture, n) + slack,
              "n = %d, target %d: farther from the posture than without one", n, t);
    }
    if (kind != target_kind::pose && kind != target_kind::position) return;
    double posture[most_joints];
    near_the_middle(with, 0, posture);
    near_the_middle(with, 0.05, with.given.theta0);
    ask_for(with, 0, kind, posture);
    const whole out = with.answered(0, 97, posture);
    judge(with, 0, out);
    CHECK(most_apart(out.found.theta, posture, n) < 1e-4, "n = %d, kind %d: %g from a posture that meets the target", n,
          static_cast<int>(kind), most_apart(out.found.theta, posture, n));
}

/// One joint takes its tool to a place in one way; there it cannot be turned as well.
void test_a_direction_no_joint_turns(generator& random) {
    for (int i = 0; i < 10; ++i) {
        const drawn_arm source(random, 1, wiring::plain);
        setting with(random, source, target_kind::pose);
        const double phi[3] = {0.2, 0.1, -0.2};
        with.given.asked[0] = pose_target(product(with.given.asked[0].goal, to_frame<double>(rotation(phi))));
        for (const int searches : {1, 5, 97}) {
            const whole out = with.answered(0, searches);
            judge(with, 0, out);
            CHECK(out.stop == stop_reason::impossible_direction, "%d searches: %d", searches,
                  static_cast<int>(out.stop));
            CHECK(out.found.position_error < 1e-9 && std::fabs(out.found.orientation_error - 0.3) < 1e-8,
                  "%g m, %g rad", out.found.position_error, out.found.orientation_error);
        }
    }
}

/// What is not finite is answered at once, wherever it stands, and never by a number that looks like an answer.
void test_what_is_not_finite(generator& random, target_kind kind) {
    const drawn_arm source(random, 5, wiring::plain);
    for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL})
        for (int at = 0; at < 4; ++at) {
            setting with(random, source, kind);
            target<double>& asked = with.given.asked[0];
            if (at == 0) asked.goal.p[0] = bad;
            if (at == 1) asked.goal.z[2] = bad;
            if (at == 2) asked.direction[1] = asked.tolerance[0] = -std::fabs(bad);
            if (at == 3) with.given.theta0[0] = bad;
            if (at == 2 && kind != target_kind::approach && kind != target_kind::task) continue;
            const whole out = with.answered(0, 97);
            CHECK(out.stop == stop_reason::unusable && !out.found.converged && out.found.restarts == 0,
                  "kind %d, %g at %d: %d", static_cast<int>(kind), bad, at, static_cast<int>(out.stop));
            CHECK(std::isinf(out.found.position_error), "%g m", out.found.position_error);
        }
}

bool only_turns(const double xi[6]) {
    return xi[3] * xi[3] + xi[4] * xi[4] + xi[5] * xi[5] > 0.5 &&
           std::fabs(xi[0] * xi[3] + xi[1] * xi[4] + xi[2] * xi[5]) < 1e-6;
}

/// Joints that only turn, about axes within 1 m of the base's origin, never take a tool 400 m away.
void test_turning_joints_out_of_reach(generator& random) {
    for (int found = 0; found < 3;) {
        const drawn_arm source(random, 5, wiring::plain);
        bool turns = true;
        for (int i = 0; i < source.joints; ++i) turns = turns && only_turns(source.twists[i]);
        if (!turns) continue;
        ++found;
        for (const target_kind kind : {target_kind::pose, target_kind::position, target_kind::approach}) {
            setting with(random, source, kind);
            for (double& p : with.given.asked[0].goal.p) p = 400;
            for (const int searches : {1, 5, 97})
                CHECK(with.answered(0, searches).stop == stop_reason::out_of_reach, "%d searches", searches);
        }
    }
}
}  // namespace

int main() {
    for (const int n : {1, 7, 32}) {
        for (const target_kind kind : kinds) {
            generator random;
            const drawn_arm arm(random, n, wiring::plain);
            test_targets_that_can_be_met(random, arm, kind);
            test_targets_outside_the_limits(random, arm, kind);
            test_out_of_reach(random, arm, kind);
            test_calls_cut_short(random, arm, kind);
            test_postures(random, arm, kind);
        }
    }
    generator random;
    for (const target_kind kind : kinds) test_what_is_not_finite(random, kind);
    test_a_direction_no_joint_turns(random);
    test_turning_joints_out_of_reach(random);
    return verdict("answer");
}
