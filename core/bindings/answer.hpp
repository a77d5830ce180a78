// One answer and its target, as NumPy keeps them: a record with the fields of `record_type` in src/twistarm/ik/answer.py.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "arrays.hpp"
#include "kernels.hpp"

namespace bindings {

// The single numbers at the head of a record, as they lie in memory. Behind them stand theta (n), unlimited (n),
// theta0 (n) and the target's numbers (most_numbers, those that its kind lacks are 0).
struct Record {
    static constexpr std::int64_t not_finished = -1;  // in place of a stop, where the time was up before

    double position_error, orientation_error, position_tol, orientation_tol;
    std::int64_t iterations, restarts, stop, kind;
    bool nearest, has_unlimited, other_branch, start_moved, by_closed_form, certain, spare[2];

    static std::size_t size(std::size_t n) { return sizeof(Record) + (3 * n + most_numbers) * sizeof(double); }

    // What was asked. A record holds copies: an array that the caller changes later must not change it.
    void ask(const Query& query, const Question& question, std::size_t n) {
        *this = Record{};
        stop = not_finished;
        kind = query.kind;
        position_tol = query.position_tolerance;
        orientation_tol = query.orientation_tolerance;
        double* const start = std::fill_n(rows(), 2 * n, 0.0);
        double* const numbers = std::copy_n(question.theta0, n, start);
        std::fill(std::copy_n(question.numbers, numbers_of_kind[kind], numbers), numbers + most_numbers, 0.0);
    }

    void answer(const Answer& found, std::size_t n) {
        position_error = found.position_error;
        orientation_error = found.orientation_error;
        iterations = found.iterations;
        restarts = found.restarts;
        stop = found.stop;
        nearest = found.nearest;
        has_unlimited = found.has_unlimited;
        other_branch = found.other_branch;
        start_moved = found.start_moved;
        double* const unlimited = std::copy_n(found.theta, n, rows());
        if (has_unlimited) std::copy_n(found.unlimited, n, unlimited);
    }

private:
    double* rows() { return reinterpret_cast<double*>(this + 1); }
};

static_assert(sizeof(Record) % sizeof(double) == 0, "numbers follow the head without a gap");

}  // namespace bindings
