// Answers to problems of inverse kinematics, and their judges: plain forward kinematics and random configurations.
#pragma once

#include "problems.hpp"
#include "twistarm/ik/answer.hpp"

namespace tests {
using twistarm::answer;
using twistarm::chain;
using twistarm::search_settings;
using twistarm::stop_reason;

constexpr int count = 4, samples = 200;
constexpr std::uint64_t seed = 3;
constexpr double tolerance = 1e-6, slack = 1e-12, reach = 1.0;

using whole = answer<double, dynamic>;

/// A clock that is up after so many looks.
struct ticking {
    long looks;
    bool operator()() {
        if (looks > 0) --looks;
        return looks == 0;
    }
};
constexpr long forever = 1L << 60;

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

    const double* theta0(int t) const { return given.theta0 + t * given.n; }

    whole answered(int t, int searches, const double* posture = nullptr, long looks = forever) const {
        const auto settings = of_searches(searches);
        ticking stopped{looks};
        whole out;
        answer_to(arm, range, settings, given.asked[t], theta0(t), seed, reach, posture, stopped, out);
        return out;
    }

    /// From what the searches have left, without where each of them ended.
    whole concluded(int t, int searches) const {
        const auto settings = of_searches(searches);
        double *no_ends = nullptr, *no_posture = nullptr;
        ticking stopped{forever};
        twistarm::solution<double, dynamic> found{};
        solve(arm, range, settings, given.asked[t], theta0(t), seed, found, no_ends, 0, stopped);
        whole out;
        conclude(arm, range, settings, given.asked[t], theta0(t), seed, reach, no_posture, stopped, found, no_ends, 0,
                 out);
        return out;
    }

private:
    static search_settings<double> of_searches(int searches) {
        search_settings<double> settings;
        settings.searches = searches;
        return settings;
    }
};

inline double apart(const double* a, const double* b, int n) {
    double squared = 0;
    for (int k = 0; k < n; ++k) squared += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(squared);
}

inline double most_apart(const double* a, const double* b, int n) {
    double most = 0;
    for (int k = 0; k < n; ++k) most = std::fmax(most, std::fabs(a[k] - b[k]));
    return most;
}

/// What holds of every answer, however it came about.
inline void judge(const setting& with, int t, const whole& out, double rounding = slack) {
    judge(with.source, with.given, t, out.found, tolerance, rounding);
    CHECK((out.stop == stop_reason::converged) == out.found.converged, "reason %d", static_cast<int>(out.stop));
    CHECK((out.stop == stop_reason::blocked_by_limits) == out.has_unlimited, "reason %d", static_cast<int>(out.stop));
    if (!out.has_unlimited) return;
    const misses off = missed(with.given.asked[t], with.source.fk(out.unlimited));
    CHECK(static_cast<double>(off.position) <= tolerance + rounding, "n = %d, target %d: not met without limits",
          with.given.n, t);
    CHECK(out.found.position_error > tolerance || static_cast<double>(off.orientation) < out.found.orientation_error,
          "n = %d, target %d: no less turned without limits", with.given.n, t);
    CHECK(!inside(with.given, out.unlimited), "n = %d, target %d: no limit in the way", with.given.n, t);
}

/// No random configuration, anywhere or beside the answer, is nearer: in position, or in rotation where it is as near.
inline void check_nearest(const setting& with, int t, const whole& out, generator& random) {
    const double position = out.found.position_error <= tolerance ? 0 : out.found.position_error;
    for (int i = 0; i < samples; ++i) {
        double theta[most_joints];
        for (int k = 0; k < with.given.n; ++k) {
            const double beside = out.found.theta[k] + std::pow(0.1, i / 2 % 6) * random.between(-1, 1);
            theta[k] = i % 2 == 0 ? random.between(with.given.start_lower[k], with.given.start_upper[k])
                                  : std::fmin(std::fmax(beside, with.given.lower[k]), with.given.upper[k]);
        }
        const misses off = missed(with.given.asked[t], with.source.fk(theta));
        CHECK(position <= static_cast<double>(off.position) + 1e-9, "n = %d, target %d: %g is nearer than %g",
              with.given.n, t, static_cast<double>(off.position), out.found.position_error);
        CHECK(static_cast<double>(off.position) > out.found.position_error ||
                  out.found.orientation_error <= static_cast<double>(off.orientation) + 1e-5,
              "n = %d, target %d: turned by %g as near as by %g", with.given.n, t,
              static_cast<double>(off.orientation), out.found.orientation_error);
    }
}

/// Whether a reason says that there is no answer, not only that none was found.
inline bool excludes(stop_reason reason) {
    return reason == stop_reason::out_of_reach || reason == stop_reason::impossible_direction ||
           reason == stop_reason::blocked_by_limits;
}

/// Whether an answer stands on another branch than θ₀, by the definition: for a target within 2 cm and 3° of there.
inline bool on_another_branch(const setting& with, int t, const whole& out) {
    const misses off = missed(with.given.asked[t], with.source.fk(with.theta0(t)));
    const bool near = off.position <= 0.02L && off.orientation <= 0.05235987755982988731L;
    return near && most_apart(out.found.theta, with.theta0(t), with.given.n) > 0.2;
}
}  // namespace tests
