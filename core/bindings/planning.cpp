#include "planning.hpp"

#include <cmath>
#include <vector>

#include "twistarm/planning/interval_limits.hpp"
#include "twistarm/planning/spline_times.hpp"

namespace bindings {

namespace {

constexpr std::size_t most_intervals = 1000000, most_rows = 1000;

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
    double* const found = Array(x).data();
    twistarm::path_velocity(count, limits, most, found);
    for (int i = 0; i < count; ++i) Array(share).data()[i] = limits.share(i, found[i], found[i + 1]);
    return nb::make_tuple(x, share);
}

nb::object shortest_spline(nb::handle way, nb::handle velocity, nb::handle acceleration, nb::handle jerk,
                           nb::handle durations, int degree) {
    const Numbers w(way), v(velocity), a(acceleration), j(jerk), d(durations);
    if (!w.plain() || w.dimensions() != 2 || (degree != 3 && degree != 5)) return nb::none();
    const std::size_t segments = w.shape(0), rows = w.shape(1);
    if (segments < 1 || segments > most_intervals || rows < 1 || rows > most_rows) return nb::none();
    if (!v.is(rows) || !a.is(rows) || !j.is(rows) || !d.is(segments)) return nb::none();
    bool jerky = false;
    for (std::size_t r = 0; r < rows; ++r) jerky = jerky || std::isfinite(j.data()[r]);
    const int s = static_cast<int>(segments), r = static_cast<int>(rows);
    const twistarm::spline_ways<double> ways{s, r, w.data(), {v.data(), a.data(), jerky ? j.data() : nullptr}};
    nb::object found = NumPy::get().empty(nb::make_tuple(segments));
    double* const x = Array(found).data();
    for (std::size_t i = 0; i < segments; ++i) x[i] = std::log(d.data()[i]);
    if (degree == 3) {
        std::vector<double> room(twistarm::shortest_spline_room<double, 1>(s, r));
        twistarm::shortest_spline<double, 1>(ways, x, room.data());
    } else {
        std::vector<double> room(twistarm::shortest_spline_room<double, 2>(s, r));
        twistarm::shortest_spline<double, 2>(ways, x, room.data());
    }
    for (std::size_t i = 0; i < segments; ++i) x[i] = std::exp(x[i]);
    return found;
}

}  // namespace bindings
