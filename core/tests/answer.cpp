// Whole answers that miss: out of reach, cut short, asked by numbers that are not finite.
// The batches' tests judge targets that are reached, Python's tests nearest configurations, reasons and postures.
#include "twistarm/ik/answer.hpp"

#include "problems.hpp"

using namespace tests;
using namespace twistarm;

namespace {
constexpr target_kind kinds[] = {target_kind::pose, target_kind::position, target_kind::approach, target_kind::task};

constexpr int count = 4;
constexpr std::uint64_t seed = 3;
constexpr double tolerance = 1e-6, slack = 1e-12, reach = 1.0;
constexpr long forever = 1L << 60;

using whole = answer<double, dynamic>;

/// A clock that is up after so many looks.
struct ticking {
    long looks;
    bool operator()() {
        if (looks > 0) --looks;
        return looks == 0;
    }
};

/// An arm, its limits and what is asked of it.
struct setting {
    drawn_arm source;
    chain<double, dynamic, dynamic> arm{};
    problems<double, count> given;
    twistarm::ranges<double, dynamic> range;

    setting(generator& random, const drawn_arm& drawn, target_kind kind)
        : source(drawn), given(random, source, kind) {
        CHECK(chain_from_screws(source.model(), arm), "arm");
        range = given.ranges(arm);
    }

    whole answered(int t, int searches, long looks = forever) const {
        search_settings<double> settings;
        settings.position_tolerance = settings.orientation_tolerance = tolerance;
        settings.searches = searches;
        const double* no_posture = nullptr;
        ticking stopped{looks};
        whole out;
        answer_to(arm, range, settings, given.asked[t], given.theta0 + t * given.n, seed, reach, no_posture, stopped, out);
        return out;
    }
};

/// What holds of every answer, however it came about.
void judge(const setting& with, int t, const whole& out, double rounding = slack) {
    judge(with.source, with.given, t, out.found, tolerance, rounding);
    CHECK((out.stop == stop_reason::converged) == out.found.converged, "reason %d", static_cast<int>(out.stop));
    CHECK((out.stop == stop_reason::blocked_by_limits) == out.has_unlimited, "reason %d", static_cast<int>(out.stop));
    if (!out.has_unlimited) return;
    const misses off = missed(with.given.asked[t], with.source.fk(out.unlimited));
    CHECK(static_cast<double>(off.position) <= tolerance + rounding, "n = %d, target %d: not reached without limits",
          with.given.n, t);
    CHECK(!inside(with.given, out.unlimited), "n = %d, target %d: no limit in the way", with.given.n, t);
}

/// Out of reach, and however soon the time is up: an answer inside the limits that says of itself what is true.
void test_out_of_reach(generator& random, const drawn_arm& source, target_kind kind) {
    setting with(random, source, kind);
    for (double& p : with.given.asked[0].goal.p) p = 400;
    for (double& value : with.given.asked[0].tolerance) value = std::isfinite(value) ? value : 0;
    // A slide without limits would go there.
    for (int k = 0; k < with.given.n; ++k) {
        with.given.lower[k] = std::fmax(with.given.lower[k], -10);
        with.given.upper[k] = std::fmin(with.given.upper[k], 10);
    }
    with.range = with.given.ranges(with.arm);
    const whole out = with.answered(0, 130);
    judge(with, 0, out, 1e-9);
    CHECK(!out.found.converged && out.found.position_error > 1, "400 m away");
    int late = 0;
    for (long looks = 0; looks < 20000; looks += 1 + looks / 3) {
        const whole cut = with.answered(0, 97, looks);
        judge(with, 0, cut, 1e-9);
        late += cut.stop == stop_reason::timed_out;
    }
    CHECK(late > 0, "n = %d: no call was late", with.given.n);
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
}  // namespace

int main() {
    for (const int n : {1, 7, 33})
        for (const target_kind kind : kinds) {
            generator random;
            const drawn_arm arm(random, n, wiring::plain);
            test_out_of_reach(random, arm, kind);
        }
    generator random;
    for (const target_kind kind : kinds) test_what_is_not_finite(random, kind);
    return verdict("answer");
}
