// Many targets: judged by plain forward kinematics, independent of each other and of their order, ended when asked to.
#include "twistarm/ik/batch.hpp"

#include <cstring>

#include "problems.hpp"
#include "sizes.hpp"
#include "twistarm/ik/race.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::wiring;

namespace {
constexpr int targets = 21;  // two full rounds of lanes and a part of one
constexpr std::uint64_t seed = 3;

/// Targets in the order `order`; their solutions by their own numbers.
template <class T, int N> struct list {
    const tests::problems<T, targets>& given;
    const int* order;
    std::int64_t total, stop_after;
    solution<T, N>* solutions;
    int stored[targets] = {};

    std::int64_t count() const { return total; }
    target<T> asked(std::int64_t t) const { return given.asked[order[t]]; }
    void start(std::int64_t t, T* theta) const {
        for (int k = 0; k < given.n; ++k) theta[k] = given.theta0[order[t] * given.n + k];
    }
    std::uint64_t seed(std::int64_t) const { return ::seed; }
    T* ends(int) const { return nullptr; }
    void store(std::int64_t t, const solution<T, N>& found, const T*) {
        solutions[order[t]] = found;
        ++stored[order[t]];
    }
    bool goes_on(std::int64_t done) const { return done != stop_after; }
};

template <target_kind Kind, int N, int M> void test_problems(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    if (!fits<N, M>(general)) return;
    const auto arm = narrowed<double, N, M>(general);
    tests::problems<double, targets> given(random, source, Kind);
    for (double& p : given.asked[targets - 1].goal.p) p = 400;  // one that no arm reaches, unless its position is free
    const auto range = given.ranges(arm);
    const search_settings<double> settings;
    int order[targets], reversed[targets];
    for (int t = 0; t < targets; ++t) order[t] = t, reversed[t] = targets - 1 - t;
    static solution<double, N> forwards[targets], backwards[targets];
    list<double, N> one{given, order, targets, -1, forwards}, other{given, reversed, targets, -1, backwards};
    solve_batch<Kind>(arm, range, settings, one);
    solve_batch<Kind>(arm, range, settings, other);
    int solved = 0;
    for (int t = 0; t < targets; ++t) {
        CHECK(one.stored[t] == 1 && other.stored[t] == 1, "target %d is stored once", t);
        const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(given.n);
        CHECK(std::memcmp(forwards[t].theta, backwards[t].theta, bytes) == 0 &&
                  forwards[t].iterations == backwards[t].iterations,
              "n = %d, target %d: an answer depends on its own target alone", given.n, t);
        tests::judge(source, given, t, forwards[t], 1e-6, t == targets - 1 ? 1e-9 : 1e-12);
        solution<double, N> single;
        solve(arm, range, settings, given.asked[t], given.theta0 + t * given.n, seed, single);
        CHECK(single.converged == forwards[t].converged, "n = %d, target %d: solve says otherwise", given.n, t);
        solved += forwards[t].converged;
    }
    CHECK(solved >= targets - 2, "n = %d, kind %d: %d of %d", given.n, static_cast<int>(Kind), solved, targets);

    list<double, N> stopped{given, order, targets, 5, forwards}, empty{given, order, 0, -1, forwards};
    list<double, N> single{given, order, 1, -1, forwards};
    solve_batch<Kind>(arm, range, settings, stopped);
    solve_batch<Kind>(arm, range, settings, empty);
    solve_batch<Kind>(arm, range, settings, single);
    int stored = 0, none = 0;
    for (int t = 0; t < targets; ++t) stored += stopped.stored[t], none += empty.stored[t];
    CHECK(stored == 5 && none == 0 && single.stored[0] == 1, "%d before the end, %d of no targets", stored, none);
}

template <int N, int M> void test_size(int n, wiring wired) {
    tests::generator random;
    const drawn_arm arm(random, n, wired);
    test_problems<target_kind::pose, N, M>(arm, random);
    test_problems<target_kind::position, N, M>(arm, random);
    test_problems<target_kind::approach, N, M>(arm, random);
    test_problems<target_kind::task, N, M>(arm, random);
}

template <int... N> void test_sizes(std::integer_sequence<int, N...>) {
    (test_size<N, N>(N, wiring::plain), ...);
}

void test_single_precision() {
    tests::generator random;
    const drawn_arm source(random, 6, wiring::plain);
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    const auto arm = narrowed<float, dynamic, dynamic>(general);
    const tests::problems<float, targets> given(random, source, target_kind::pose);
    search_settings<float> settings;
    settings.position_tolerance = settings.orientation_tolerance = 1e-4F;
    int order[targets], solved = 0;
    for (int t = 0; t < targets; ++t) order[t] = t;
    static solution<float, dynamic> solutions[targets];
    list<float, dynamic> all{given, order, targets, -1, solutions};
    solve_batch<target_kind::pose>(arm, given.ranges(arm), settings, all);
    for (int t = 0; t < targets; ++t) {
        tests::judge(source, given, t, solutions[t], 1e-4, 2e-5);
        solved += solutions[t].converged;
    }
    CHECK(solved >= targets - 1, "float: %d of %d", solved, targets);
}
}  // namespace

int main() {
    test_sizes(tests::sizes{});
    test_size<dynamic, dynamic>(4, wiring::followers);
    test_size<dynamic, dynamic>(6, wiring::differential);
    test_size<dynamic, dynamic>(32, wiring::plain);
    test_single_precision();
    return tests::verdict("batch");
}
