// Arms at random, from turning, sliding and helical joints, with their forward kinematics as a product of exponentials.
#pragma once

#include "check.hpp"
#include "plain.hpp"
#include "twistarm/kinematics/conversion.hpp"

namespace tests {
using twistarm::most_joints;

/// plain: one joint for each coordinate. followers: two more, that follow coordinates (mimic). differential: two
/// coordinates move the last two joints together, as by bevel gears.
enum class wiring { plain, followers, differential };

/// How often joints slide or turn and slide, are parallel to an axis, or to the joint before them or nearly so.
constexpr double slides = 0.2, helical = 0.15, along_axis = 0.5, parallel = 0.2;

struct drawn_arm {
    int joints, coordinates;
    double twists[most_joints][6] = {}, screws[6 * most_joints], home[16], coupling[most_joints * most_joints] = {};

    drawn_arm(generator& random, int n, wiring wired) : joints(wired == wiring::followers ? n + 2 : n), coordinates(n) {
        for (int i = 0; i < joints; ++i) {
            draw(random, i);
            for (int k = 0; k < 6; ++k) screws[k * joints + i] = twists[i][k];
        }
        const double at_zero[6] = {0.3, -0.2, 0.5, 0.4, 0.9, -0.3};
        twistarm::frame_to_rows(to_frame<double>(exponential(at_zero, 1)), home);
        for (int i = 0; i < n; ++i) A(i, i) = 1.0;
        if (wired == wiring::followers) {
            A(n, 0) = -0.5;
            A(n + 1, n - 1) = 0.25;
        }
        if (wired == wiring::differential) {
            A(n - 2, n - 1) = 1.0;
            A(n - 1, n - 2) = -1.0;
        }
    }

    double& A(int joint, int coordinate) { return coupling[joint * coordinates + coordinate]; }

    twistarm::screw_model model() const { return {joints, coordinates, screws, home, coupling}; }

    /// Π exp(ξ̂ᵢ (A θ)ᵢ) · home.
    template <class S> matrix fk(const S* theta) const {
        matrix g = identity(), last{};
        for (int i = 0; i < joints; ++i) {
            real x = 0;
            for (int k = 0; k < coordinates; ++k) x += coupling[i * coordinates + k] * static_cast<real>(theta[k]);
            g = g * exponential(twists[i], x);
        }
        for (int i = 0; i < 16; ++i) last.a[i / 4][i % 4] = home[i];
        return g * last;
    }

private:
    void draw(generator& random, int i) {
        const double kind = random.uniform();
        double axis[3], point[3], moment[3];
        for (int k = 0; k < 3; ++k) {
            axis[k] = random.between(-1, 1);
            point[k] = random.between(-0.5, 0.5);
        }
        if (random.uniform() < along_axis)
            for (int k = 0; k < 3; ++k) axis[k] = k == i % 3 ? 1 : 0;
        if (i > 0 && random.uniform() < parallel)
            for (int k = 0; k < 3; ++k) axis[k] = twists[i - 1][3 + k] + (random.uniform() < 0.5 ? 1e-9 : 0.0);
        double size = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
        if (size < 0.1) axis[0] = axis[1] = 0, axis[2] = size = 1;
        for (double& component : axis) component /= size;
        const double turn = kind < slides ? 0 : 1, slide = kind < slides ? 1 : (kind < slides + helical ? 0.1 : 0);
        twistarm::cross(point, axis, moment);
        for (int k = 0; k < 3; ++k) {
            twists[i][k] = turn * moment[k] + slide * axis[k];
            twists[i][k + 3] = turn * axis[k];
        }
    }
};
}  // namespace tests
