#include "planning.hpp"

#include "twistarm/planning/interval_limits.hpp"

namespace bindings {

namespace {

constexpr std::size_t most_intervals = 1000000;

}  // namespace

nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most) {
    const Numbers b(breakpoints), c(coefficients), v(velocity), a(acceleration), top(ceiling), s(grid);
    if (!c.plain() || c.dimensions() != 3 || !s.plain() || s.dimensions() != 1) return nb::none();
    const std::size_t pieces = c.shape(1), rows = c.shape(2), points = s.shape(0);
    if (points < 2 || points > most_intervals || pieces > most_intervals || rows > most_intervals || c.shape(0) < 1 ||
        c.shape(0) > most_intervals)
        return nb::none();
    if (!b.is(pieces + 1) || !top.is(pieces) || !v.is(rows) || !a.is(rows)) return nb::none();
    const twistarm::limited_path<double> path{static_cast<int>(c.shape(0)) - 1,
                                              static_cast<int>(pieces),
                                              static_cast<int>(rows),
                                              b.data(),
                                              c.data(),
                                              v.data(),
                                              a.data(),
                                              top.data()};
    using Limits = twistarm::interval_limits<double>;
    if (!Limits::fits(path)) return nb::none();
    nb::object x = NumPy::get().empty(nb::make_tuple(points)), share = NumPy::get().empty(nb::make_tuple(points - 1));
    Limits limits(path, s.data());
    const int count = static_cast<int>(points) - 1;
    double* const found = memory(x);
    twistarm::path_velocity(count, limits, most, found);
    for (int i = 0; i < count; ++i) memory(share)[i] = limits.share(i, found[i], found[i + 1]);
    return nb::make_tuple(x, share);
}

}  // namespace bindings
