// The times of splines: the gradient beside differences, and no shorter time near the one found.
#include "../include/twistarm/planning/spline_times.hpp"

#include <cmath>
#include <vector>

#include "check.hpp"

using namespace twistarm;

namespace {
constexpr int rows = 3;
const double velocity[rows] = {2, 1, 0.5}, acceleration[rows] = {5, 3, 10}, jerk[rows] = {20, 50, 30};

template <int R> void check(int segments, bool jerky, tests::generator& random) {
    const std::size_t s = static_cast<std::size_t>(segments);
    std::vector<double> way(s * rows), x(s), gradient(s), other(s);
    for (double& each : way) each = random.between(-2, 2);
    for (double& each : x) each = random.between(-1, 1);
    std::vector<double> room(shortest_spline_room<double, R>(segments, rows));
    const spline_ways<double> ways{segments, rows, way.data(), {velocity, acceleration, jerky ? jerk : nullptr}};
    spline_times<double, R> times(ways, room.data());
    times(x.data(), 4, gradient.data());
    for (std::size_t i = 0; i < s; ++i) {
        const double here = x[i];
        x[i] = here + 1e-6;
        const double more = times(x.data(), 4, other.data());
        x[i] = here - 1e-6;
        const double less = times(x.data(), 4, other.data());
        x[i] = here;
        const double slope = (more - less) / 2e-6;
        CHECK(std::fabs(slope - gradient[i]) < 1e-7, "d/dx%zu is %g, not %g", i, slope, gradient[i]);
    }
    shortest_spline<double, R>(ways, x.data(), room.data());
    // A norm of a power so high is the largest rate.
    constexpr int largest = 20;
    const double found = times(x.data(), largest, gradient.data());
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<double> near(x);
        for (double& each : near) each += random.between(-0.05, 0.05);
        const double time = times(near.data(), largest, gradient.data());
        CHECK(time > found - 0.01, "%g is shorter than %g", time, found);
    }
}
}  // namespace

int main() {
    tests::generator random;
    for (const int segments : {1, 2, 3, 9, 40})
        for (const bool jerky : {false, true}) {
            check<1>(segments, jerky, random);
            check<2>(segments, jerky, random);
        }
    return tests::verdict("spline_times");
}
