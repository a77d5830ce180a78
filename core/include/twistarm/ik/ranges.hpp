// Ranges of the coordinates: limits, coordinates that turn for ever, ranges of random starts.
#pragma once

#include "../kinematics/kinematics.hpp"
#include "random.hpp"

TWISTARM_BEGIN

constexpr int seen_starts = 64;

/// Limits (infinite without one), ranges of random starts (finite), and the periodic coordinates.
///
/// A periodic coordinate with a range of at least a turn `turns` freely during a search and is wrapped at the end.
template <class T, int N> struct ranges {
    T lower[capacity(N)], upper[capacity(N)];
    T start_lower[capacity(N)], start_upper[capacity(N)];
    std::uint64_t start_stride[capacity(N)];
    bool periodic[capacity(N)], turns[capacity(N)];
    bool all_turn;
    T most_speed, most_turning;  ///< bounds of the tool's velocities [m/s], [rad/s] while no coordinate is faster than 1
    float seen[12][seen_starts];  ///< rows of the tool's poses (3, 4) at the starts 1, 2, … of seed 0
};

constexpr double whole_turn = 6.28318530717958647693;

namespace detail {
/// Largest rounding of a multiplier that is a whole number, and of a pitch [m/rad] that is 0.
constexpr double whole_turn_tolerance = 1e-9;

/// Whether a joint with the rates `rate` [rad] and `slide` [m] per unit of its coordinate is back after 2π of it.
inline bool returns(double rate, double slide, double multiplier) {
    const double turns = absolute(rate * multiplier);
    return rate > 0.0 && absolute(slide) <= whole_turn_tolerance * rate &&
           absolute(turns - __builtin_round(turns)) <= whole_turn_tolerance;
}

/// x without the whole turns that lie outside [lower, upper]. An excess of the size of rounding stays.
template <class T> inline T turned_back(T x, T lower, T upper) {
    const double turn = whole_turn, margin = whole_turn_tolerance;
    const double below = __builtin_ceil(greatest(static_cast<double>(lower - x), 0.0) / turn - margin);
    const double above = __builtin_ceil(greatest(static_cast<double>(x - upper), 0.0) / turn - margin);
    return static_cast<T>(static_cast<double>(x) + turn * (below - above));
}
}  // namespace detail

/// The coordinates whose motion by 2π has no effect: each of their joints is a pure rotation by whole turns.
template <class T, int N, int M> void find_periodic(const chain<T, N, M>& arm, bool* periodic) {
    for (int k = 0; k < arm.coordinates(); ++k) {
        bool moves = false, returns = true;
        for (int i = 0; i < arm.joints(); ++i) {
            const double multiplier = static_cast<double>(arm.coupling[i][k]);
            if (multiplier == 0.0) continue;
            moves = true;
            returns = returns && detail::returns(static_cast<double>(arm.links[i].turn),
                                                 static_cast<double>(arm.links[i].slide), multiplier);
        }
        periodic[k] = moves && returns;
    }
}

namespace detail {
/// Bounds of the tool's speed and angular velocity with all coordinates at rates of at most 1. A joint turns the tool
/// on a radius of at most the links after it; slides are at most where random starts go.
template <class T, int N, int M> void find_most_velocity(const chain<T, N, M>& arm, ranges<T, N>& found) {
    found.most_speed = found.most_turning = T(0);
    T radius = sqrt(dot(arm.tip.p, arm.tip.p));
    for (int i = arm.joints() - 1; i >= 0; --i) {
        const link<T>& joint = arm.links[i];
        T rate = T(0), stroke = T(0);
        for (int k = 0; k < arm.coordinates(); ++k) {
            const T share = absolute(arm.coupling[i][k]);
            rate += share;
            stroke += share * greatest(absolute(found.start_lower[k]), absolute(found.start_upper[k]));
        }
        found.most_speed += rate * (absolute(joint.turn) * radius + absolute(joint.slide));
        found.most_turning += rate * absolute(joint.turn);
        radius += absolute(joint.slide) * stroke + (i > 0 ? sqrt(dot(joint.offset, joint.offset)) : T(0));
    }
}
}  // namespace detail

/// Start `restart` of a sequence, element k at theta[k · stride]: spread over the ranges of random starts.
template <class T, int N>
TWISTARM_INLINE void start_at(const ranges<T, N>& range, int coordinates, const start_sequence<N>& sequence, int restart,
                              T* theta, int stride = 1) {
    for (int k = 0; k < coordinates; ++k) {
        const T part = spread<T>(sequence.shift[k], static_cast<std::uint64_t>(restart), range.start_stride[k]);
        theta[k * stride] = range.start_lower[k] + part * (range.start_upper[k] - range.start_lower[k]);
    }
}

/// Start `restart` of a seed.
template <class T, int N>
TWISTARM_INLINE void random_start(const ranges<T, N>& range, int coordinates, std::uint64_t seed, int restart, T* theta,
                                  int stride = 1) {
    start_at(range, coordinates, sequence_of<N>(seed, coordinates), restart, theta, stride);
}

template <class T, int N, int M> void see_starts(const chain<T, N, M>& arm, ranges<T, N>& found) {
    for (int s = 0; s < seen_starts; ++s) {
        T theta[capacity(N)], rows[16];
        random_start(found, arm.coordinates(), 0, s + 1, theta);
        frame_to_rows(forward(arm, theta), rows);
        for (int r = 0; r < 12; ++r) found.seen[r][s] = static_cast<float>(rows[r]);
    }
}

/// The ranges of a chain; each array (N,), random starts in [start_lower, start_upper].
template <class T, int N, int M>
ranges<T, N> ranges_of(const chain<T, N, M>& arm, const double* lower, const double* upper, const double* start_lower,
                       const double* start_upper) {
    ranges<T, N> found{};
    find_periodic(arm, found.periodic);
    found.all_turn = true;
    for (int k = 0; k < arm.coordinates(); ++k) {
        found.lower[k] = static_cast<T>(lower[k]);
        found.upper[k] = static_cast<T>(upper[k]);
        found.start_lower[k] = static_cast<T>(start_lower[k]);
        found.start_upper[k] = static_cast<T>(start_upper[k]);
        found.start_stride[k] = stride_of(arm.coordinates(), k);
        found.turns[k] = found.periodic[k] && upper[k] - lower[k] >= whole_turn;
        found.all_turn = found.all_turn && found.turns[k];
    }
    detail::find_most_velocity(arm, found);
    see_starts(arm, found);
    return found;
}

/// A configuration inside the limits: shifted by whole turns if that has no effect and suffices, otherwise cut to the
/// bound.
template <class T, int N> inline void bring_inside(const ranges<T, N>& range, int coordinates, T* theta) {
    for (int k = 0; k < coordinates; ++k) {
        if (range.periodic[k]) {
            const T turned = detail::turned_back(theta[k], range.lower[k], range.upper[k]);
            if (turned >= range.lower[k] && turned <= range.upper[k]) theta[k] = turned;
        }
        theta[k] = clamped(theta[k], range.lower[k], range.upper[k]);
    }
}

/// A configuration with every freely turning coordinate at its representative inside the limits nearest to `near`.
template <class T, int N> inline void wrap_near(const ranges<T, N>& range, int coordinates, const T* near, T* theta) {
    for (int k = 0; k < coordinates; ++k) {
        if (!range.turns[k]) continue;
        const double turns = __builtin_rint(static_cast<double>(near[k] - theta[k]) / whole_turn);
        const T nearest = static_cast<T>(static_cast<double>(theta[k]) + whole_turn * turns);
        const T back = detail::turned_back(nearest, range.lower[k], range.upper[k]);
        theta[k] = clamped(back, range.lower[k], range.upper[k]);
    }
}

/// Whether every coordinate is finite and within its limits.
template <class T, int N> inline bool is_inside(const ranges<T, N>& range, int coordinates, const T* theta) {
    for (int k = 0; k < coordinates; ++k)
        if (!(theta[k] >= range.lower[k] && theta[k] <= range.upper[k] && theta[k] - theta[k] == T(0))) return false;
    return true;
}

TWISTARM_END
