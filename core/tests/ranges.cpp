// Ranges: whole turns taken back, bounds, which coordinates are periodic, and the starts spread over them.
#include "twistarm/ik/ranges.hpp"

#include "arms.hpp"

using namespace twistarm;

namespace {
constexpr double turn = 6.28318530717958647693, far = INFINITY;

/// One coordinate, on a chain of one joint of that twist and multiplier.
ranges<double, dynamic> of_one(const double (&screw)[6], double multiplier, double lower, double upper) {
    const double home[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, start[2] = {-1, 1};
    chain<double, dynamic, dynamic> arm{};
    CHECK(chain_from_screws({1, 1, screw, home, &multiplier}, arm), "one joint");
    return ranges_of(arm, &lower, &upper, start, start + 1);
}

void test_which_turn() {
    const double hinge[6] = {0, -0.3, 0, 0, 0, 1}, slide[6] = {0, 0, 1, 0, 0, 0};
    CHECK(of_one(hinge, 1, -far, far).turns[0] && of_one(hinge, 1, 0, turn).turns[0], "a whole turn is free");
    CHECK(!of_one(hinge, 1, -3, 3).turns[0] && !of_one(slide, 1, -far, far).turns[0], "less than a turn, and a slide");
    CHECK(of_one(hinge, 1, -4, 4).all_turn && !of_one(hinge, 1, -3, 3).all_turn, "all turn");
}

/// By plain forward kinematics; a follower that does not return keeps its master from being periodic.
void test_which_are_periodic() {
    tests::generator random;
    for (int i = 0; i < 20; ++i) {
        const tests::drawn_arm source(random, 4, tests::wiring::followers);
        chain<double, dynamic, dynamic> arm{};
        CHECK(chain_from_screws(source.model(), arm), "arm %d", i);
        bool periodic[most_joints];
        find_periodic(arm, periodic);
        for (int k = 0; k < 4; ++k) {
            double theta[4] = {0.3, -0.7, 1.1, 0.2};
            const tests::matrix g = source.fk(theta);
            theta[k] += turn;
            const bool same = tests::distance(g, tests::to_frame<double>(source.fk(theta))) < 1e-9;
            CHECK(periodic[k] == same, "arm %d, coordinate %d", i, k);
        }
    }
}

void test_bringing_inside() {
    const double hinge[6] = {0, 0, 0, 0, 0, 1}, slide[6] = {0, 0, 1, 0, 0, 0};
    struct expectation {
        const double (&screw)[6];
        double lower, upper, given, expected;
    };
    const expectation all[] = {
        {hinge, -1, 1, 0.5 + turn, 0.5},     {hinge, -1, 1, 0.5 - 5 * turn, 0.5}, {hinge, -1, 1, 2.0, 1.0},
        {hinge, -3.5, 3.5, 3.4, 3.4},        {hinge, -far, far, 1e3, 1e3},        {hinge, 1, far, 0.5, 0.5 + turn},
        {hinge, -far, -1, 0.0, -turn},       {hinge, 2, 2, 2 - turn, 2.0},        {hinge, 2, 2, 1.0, 2.0},
        {slide, -1, 1, 0.5 + turn, 1.0},     {slide, -far, 1, -40.0, -40.0},      {hinge, -1, 1, 1.0 + 1e-13, 1.0},
    };
    for (const expectation& row : all) {
        double theta = row.given;
        const auto range = of_one(row.screw, 1, row.lower, row.upper);
        bring_inside(range, 1, &theta);
        CHECK(std::fabs(theta - row.expected) < 1e-12 && is_inside(range, 1, &theta), "%g in [%g, %g]: %.17g",
              row.given, row.lower, row.upper, theta);
    }
}

/// Of all representatives inside the limits the nearest, found by trying every one.
void test_wrapping() {
    const double hinge[6] = {0, 0, 0, 0, 0, 1};
    tests::generator random;
    for (int i = 0; i < 2000; ++i) {
        const double lower = random.between(-9, 0), upper = lower + turn + random.between(0, 9);
        const double near = random.between(lower, upper), given = random.between(-60, 60);
        const auto range = of_one(hinge, 1, lower, upper);
        double theta = given, best = far;
        wrap_near(range, 1, &near, &theta);
        for (int k = -12; k <= 12; ++k) {
            const double there = given + turn * k;
            if (there >= lower && there <= upper && std::fabs(there - near) < std::fabs(best - near)) best = there;
        }
        CHECK(std::fabs(std::fabs(theta - near) - std::fabs(best - near)) < 1e-12 && is_inside(range, 1, &theta),
              "%g near %g in [%g, %g]: %g, expected %g", given, near, lower, upper, theta, best);
    }
    const auto bounded = of_one(hinge, 1, -1, 1);
    double theta = 0.5;
    const double near = 20;
    wrap_near(bounded, 1, &near, &theta);
    CHECK(theta == 0.5, "what does not turn freely stays");
}

/// Inside, the same for the same numbers, and at least as even as independent ones: in each of ten parts of the range a
/// tenth of them, give or take 3.5 standard deviations of those.
template <class T> void test_starts() {
    for (int n = 1; n <= 9; ++n) {
        ranges<T, dynamic> range{};
        for (int k = 0; k < n; ++k) {
            range.start_lower[k] = T(-2 - k);
            range.start_upper[k] = T(1 + k);
            range.start_stride[k] = stride_of(n, k);
        }
        int counts[9][10] = {};
        for (int restart = 0; restart < 1000; ++restart) {
            T theta[9], again[9], other[9], strided[9 * 8] = {};
            random_start(range, n, 7, restart, theta);
            random_start(range, n, 7, restart, again);
            random_start(range, n, 8, restart, other);
            random_start(range, n, 7, restart, strided + 3, 8);
            for (int k = 0; k < n; ++k) {
                const T part = (theta[k] - range.start_lower[k]) / (range.start_upper[k] - range.start_lower[k]);
                CHECK(part >= T(0) && part <= T(1), "%g", static_cast<double>(part));
                CHECK(theta[k] == again[k] && strided[8 * k + 3] == theta[k], "restart %d", restart);
                CHECK(theta[k] != other[k], "seeds differ");
                ++counts[k][part < T(1) ? static_cast<int>(part * T(10)) : 9];
            }
        }
        for (int k = 0; k < n; ++k)
            for (const int count : counts[k]) CHECK(count > 65 && count < 135, "%d of 1000, coordinate %d", count, k);
    }
}

}  // namespace

int main() {
    test_which_turn();
    test_which_are_periodic();
    test_bringing_inside();
    test_wrapping();
    test_starts<double>();
    test_starts<float>();
    return tests::verdict("ranges");
}
