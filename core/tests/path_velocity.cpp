// The velocity along a path: on a straight line the textbook's trapezoid, on a random path every limit kept at 20 points
// of every interval, and the tightest used.
#include "../include/twistarm/planning/interval_limits.hpp"

#include <cmath>

#include "check.hpp"

using namespace twistarm;

namespace {
constexpr int count = 400;

double duration(const double* grid, const double* x) {
    double time = 0;
    for (int i = 0; i < count; ++i) time += 2 * (grid[i + 1] - grid[i]) / (std::sqrt(x[i]) + std::sqrt(x[i + 1]));
    return time;
}

void check_line(double way, double expected) {
    const double breakpoints[] = {0, 1}, coefficients[] = {0, way, 0}, velocity[] = {2}, acceleration[] = {5};
    const double ceiling[] = {HUGE_VAL};
    const limited_path<double> path{2, 1, 1, breakpoints, coefficients, velocity, acceleration, ceiling};
    double grid[count + 1], x[count + 1];
    for (int i = 0; i <= count; ++i) grid[i] = static_cast<double>(i) / count;
    interval_limits<double> limits(path, grid);
    path_velocity(count, limits, 1e18, x);
    CHECK(std::fabs(duration(grid, x) - expected) < 2e-3 * expected, "%g s, not %g s", duration(grid, x), expected);
}

void check_random(tests::generator& random) {
    constexpr int rows = 3, pieces = 4;
    double breakpoints[pieces + 1] = {}, coefficients[4][pieces][rows], ceiling[pieces];
    const double velocity[rows] = {2, 1, 0.5}, acceleration[rows] = {5, 3, 10};
    for (int p = 0; p < pieces; ++p) {
        breakpoints[p + 1] = breakpoints[p] + random.between(0.1, 2);
        ceiling[p] = random.between(0.3, 3);
        for (auto& power : coefficients)
            for (double& each : power[p]) each = random.between(-1, 1);
    }
    const limited_path<double> path{3,        pieces,       rows,   breakpoints, &coefficients[0][0][0],
                                    velocity, acceleration, ceiling};
    double grid[count + 1], x[count + 1];
    for (int i = 0; i <= count; ++i) {
        const int p = i * pieces / count < pieces ? i * pieces / count : pieces - 1;
        const double part = static_cast<double>(i - p * (count / pieces)) / (count / pieces);
        grid[i] = breakpoints[p] + part * (breakpoints[p + 1] - breakpoints[p]);
    }
    interval_limits<double> limits(path, grid);
    path_velocity(count, limits, 1e18, x);
    double worst = 0, used = 0;
    for (int i = 0; i < count; ++i) {
        const int p = i / (count / pieces);
        const double h = grid[i + 1] - grid[i], s_ddot = (x[i + 1] - x[i]) / (2 * h);
        for (int k = 0; k <= 20; ++k) {
            const double at = h * k / 20, here = x[i] + 2 * s_ddot * at, s = grid[i] + at - breakpoints[p];
            worst = std::fmax(worst, here / (ceiling[p] * ceiling[p]));
            for (int r = 0; r < rows; ++r) {
                const double a = coefficients[0][p][r], b = coefficients[1][p][r], c = coefficients[2][p][r];
                const double tangent = (3 * a * s + 2 * b) * s + c, bend = 6 * a * s + 2 * b;
                worst = std::fmax(worst, tangent * tangent * here / (velocity[r] * velocity[r]));
                worst = std::fmax(worst, std::fabs(tangent * s_ddot + bend * here) / acceleration[r]);
            }
        }
        used += limits.share(i, x[i], x[i + 1]) / count;
    }
    CHECK(worst < 1 + 1e-9, "a limit is exceeded by %g", worst - 1);
    CHECK(used > 0.9, "of the tightest limits %g are used", used);
}
}  // namespace

int main() {
    check_line(3, 3.0 / 2 + 2.0 / 5);
    check_line(0.1, 2 * std::sqrt(0.1 / 5));
    tests::generator random;
    for (int path = 0; path < 50; ++path) check_random(random);
    return tests::verdict("path_velocity");
}
