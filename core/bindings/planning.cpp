#include "planning.hpp"

#include <vector>

#include "twistarm/planning/smoothed_law.hpp"

namespace bindings {

namespace {

constexpr std::size_t most_intervals = 1000000;

// A path with its limits, a grid along it, and rows of second order at its points, as Python gives them.
class Given {
public:
    using Path = twistarm::limited_path<double>;
    using Limits = twistarm::interval_limits<double>;
    Given(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
          nb::handle ceiling, nb::handle grid, nb::handle speeding, nb::handle bending)
        : grid_(grid), a_(speeding), b_(bending) {
        const Numbers b(breakpoints), c(coefficients), v(velocity), most(acceleration), top(ceiling);
        if (!c.plain() || c.dimensions() != 3 || !grid_.plain() || grid_.dimensions() != 1) return;
        const std::size_t pieces = c.shape(1), rows = c.shape(2), points = grid_.shape(0);
        if (points < 2 || points > most_intervals || pieces > most_intervals || rows > most_intervals) return;
        if (c.shape(0) < 1 || c.shape(0) > most_intervals) return;
        if (!b.is(pieces + 1) || !top.is(pieces) || !v.is(rows) || !most.is(rows)) return;
        path = {static_cast<int>(c.shape(0)) - 1, static_cast<int>(pieces), static_cast<int>(rows), b.data(), c.data(),
                v.data(), most.data(), top.data()};
        if (!a_.plain() || !b_.plain() || a_.dimensions() != 2 || a_.shape(0) != points) return;
        if (a_.shape(1) > most_intervals || !b_.is(points, a_.shape(1))) return;
        more = {static_cast<int>(a_.shape(1)), a_.data(), b_.data()};
        fits = Limits::fits(path) && Limits::fits(more);
    }
    const double* grid() const { return grid_.data(); }
    int intervals() const { return static_cast<int>(grid_.shape(0)) - 1; }

    Path path{};
    twistarm::second_order_rows<double> more{};
    bool fits = false;

private:
    Numbers grid_, a_, b_;
};

}  // namespace

nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, nb::handle a, nb::handle b, double most) {
    const Given given(breakpoints, coefficients, velocity, acceleration, ceiling, grid, a, b);
    if (!given.fits) return nb::none();
    const int count = given.intervals();
    nb::object x = NumPy::get().empty(nb::make_tuple(count + 1)), share = NumPy::get().empty(nb::make_tuple(count));
    Given::Limits limits(given.path, given.grid(), given.more);
    double* const found = memory(x);
    twistarm::path_velocity(count, limits, most, found);
    for (int i = 0; i < count; ++i) memory(share)[i] = limits.share(i, found[i], found[i + 1]);
    return nb::make_tuple(x, share);
}

nb::object shares_of_average(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity,
                             nb::handle acceleration, nb::handle ceiling, nb::handle grid, nb::handle a, nb::handle b,
                             nb::handle x, nb::handle jerk, double window) {
    const Given given(breakpoints, coefficients, velocity, acceleration, ceiling, grid, a, b);
    const Numbers law(x), limits(jerk);
    if (!given.fits || !law.is(given.intervals() + 1) || !limits.is(given.path.rows)) return nb::none();
    if (!(window > 0.0)) return nb::none();
    nb::object shares = NumPy::get().empty(nb::make_tuple(3, given.path.pieces));
    nb::object fastest = NumPy::get().empty(nb::make_tuple(given.path.pieces));
    std::vector<double> scratch(3 * law.size());
    twistarm::shares_of_average(given.path, limits.data(), {given.intervals(), given.grid(), law.data()}, given.more,
                                window, scratch.data(), memory(shares), memory(fastest));
    return nb::make_tuple(shares, fastest);
}

}  // namespace bindings
