// twistarm._core.Servo: one arm's servo as Python sees it.
#pragma once

#include "arrays.hpp"
#include "servo_numbers.hpp"

namespace bindings {

class Servo {
public:
    // The chain's screws (6, m), home (4, 4) and coupling (m, n); the limits of the motors' rows, C (k, n) and c (k,),
    // and of all rows (k + n,); unit and ready (n,).
    Servo(nb::handle screws, nb::handle home, nb::handle coupling, nb::handle C, nb::handle c, nb::handle lower,
          nb::handle upper, nb::handle velocity, nb::handle acceleration, nb::handle unit, nb::handle ready,
          double length, double below, double damping, bool stops);

    // near: None, or (k, n + 2) for k near pairs of bodies: how joints bring them closer, their room and their time.
    // Answers None, or (theta, theta_dot, held or None, cause, row, scale, lost, halted, position and angle that remain, period).
    nb::object step(nb::handle theta, nb::handle theta_dot, nb::handle held, int kind, unsigned flags,
                    nb::handle numbers, double dt, double period, nb::handle near) const;

private:
    using Near = twistarm::near_pairs<double, twistarm::dynamic>;

    bool read(nb::handle near, Near& pairs) const;
    nb::object row(const double* values, std::size_t count) const;

    ArmServo servo_;
    std::size_t n_;
    nb::object theta_shape_, six_, pose_;
};

}  // namespace bindings
