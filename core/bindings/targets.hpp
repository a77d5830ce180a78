// Targets as numbers. The core checks the plain cases; Python checks the rest.
#pragma once

#include "arrays.hpp"
#include "kernels.hpp"

namespace bindings {

// Whether these numbers are a valid target of a kind. A rotation that is off by the rounding of single precision
// becomes the nearest rotation. Python rounds what is farther off, and says so.
bool is_target(int kind, double* numbers);

// One target of a kind, from a plain array.
bool read_target(nb::handle given, int kind, double* numbers);

// A target's read-only numbers from its constructor's arguments (src/twistarm/ik/targets.py), or None if Python has to
// check.
nb::object pose(nb::handle g);
nb::object position(nb::handle p);
nb::object approach(nb::handle p, nb::handle direction, nb::handle tool_axis);  // without an axis: six numbers
nb::object task(nb::handle g, nb::handle tolerance, bool base_axes);

}  // namespace bindings
