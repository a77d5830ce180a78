// Many targets of one kind and where each search begins, as arrays of Python.
#pragma once

#include <cstddef>
#include <memory>

#include "kernels.hpp"
#include "targets.hpp"

namespace bindings {

// Numbers for each target, `step` apart, or the same for all. They are a copy: without the lock another thread may
// change or resize the caller's array.
struct Each {
    std::unique_ptr<double[]> values;
    std::size_t count = 0, step = 0;

    void copy(const Numbers& given, std::size_t step_each) {
        count = given.size();
        step = step_each;
        values.reset(new double[count]);  // not set to 0 first: a million poses are 128 MB
        given.copy_to(values.get());
    }
    double* at(std::size_t t) const { return values.get() + t * step; }
};

struct Questions {
    std::size_t count = 0;
    Each numbers, theta0, posture;

    // False for what is not plainly right. The targets come first.
    bool read_targets(nb::handle given, int kind) {
        const Numbers rows(given);
        const std::size_t width = numbers_of_kind[kind];
        if (!rows.plain() || rows.dimensions() != (kind == 0 ? 3U : 2U)) return false;
        count = rows.shape(0);
        if (!(kind == 0 ? rows.is(count, 4, 4) : rows.is(count, width))) return false;
        numbers.copy(rows, width);
        for (std::size_t t = 0; t < count; ++t)
            if (!is_target(kind, numbers.at(t))) return false;
        return true;
    }
    // One configuration for all, or one for each.
    bool read_thetas(nb::handle given, std::size_t n, Each& thetas) const {
        const Numbers rows(given);
        if (!rows.is(n) && !rows.is(count, n)) return false;
        thetas.copy(rows, rows.dimensions() == 1 ? 0 : n);
        return true;
    }
    Question at(std::size_t t) const {
        return {numbers.at(t), theta0.at(t), posture.count == 0 ? nullptr : posture.at(t)};
    }
};

}  // namespace bindings
