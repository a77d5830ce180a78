// twistarm._core.path_velocity and shortest_spline: the velocity along a path, and the durations of a spline.
#pragma once

#include "arrays.hpp"

namespace bindings {

// Returns x (N + 1,), share (N,) and which (N,) for a grid (N + 1,) along a path (m + 1,), (d + 1, m, r) with limits
// (r,), (r,) and (m,). Returns None for other arrays or shapes, or for more than the library takes.
nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most);

// Returns the durations (s,), up to a common factor, of a cubic (degree 3) or quintic (5) spline through the ways (s,
// r). It starts from durations (s,) and heeds limits (r,) of velocity, acceleration and jerk. Returns None for other
// arrays or shapes.
nb::object shortest_spline(nb::handle way, nb::handle velocity, nb::handle acceleration, nb::handle jerk,
                           nb::handle durations, int degree);

}  // namespace bindings
