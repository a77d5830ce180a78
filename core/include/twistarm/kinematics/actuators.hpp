// Joints to motors and back, motor = G θ + o, and what the motors' drives count.
#pragma once

#include "../numeric/instruction_set.hpp"

TWISTARM_BEGIN

/// K motors that drive N coordinates: geared, belted and differential joints. Both sides in rad, or m where they slide.
///
/// P G = I. If the motors leave a coordinate undriven, P does not exist and `Determined` is false. Arrays have N joints
/// and K motors and must not overlap. Motor counts are not rounded.
template <class T, int N, int K, bool Determined = true> struct actuators {
    T G[K][N], offset[K], P[N][K];
    T counts_per_unit[K];  ///< of a motor's rad or m

    /// motor = G θ + o.
    constexpr void to_motor(const T* theta, T* motor) const {
        velocity_to_motor(theta, motor);
        for (int i = 0; i < K; ++i) motor[i] += offset[i];
    }
    /// θ with G θ + o = motor; of more motors than joints the least squares.
    constexpr void to_theta(const T* motor, T* theta) const {
        T unshifted[K] = {};
        for (int i = 0; i < K; ++i) unshifted[i] = motor[i] - offset[i];
        velocity_to_theta(unshifted, theta);
    }
    /// The rates of the motors, G θ̇; accelerations alike.
    constexpr void velocity_to_motor(const T* theta_dot, T* motor_dot) const {
        for (int i = 0; i < K; ++i) {
            motor_dot[i] = T(0);
            for (int k = 0; k < N; ++k) motor_dot[i] += G[i][k] * theta_dot[k];
        }
    }
    /// The rates of the joints, P motor_dot; accelerations alike.
    constexpr void velocity_to_theta(const T* motor_dot, T* theta_dot) const {
        static_assert(Determined, "these motors leave a joint undriven, so theta does not follow from them: describe "
                                  "the motors that drive it in [actuators], and bake again");
        for (int k = 0; k < N; ++k) {
            theta_dot[k] = T(0);
            for (int i = 0; i < K; ++i) theta_dot[k] += P[k][i] * motor_dot[i];
        }
    }
    /// What the drives count where the motors stand there; rates alike, for counts per second.
    constexpr void to_counts(const T* motor, T* counts) const {
        for (int i = 0; i < K; ++i) counts[i] = motor[i] * counts_per_unit[i];
    }
    /// Where the motors stand when the drives count that; rates alike.
    constexpr void from_counts(const T* counts, T* motor) const {
        for (int i = 0; i < K; ++i) motor[i] = counts[i] / counts_per_unit[i];
    }
};

TWISTARM_END
