// Checks that count what fails and go on, random numbers that are the same everywhere, and the end of a program.
#pragma once

#include <cstdint>
#include <cstdio>

namespace tests {
inline int failures = 0;

/// Random numbers that depend on the seed alone: the upper bits of D. Knuth's linear congruential generator MMIX.
struct generator {
    std::uint64_t state = 42;
    double uniform() {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        return static_cast<double>(state >> 11) / 9007199254740992.0;
    }
    double between(double a, double b) { return a + (b - a) * uniform(); }
};

/// What a test program returns.
inline int verdict(const char* name) {
    std::printf("%s: %s (%d failed)\n", name, failures == 0 ? "passed" : "FAILED", failures);
    return failures == 0 ? 0 : 1;
}
}  // namespace tests

/// A condition and, as for printf, what to say where it does not hold.
#define CHECK(condition, ...)                                                     \
    do {                                                                          \
        if (!(condition) && ++tests::failures <= 20) {                            \
            std::printf("%s:%d: %s: ", __FILE__, __LINE__, #condition);           \
            std::printf(__VA_ARGS__);                                             \
            std::printf("\n");                                                    \
        }                                                                         \
    } while (false)
