// Reads numbers from a caller: arrays of any real type and order, lists, tuples, numbers of Python and NumPy.
#pragma once

#include "arrays.hpp"

#include <cstdint>

namespace bindings {

// Each function returns false if Python has to convert or refuse the value; the output is then undefined. All values
// are copied: another thread may change or resize an array as soon as the interpreter lock is free.

// One number, which may be infinite or NaN.
bool real(nb::handle value, double& number);
// A whole number from 0 to 2^64 - 1; True and False are refused.
bool whole(nb::handle value, std::uint64_t& number);
// Numbers of exactly this shape, row by row.
bool numbers(nb::handle value, const std::size_t* shape, std::size_t axes, double* into);

inline bool row(nb::handle value, std::size_t count, double* into) { return numbers(value, &count, 1, into); }

// How many there are along the first axis of an array, a list or a tuple.
bool length(nb::handle value, std::size_t& count);
// Whether the first of the first … is nested as deep as an array of so many axes.
bool has_axes(nb::handle value, std::size_t axes);

}  // namespace bindings
