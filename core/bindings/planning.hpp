// twistarm._core.path_velocity and shares_of_average: the velocity along a path, and what a smoothed one needs.
#pragma once

#include "arrays.hpp"

namespace bindings {

// Returns x (N + 1,) and share (N,) for a grid (N + 1,) along a path (m + 1,), (d + 1, m, r) with limits
// (r,), (r,) and (m,), and rows a s̈ + b ṡ² ≤ 1 at its points, (N + 1, k) each. Returns None for other arrays or
// shapes, or for more than the library takes.
nb::object path_velocity(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity, nb::handle acceleration,
                         nb::handle ceiling, nb::handle grid, nb::handle a, nb::handle b, double most);

// Returns the shares (3, m) of the limits that the law x (N + 1,) uses once it is averaged over a window [s], and the
// largest ṡ (m,). None as above, and for no positive window.
nb::object shares_of_average(nb::handle breakpoints, nb::handle coefficients, nb::handle velocity,
                             nb::handle acceleration, nb::handle ceiling, nb::handle grid, nb::handle a, nb::handle b,
                             nb::handle x, nb::handle jerk, double window);

}  // namespace bindings
