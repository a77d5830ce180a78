// twistarm._core.Answer: what one solve found, read attribute by attribute when somebody asks.
#pragma once

#include "arrays.hpp"
#include "kernels.hpp"

namespace bindings {

// The question is kept with the answer: an array that the caller has changed since must not change what was asked.
struct OneAnswer {
    int kind, n;
    double numbers[most_numbers], theta0[most_joints];
    double position_tolerance, orientation_tolerance;
    Answer answer;

    // float64 in a row: a NumPy array would cost more than a tenth of the solve, asked for or not.
    static nb::bytes row(const double* values, std::size_t size) {
        return nb::bytes(reinterpret_cast<const char*>(values), size * sizeof(double));
    }
    nb::bytes theta_row(const double* values) const { return row(values, static_cast<std::size_t>(n)); }
};

// The numbers of a target of a kind as they must be: rigid motions, within reach of double precision.
bool is_target(int kind, const double* numbers);

}  // namespace bindings
