#include "planning.hpp"

#include <vector>

#include "twistarm/planning/smoothed_law.hpp"

namespace bindings {

namespace {

constexpr std::size_t most_intervals = 1000000;

// A path with its limits, and a grid along it, as Python gives them.
class Given {
public:
    using Path = twistarm::limited_path<double>;
    using Limits = twistarm::interval_limits<double>;
    Given(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
          nb::handle ceiling, nb::handle grid)
        : grid_(grid) {
        const Numbers b(breakpoints), c(coefficients), v(velocity), a(acceleration), top(ceiling);
        if (!c.plain() || c.dimensions() != 3 || !grid_.plain() || grid_.dimensions() != 1) return;
        const std::size_t pieces = c.shape(1), rows = c.shape(2), points = grid_.shape(0);
        if (points < 2 || points > most_intervals || pieces > most_intervals || rows > most_intervals) return;
        if (c.shape(0) < 1 || c.shape(0) > most_intervals) return;
        if (!b.is(pieces + 1) || !top.is(pieces) || !v.is(rows) || !a.is(rows)) return;
        path = {static_cast<int>(c.shape(0)) - 1, static_cast<int>(pieces), static_cast<int>(rows), b.data(), c.data(),
                v.data(), a.data(), top.data()};
        fits = Limits::fits(path);
    }
    const double* grid() const { return grid_.data(); }
    int intervals() const { return static_cast<int>(grid_.shape(0)) - 1; }

    Path path{};
    bool fits = false;

private:
    Numbers grid_;
};

}  // namespace

nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most) {
    const Given given(breakpoints, coefficients, velocity, acceleration, ceiling, grid);
    if (!given.fits) return nb::none();
    const int count = given.intervals();
    nb::object x = NumPy::get().empty(nb::make_tuple(count + 1)), share = NumPy::get().empty(nb::make_tuple(count));
    Given::Limits limits(given.path, given.grid());
    double* const found = memory(x);
    twistarm::path_velocity(count, limits, most, found);
    for (int i = 0; i < count; ++i) memory(share)[i] = limits.share(i, found[i], found[i + 1]);
    return nb::make_tuple(x, share);
}

nb::object shares_of_average(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity,
                             nb::handle acceleration, nb::handle ceiling, nb::handle grid, nb::handle x,
                             nb::handle jerk, double window) {
    const Given given(breakpoints, coefficients, velocity, acceleration, ceiling, grid);
    const Numbers law(x), limits(jerk);
    if (!given.fits || !law.is(given.intervals() + 1) || !limits.is(given.path.rows)) return nb::none();
    if (!(window > 0.0)) return nb::none();
    nb::object shares = NumPy::get().empty(nb::make_tuple(3, given.path.pieces));
    nb::object fastest = NumPy::get().empty(nb::make_tuple(given.path.pieces));
    std::vector<double> scratch(3 * law.size());
    twistarm::shares_of_average(given.path, limits.data(), {given.intervals(), given.grid(), law.data()}, window,
                                scratch.data(), memory(shares), memory(fastest));
    return nb::make_tuple(shares, fastest);
}

}  // namespace bindings
