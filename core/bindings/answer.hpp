// One answer as a row of numbers, as src/twistarm/ik/answer.py reads it.
#pragma once

#include <cstddef>

#include "kernels.hpp"

namespace bindings {

// position error, orientation error, iterations, restarts, stop, flags, kind, position and orientation tolerance,
// theta (n), unlimited (n), theta0 (n), the target's numbers. What was asked stands beside the answer: an array that the
// caller has changed since must not change it.
class Row {
public:
    static constexpr std::size_t first = 9;
    static constexpr double not_finished = -1.0;  // in place of a stop, where the time was up before

    static constexpr std::size_t length(int kind, std::size_t n) { return first + 3 * n + numbers_of_kind[kind]; }

    Row(double* row, std::size_t n) : row_(row), n_(n) {}

    void ask(const Query& query, const Question& question) const {
        row_[4] = not_finished;
        row_[6] = query.kind;
        row_[7] = query.position_tolerance;
        row_[8] = query.orientation_tolerance;
        double* const theta0 = row_ + first + 2 * n_;
        for (std::size_t k = 0; k < n_; ++k) theta0[k] = question.theta0[k];
        for (std::size_t k = 0; k < numbers_of_kind[query.kind]; ++k) theta0[n_ + k] = question.numbers[k];
    }

    void answer(const Answer& found) const {
        row_[0] = found.position_error;
        row_[1] = found.orientation_error;
        row_[2] = found.iterations;
        row_[3] = found.restarts;
        row_[4] = found.stop;
        row_[5] = found.nearest + 2 * found.has_unlimited + 4 * found.other_branch + 8 * found.start_moved;
        double *const theta = row_ + first, *const unlimited = theta + n_;
        for (std::size_t k = 0; k < n_; ++k) {
            theta[k] = found.theta[k];
            unlimited[k] = found.has_unlimited ? found.unlimited[k] : 0.0;
        }
    }

private:
    double* row_;
    std::size_t n_;
};

}  // namespace bindings
