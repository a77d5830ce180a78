// The numbers of joints for which fixed-size kernels are compiled into the tests.
#pragma once

#include <utility>

/// A fixed size takes seconds to compile, a minute with sanitizers or in small registers: -DTWISTARM_TEST_SIZES=3,7.
#if !defined(TWISTARM_TEST_SIZES)
#define TWISTARM_TEST_SIZES 1, 2, 3, 4, 5, 6, 7, 8
#endif

namespace tests {
using sizes = std::integer_sequence<int, TWISTARM_TEST_SIZES>;
}  // namespace tests
