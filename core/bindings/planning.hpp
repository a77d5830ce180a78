// twistarm._core.path_velocity and shortest_spline: the velocity along a path, and a spline's times, as Python sees them.
#pragma once

#include "arrays.hpp"

namespace bindings {

// x (N + 1,), share (N,) and which (N,) on the grid (N + 1,) along a path (m + 1,), (d + 1, m, r) with limits (r,), (r,) and
// (m,); None where these are no plain arrays of such shapes, or more than the core's library takes.
nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most);

// Durations (s,), but for one factor of all, of a cubic (degree 3) or quintic (5) spline of the ways (s, r), from durations to
// begin with (s,), with limits (r,) of velocity, acceleration and jerk; None where these are no plain arrays of such shapes.
nb::object shortest_spline(nb::handle way, nb::handle velocity, nb::handle acceleration, nb::handle jerk,
                           nb::handle durations, int degree);

}  // namespace bindings
