// One target and many: judged by plain forward kinematics, calls at the edge of what is allowed. Of many, each answer is
// independent of the others and of their order, and they end when asked to.
#include "twistarm/ik/batch.hpp"

#include <cstring>
#include <utility>

#include "problems.hpp"
#include "twistarm/ik/race.hpp"
#include "twistarm/ik/reachable.hpp"

using namespace twistarm;
using tests::drawn_arm;
using tests::wiring;

/// A fixed size takes seconds to compile, a minute with sanitizers or in small registers: -DTWISTARM_TEST_SIZES=3,7.
#if !defined(TWISTARM_TEST_SIZES)
#define TWISTARM_TEST_SIZES 1, 2, 3, 4, 5, 6, 7, 8
#endif

namespace {
constexpr int targets = 21;  // two full rounds of lanes and a part of one
constexpr std::uint64_t seed = 3;

template <int N> bool same_bits(const solution<double, N>& a, const solution<double, N>& b, int n) {
    return std::memcmp(a.theta, b.theta, sizeof(double) * static_cast<std::size_t>(n)) == 0 &&
           a.converged == b.converged && a.iterations == b.iterations && a.restarts == b.restarts;
}

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

/// The same targets one after the other, and their configurations.
template <int N> struct row {
    const tests::problems<double, targets>& given;
    int stop_after, stored = 0;
    bool reached[targets] = {};
    double theta[targets][capacity(N)] = {};

    std::int64_t count() const { return targets; }
    target<double> asked(std::int64_t t) const { return given.asked[t]; }
    void store(std::int64_t t, const double* found) {
        ++stored;
        reached[t] = found != nullptr;
        for (int k = 0; k < given.n && reached[t]; ++k) theta[t][k] = found[k];
    }
    bool operator()() const { return stored == stop_after; }
};

template <target_kind Kind, int N, int M> void test_problems(const drawn_arm& source, tests::generator& random) {
    chain<double, dynamic, dynamic> general{};
    CHECK(chain_from_screws(source.model(), general), "arm");
    if (!fits<N, M>(general)) return;
    const auto arm = narrowed<double, N, M>(general);
    tests::problems<double, targets> given(random, source, Kind);
    for (double& p : given.asked[targets - 1].goal.p) p = 400;  // one that no arm reaches, unless its position is free
    const auto range = given.ranges(arm);
    search_settings<double> settings;
    settings.position_tolerance = settings.orientation_tolerance = 1e-6;
    int order[targets], reversed[targets];
    for (int t = 0; t < targets; ++t) order[t] = t, reversed[t] = targets - 1 - t;
    static solution<double, N> forwards[targets], backwards[targets];
    list<double, N> in_order{given, order, targets, -1, forwards}, in_reverse{given, reversed, targets, -1, backwards};
    solve_batch<Kind>(arm, range, settings, in_order);
    solve_batch<Kind>(arm, range, settings, in_reverse);
    int solved = 0;
    for (int t = 0; t < targets; ++t) {
        CHECK(in_order.stored[t] == 1 && in_reverse.stored[t] == 1, "target %d is stored once", t);
        CHECK(same_bits(forwards[t], backwards[t], given.n),
              "n = %d, target %d: an answer depends on its own target alone", given.n, t);
        solution<double, N> single, again;
        solve(arm, range, settings, given.asked[t], given.theta0 + t * given.n, seed, single);
        solve(arm, range, settings, given.asked[t], given.theta0 + t * given.n, seed, again);
        CHECK(same_bits(single, again, given.n), "the same call gives the same bits");
        const double slack = t == targets - 1 ? 1e-9 : 1e-12;
        tests::judge(source, given, t, forwards[t], 1e-6, slack);
        tests::judge(source, given, t, single, 1e-6, slack);
        CHECK(single.converged == forwards[t].converged, "n = %d, target %d: solve says otherwise", given.n, t);
        solved += forwards[t].converged;
    }
    CHECK(solved >= targets - 2, "n = %d, kind %d: %d of %d", given.n, static_cast<int>(Kind), solved, targets);

    row<N> verdicts{given, -1}, begun{given, 5};
    find_reachable<Kind>(arm, range, settings, given.theta0, seed, verdicts);
    find_reachable<Kind>(arm, range, settings, given.theta0, seed, begun);
    for (int t = 0; t < targets; ++t) {
        // The last is far: slides without limits may be moved to it.
        const bool same = verdicts.reached[t] == forwards[t].converged || (t == targets - 1 && verdicts.reached[t]);
        CHECK(same, "n = %d, target %d: a verdict differs", given.n, t);
        solution<double, N> found{};
        for (int k = 0; k < given.n; ++k) found.theta[k] = verdicts.theta[t][k];
        CHECK(!verdicts.reached[t] || judge(arm, range, settings, given.asked[t], given.theta0, found), "not reached");
    }
    CHECK(begun.stored == 5, "%d of 5 before the end", begun.stored);

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
}  // namespace

int main() {
    test_sizes(std::integer_sequence<int, TWISTARM_TEST_SIZES>{});
    test_size<dynamic, dynamic>(4, wiring::followers);
    test_size<dynamic, dynamic>(6, wiring::differential);
    test_size<dynamic, dynamic>(64, wiring::plain);
    return tests::verdict("batch");
}
