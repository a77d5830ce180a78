// What a caller gave, as numbers: arrays of any real type and order, lists, tuples, Python's and NumPy's own numbers.
#pragma once

#include "arrays.hpp"

#include <cstdint>

namespace bindings {

// Each is false for what Python has to convert or to refuse; what is written then means nothing. Nothing of the
// caller's is kept: an array may be changed or resized by another thread as soon as the interpreter lock is let go.

// One number, which may be infinite or NaN.
bool real(nb::handle value, double& number);
// A whole number from 0 to 2^64 - 1; True and False are none.
bool whole(nb::handle value, std::uint64_t& number);
// Numbers of exactly this shape, row by row.
bool numbers(nb::handle value, const std::size_t* shape, std::size_t axes, double* into);

inline bool row(nb::handle value, std::size_t count, double* into) { return numbers(value, &count, 1, into); }

// How many there are along the first axis of an array, a list or a tuple.
bool length(nb::handle value, std::size_t& count);
// Whether the first of the first … is nested as deep as an array of so many axes.
bool has_axes(nb::handle value, std::size_t axes);

}  // namespace bindings
