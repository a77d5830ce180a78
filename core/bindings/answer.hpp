// One answer and its target, which Python reads by name: a single object, or a NumPy record of a batch.
#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <cstdint>

#include "arrays.hpp"
#include "kernels.hpp"

namespace bindings {

// twistarm._core.Answer. An array that the caller has changed since must not change what was asked: it is a copy.
struct OneAnswer {
    Answer found;
    int kind;
    double position_tol, orientation_tol;
    std::size_t n;
    double theta0[most_joints], numbers[most_numbers];

    static void define(nb::module_& module);
};

// The single numbers at the head of a record, as they lie in memory. Behind them stand theta (n), unlimited (n),
// theta0 (n) and the target's numbers.
struct Record {
    static constexpr std::int64_t not_finished = -1;  // in place of a stop, where the time was up before

    double position_error, orientation_error, position_tol, orientation_tol;
    std::int64_t iterations, restarts, stop, kind;
    bool nearest, has_unlimited, other_branch, start_moved, by_closed_form, certain, spare[2];

    static std::size_t size(std::size_t n, std::size_t numbers) {
        return sizeof(Record) + (3 * n + numbers) * sizeof(double);
    }
    // NumPy's data type of records with so many numbers of a target.
    static nb::object type(std::size_t n, std::size_t numbers);

    void ask(const Query& query, const Question& question, std::size_t n);
    void answer(const Answer& found, std::size_t n);

private:
    double* rows() { return reinterpret_cast<double*>(this + 1); }
};

static_assert(sizeof(Record) % sizeof(double) == 0, "numbers follow the head without a gap");

}  // namespace bindings
