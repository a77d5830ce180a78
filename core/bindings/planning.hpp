// twistarm._core.path_velocity: the velocity along a path as Python sees it.
#pragma once

#include "arrays.hpp"

namespace bindings {

// x (N + 1,), share (N,) and which (N,) on the grid (N + 1,) along a path (m + 1,), (d + 1, m, r) with limits (r,), (r,) and
// (m,); None where these are no plain arrays of such shapes, or more than the core's library takes.
nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most);

}  // namespace bindings
