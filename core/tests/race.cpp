// One target: answers judged by plain forward kinematics, calls at the edge of what is allowed.
#include "twistarm/ik/race.hpp"

#include <cstring>

#include "problems.hpp"
#include "sizes.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::wiring;

namespace {
constexpr int count = 12;
constexpr std::uint64_t seed = 3;
constexpr double slack = 1e-12;

template <int N> bool same_bits(const solution<double, N>& a, const solution<double, N>& b, int n) {
    return std::memcmp(a.theta, b.theta, sizeof(double) * static_cast<std::size_t>(n)) == 0 &&
           a.converged == b.converged && a.iterations == b.iterations && a.restarts == b.restarts;
}

template <target_kind Kind, int N, int M> void test_problems(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    if (!fits<N, M>(general)) return;
    const auto arm = narrowed<double, N, M>(general);
    const tests::problems<double, count> given(random, source, Kind);
    const auto range = given.ranges(arm);
    const search_settings<double> settings;
    int solved = 0;
    for (int t = 0; t < count; ++t) {
        const double* theta0 = given.theta0 + t * given.n;
        solution<double, N> found, again;
        solve(arm, range, settings, given.asked[t], theta0, seed, found);
        solve(arm, range, settings, given.asked[t], theta0, seed, again);
        CHECK(same_bits(found, again, given.n), "the same call gives the same bits");
        tests::judge(source, given, t, found, 1e-6, slack);
        solved += found.converged;
    }
    CHECK(solved >= count - 1, "n = %d, kind %d: %d of %d", given.n, static_cast<int>(Kind), solved, count);
}

template <target_kind Kind, int N, int M> void test_out_of_reach(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    if (!chain_from_screws(source.model(), general) || !fits<N, M>(general)) return;
    const auto arm = narrowed<double, N, M>(general);
    tests::problems<double, 1> given(random, source, Kind);
    for (double& p : given.asked[0].goal.p) p = 400;
    for (double& each : given.asked[0].tolerance) each = 0;
    const auto range = given.ranges(arm);
    search_settings<double> settings;
    settings.searches = 20;
    static double ends[20 * most_joints];
    for (double& end : ends) end = NAN;
    solution<double, N> found;
    solve(arm, range, settings, given.asked[0], given.theta0, seed, found, ends);
    CHECK(!found.converged && found.restarts == 20 && found.position_error > 1, "400 m away");
    for (int i = 0; i < 20 * given.n; ++i) CHECK(std::isfinite(ends[i]), "an end of search %d", i / given.n);
    tests::judge(source, given, 0, found, 1e-6, 1e-9);
    settings.searches = 1;
    solve(arm, range, settings, given.asked[0], given.theta0, seed, found);
    CHECK(found.restarts == 1 && !found.converged && tests::inside(given, found.theta), "one search");
    for (int k = 0; k < given.n; ++k) given.theta0[k] = 1e6;
    solve(arm, range, settings, given.asked[0], given.theta0, seed, found);
    CHECK(tests::inside(given, found.theta), "a start a million radians away");
}

template <int N, int M> void test_size(int n, wiring wired) {
    tests::generator random;
    for (int i = 0; i < 2; ++i) {
        const drawn_arm arm(random, n, wired);
        test_problems<target_kind::pose, N, M>(arm, random);
        test_problems<target_kind::position, N, M>(arm, random);
        test_problems<target_kind::approach, N, M>(arm, random);
        test_problems<target_kind::task, N, M>(arm, random);
        test_out_of_reach<target_kind::pose, N, M>(arm, random);
        test_out_of_reach<target_kind::task, N, M>(arm, random);
    }
}

template <int... N> void test_sizes(std::integer_sequence<int, N...>) {
    (test_size<N, N>(N, wiring::plain), ...);
}

/// In single precision, to a tenth of a millimetre.
template <int N, int M> void test_single_precision(int n, wiring wired) {
    tests::generator random;
    int solved = 0, counted = 0;
    for (int i = 0; i < 4; ++i) {
        const drawn_arm source(random, n, wired);
        chain<double, dynamic, dynamic> general{};
        if (!chain_from_screws(source.model(), general) || !fits<N, M>(general)) continue;
        const auto arm = narrowed<float, N, M>(general);
        const tests::problems<float, count> given(random, source, target_kind::pose);
        const auto range = given.ranges(arm);
        search_settings<float> settings;
        settings.position_tolerance = settings.orientation_tolerance = 1e-4F;
        for (int t = 0; t < count; ++t, ++counted) {
            solution<float, N> found;
            solve(arm, range, settings, given.asked[t], given.theta0 + t * n, seed, found);
            tests::judge(source, given, t, found, 1e-4, 2e-5);
            solved += found.converged;
        }
    }
    CHECK(counted > 0 && solved >= counted - 1, "float: %d of %d", solved, counted);
}

/// Every coordinate stands still between equal limits: an answer where the target is there, none where it is not.
void test_no_room() {
    tests::generator random;
    const drawn_arm source(random, 3, wiring::plain);
    chain<double, dynamic, dynamic> arm{};
    CHECK(chain_from_screws(source.model(), arm), "arm");
    const double at[3] = {0.3, -0.2, 0.5}, elsewhere[3] = {0.3, -0.2, 0.9};
    const auto range = ranges_of(arm, at, at, at, at);
    const search_settings<double> settings;
    solution<double, dynamic> found;
    solve(arm, range, settings, pose_target(tests::to_frame<double>(source.fk(at))), elsewhere, seed, found);
    CHECK(found.converged && found.iterations == 0 && std::memcmp(found.theta, at, sizeof at) == 0, "already there");
    solve(arm, range, settings, pose_target(tests::to_frame<double>(source.fk(elsewhere))), at, seed, found);
    CHECK(!found.converged && std::memcmp(found.theta, at, sizeof at) == 0, "nowhere to go");
}
}  // namespace

int main() {
    test_sizes(tests::sizes{});
    test_size<dynamic, dynamic>(4, wiring::followers);
    test_size<dynamic, dynamic>(6, wiring::differential);
    test_size<dynamic, dynamic>(7, wiring::plain);
    test_size<dynamic, dynamic>(32, wiring::plain);
    test_single_precision<dynamic, dynamic>(6, wiring::plain);
    test_single_precision<dynamic, dynamic>(5, wiring::followers);
    test_no_room();
    return tests::verdict("race");
}
