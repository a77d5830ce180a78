// What may be asked of an arm's tool, as numbers: checked here, where it is plainly right; else in Python.
#pragma once

#include "given.hpp"
#include "kernels.hpp"

namespace bindings {

// Whether these are the numbers of a target of a kind, once the rotation of a pose that is off by no more than the
// rounding of single precision has been made the nearest rotation. What is further off Python rounds and says so.
bool is_target(int kind, double* numbers);

constexpr std::size_t four_by_four[] = {4, 4};

// One target of a kind, from its numbers as a caller gives them.
bool read_target(nb::handle given, int kind, double* numbers);

// A target's numbers, read-only, from what its class is given (src/twistarm/ik/targets.py); None where Python has to look.
nb::object pose(nb::handle g);
nb::object position(nb::handle p);
nb::object approach(nb::handle p, nb::handle direction, nb::handle tool_axis);  // without an axis: six numbers
nb::object task(nb::handle g, nb::handle tolerance, bool base_axes);

}  // namespace bindings
