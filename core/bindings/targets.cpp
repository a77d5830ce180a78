#include "targets.hpp"

#include <cmath>
#include <cstring>

namespace bindings {

namespace {

// As in src/twistarm/checks.py and src/twistarm/ik/targets.py.
constexpr double clean = 1e-14, rounded = 1e-6, last_row = 1e-6;
constexpr double farthest = 1e6;  // [m]
constexpr double no_direction = 1e-12;
constexpr double half_turn = 3.14159265358979323846;

double dot_of_columns(const double* g, int i, int j) { return g[i] * g[j] + g[4 + i] * g[4 + j] + g[8 + i] * g[8 + j]; }

// R (3 I - Rᵀ R) / 2: a Newton step to the nearest orthogonal matrix. It squares the error.
void step_to_rotation(double* g) {
    double inner[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) inner[i][j] = (i == j ? 1.5 : 0.0) - 0.5 * dot_of_columns(g, i, j);
    for (double* row = g; row < g + 12; row += 4) {
        const double old[3] = {row[0], row[1], row[2]};
        for (int j = 0; j < 3; ++j) row[j] = old[0] * inner[0][j] + old[1] * inner[1][j] + old[2] * inner[2][j];
    }
}

bool made_rigid(double* g) {
    double off = 0.0, last = std::fabs(g[15] - 1.0);
    for (int i = 0; i < 3; ++i) {
        last = std::fmax(last, std::fabs(g[12 + i]));
        for (int j = 0; j <= i; ++j) off = std::fmax(off, std::fabs(dot_of_columns(g, i, j) - (i == j ? 1.0 : 0.0)));
    }
    const double determinant = g[0] * (g[5] * g[10] - g[6] * g[9]) - g[1] * (g[4] * g[10] - g[6] * g[8]) +
                               g[2] * (g[4] * g[9] - g[5] * g[8]);
    if (!(last <= last_row) || !(off <= 2.0 * rounded) || !(determinant > 0.0)) return false;
    if (off > 2.0 * clean)
        for (int step = 0; step < 3; ++step) step_to_rotation(g);
    g[12] = g[13] = g[14] = 0.0;
    g[15] = 1.0;
    return true;
}

bool is_near(double length) { return std::fabs(length) <= farthest; }  // and so no NaN

bool is_finite(const double* values, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k)
        if (!std::isfinite(values[k])) return false;
    return true;
}

double length_of(const double* v) { return std::hypot(std::hypot(v[0], v[1]), v[2]); }

bool is_direction(const double* v) { return is_finite(v, 3) && length_of(v) > no_direction; }

bool is_tolerance(const double* tolerance) {
    bool holds = false;
    for (int k = 0; k < 6; ++k) {
        if (!(tolerance[k] >= 0.0)) return false;
        holds = holds || (k < 3 ? std::isfinite(tolerance[k]) : tolerance[k] < half_turn);
    }
    return holds;
}

bool is_one_of(double flag) { return flag == 0.0 || flag == 1.0; }

bool made_unit(double* v) {
    if (!is_direction(v)) return false;
    const double length = length_of(v);
    for (int k = 0; k < 3; ++k) v[k] /= length;
    return std::isfinite(length);
}

}  // namespace

bool is_target(int kind, double* numbers) {
    const bool has_pose = kind == 0 || kind == 3;
    // Finite before anything is compared: a maximum would drop NaN.
    if (has_pose ? !is_finite(numbers, 16) || !made_rigid(numbers) : !is_finite(numbers, 3)) return false;
    for (int k = 0; k < 3; ++k)
        if (!is_near(has_pose ? numbers[4 * k + 3] : numbers[k])) return false;
    if (kind == 2) return is_direction(numbers + 3) && is_direction(numbers + 6);
    return kind != 3 || (is_tolerance(numbers + 16) && is_one_of(numbers[22]));
}

bool read_target(nb::handle given, int kind, double* into) {
    const Numbers numbers(given);
    if (!(kind == 0 ? numbers.is(4, 4) : numbers.is(numbers_of_kind[kind]))) return false;
    numbers.copy_to(into);
    return is_target(kind, into);
}

nb::object pose(nb::handle g) {
    double numbers[16];
    return read_target(g, 0, numbers) ? frozen(nb::make_tuple(4, 4), numbers, 16) : nb::none();
}

nb::object position(nb::handle p) {
    double numbers[3];
    return read_target(p, 1, numbers) ? frozen(nb::int_(3), numbers, 3) : nb::none();
}

nb::object approach(nb::handle p, nb::handle direction, nb::handle tool_axis) {
    const Numbers along(direction), axis(tool_axis);
    const bool has_axis = !tool_axis.is_none();
    double numbers[9];
    if (!read_target(p, 1, numbers) || !along.is(3) || (has_axis && !axis.is(3))) return nb::none();
    along.copy_to(numbers + 3);
    if (has_axis) axis.copy_to(numbers + 6);
    if (!made_unit(numbers + 3) || (has_axis && !made_unit(numbers + 6))) return nb::none();
    return frozen(nb::int_(has_axis ? 9 : 6), numbers, has_axis ? 9 : 6);
}

nb::object task(nb::handle g, nb::handle tolerance, bool base_axes) {
    const Numbers allowed(tolerance);
    double numbers[23];
    if (!read_target(g, 0, numbers) || !allowed.is(6)) return nb::none();
    allowed.copy_to(numbers + 16);
    numbers[22] = base_axes ? 1.0 : 0.0;
    return is_target(3, numbers) ? frozen(nb::int_(23), numbers, 23) : nb::none();
}

}  // namespace bindings
