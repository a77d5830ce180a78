// twistarm._core.path_velocity: the velocity along a path.
#pragma once

#include "arrays.hpp"

namespace bindings {

// Returns x (N + 1,), share (N,) and which (N,) for a grid (N + 1,) along a path (m + 1,), (d + 1, m, r) with limits
// (r,), (r,) and (m,). Returns None for other arrays or shapes, or for more than the library takes.
nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, double most);

}  // namespace bindings
