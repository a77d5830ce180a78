// Many targets of one kind and where each search begins, as a caller of Python gives them.
#pragma once

#include <cstddef>
#include <memory>

#include "kernels.hpp"
#include "targets.hpp"

namespace bindings {

// Numbers for each target, `step` apart, or the same for all; a copy of the caller's.
struct Each {
    std::unique_ptr<double[]> values;
    std::size_t count = 0, step = 0;

    double* make(std::size_t size) {
        values.reset(new double[size]);  // not set to 0 first: a million poses are 128 MB
        count = size;
        return values.get();
    }
    const double* at(std::size_t t) const { return values.get() + t * step; }
};

struct Questions {
    std::size_t count = 0;
    Each numbers, theta0, posture;

    Question at(std::size_t t) const {
        return {numbers.at(t), theta0.at(t), posture.count == 0 ? nullptr : posture.at(t)};
    }
};

// One configuration for all, or one for each. False as in given.hpp.
bool read_thetas(nb::handle given, std::size_t count, std::size_t n, Each& thetas);
// Targets of a kind, all of them checked.
bool read_targets(nb::handle given, int kind, Questions& asked);

}  // namespace bindings
