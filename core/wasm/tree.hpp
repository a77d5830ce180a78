// Poses of all links of an arm: a tree with branches and mimic joints. The chain to the tool is a part of it.
#pragma once

#include <cmath>
#include <vector>

#include "twistarm/kinematics/conversion.hpp"

namespace wasm {

using Motion = twistarm::frame<double>;

// exp(ξ q) of a twist ξ = (v, w). Source: MLS, equation (2.32) without a rotation, else (2.36).
inline Motion exponential(const double* twist, double q) {
    const double *v = twist, *w = twist + 3, turn = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    if (turn == 0.0) return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {q * v[0], q * v[1], q * v[2]}};
    const double u[3] = {w[0] / turn, w[1] / turn, w[2] / turn};
    const double sine = std::sin(turn * q), half = std::sin(0.5 * turn * q), rest = 2.0 * half * half;
    Motion g{};
    double* const column[3] = {g.x, g.y, g.z};
    for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) {
            const double hat = i == j ? 0.0 : (j - i + 3) % 3 == 1 ? -u[3 - i - j] : u[3 - i - j];
            column[j][i] = (i == j ? 1.0 - rest : 0.0) + sine * hat + rest * u[i] * u[j];
        }
    const double along = (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) * q;
    double point[3];  // of the axis
    for (int i = 0; i < 3; ++i) point[i] = (u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3]) / turn;
    for (int i = 0; i < 3; ++i) {
        g.p[i] = point[i] + along * u[i];
        for (int j = 0; j < 3; ++j) g.p[i] -= column[j][i] * point[j];
    }
    return g;
}

// Joint j maps to space E_j = E_parent exp(ξ_j a_j · x), parents first. Node k stands at E_base⁻¹ E_joint rest. These are
// the fields of `kinematics` in viewer/scene/kinematics.py.
struct Tree {
    struct Joint {
        int parent;  // -1 for none, as `joint` and `base`
        double screw[6];
    };
    struct Node {
        int joint;
        Motion rest;
    };
    int coordinates = 0, base = -1;
    std::vector<Joint> joints;
    std::vector<double> terms;  // a: (joints, coordinates)
    std::vector<Node> nodes;

    // Writes sixteen numbers a node, column by column, as WebGL takes them.
    void poses(const double* x, double* out) const {
        std::vector<Motion> moved;
        const double* term = terms.data();
        for (const Joint& joint : joints) {
            double q = 0.0;
            for (int i = 0; i < coordinates; ++i) q += *term++ * x[i];
            const Motion step = exponential(joint.screw, q);
            moved.push_back(joint.parent < 0 ? step : product(moved[static_cast<std::size_t>(joint.parent)], step));
        }
        for (const Node& node : nodes) {
            Motion g = node.joint < 0 ? node.rest : product(moved[static_cast<std::size_t>(node.joint)], node.rest);
            if (base >= 0) g = product(inverse(moved[static_cast<std::size_t>(base)]), g);
            for (const double* const column : {g.x, g.y, g.z, g.p}) {
                for (int r = 0; r < 3; ++r) *out++ = column[r];
                *out++ = column == g.p ? 1.0 : 0.0;
            }
        }
    }
};

}  // namespace wasm
