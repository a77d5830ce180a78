// What a closed form says of a target that no search has reached: `decide` of src/twistarm/ik/certainty.py.
#pragma once

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "../bindings/kernels.hpp"

namespace wasm {

using namespace bindings;

// How far pose g (4, 4) misses a target of a kind that a page has [m], [rad].
struct Errors {
    double position = 0.0, orientation = 0.0;

    Errors(int kind, const double* target, const double* g) {
        for (int k = 0; k < 3; ++k) position = std::hypot(position, g[4 * k + 3] - target[kind == 0 ? 4 * k + 3 : k]);
        double R[3][3] = {}, axis[3] = {};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k) R[i][j] += target[4 * k + i] * g[4 * k + j];  // of a pose
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) axis[i] += g[4 * i + j] * target[6 + j];  // of an approach
        const double* const to = target + 3;
        double sine = 0.0, cosine = kind == 0 ? R[0][0] + R[1][1] + R[2][2] - 1.0 : 0.0;
        for (int i = 0, j = 1, k = 2; i < 3; ++i, j = (j + 1) % 3, k = (k + 1) % 3) {
            sine = std::hypot(sine, kind == 0 ? R[k][j] - R[j][k] : axis[j] * to[k] - axis[k] * to[j]);
            if (kind != 0) cosine += axis[i] * to[i];
        }
        if (kind != 1) orientation = std::atan2(sine, cosine);
    }
};

struct Arm {
    std::unique_ptr<Engine> engine;
    int n;
    double lower[most_joints], upper[most_joints], start_lower[most_joints], start_upper[most_joints];
    bool periodic[most_joints];

    Errors errors(int kind, const double* target, const double* theta) const {
        double g[16];
        engine->kinematics(theta, 1, g, nullptr, nullptr);
        return {kind, target, g};
    }
};

// exact: whether it finds every configuration. swept: the held joint that gives others for each value, or −1. decides:
// whether it is asked about targets that no search meets.
struct Form {
    std::unique_ptr<ClosedFormEngine> engine;
    std::vector<int> held;
    int swept;
    bool exact, decides;
};

constexpr int samples = 5;               // values of a swept joint, its bounds included
constexpr double exact = 1e-6, far = 1e-5, barely_outside = 1e-4;  // [m, rad], as in certainty.py
constexpr std::uint64_t other_seed = 0x5EED;
constexpr int blocked = 3;               // twistarm::stop_reason::blocked_by_limits

// Of what a closed form finds with each value of its swept joint: the nearest inside the limits, else the one that is
// least outside them.
struct Found {
    double best = std::numeric_limits<double>::infinity(), beyond = best, theta[most_joints] = {};
    int inside = 0, outside = 0, left = 0;

    void add(const Arm& arm, const Configurations& some) {
        inside += some.inside;
        outside += some.count - some.inside;
        left += some.left;
        for (int i = 0; i < some.count; ++i) {
            double row[most_joints], square = 0.0, most = 0.0;
            for (int k = 0; k < arm.n; ++k) {
                row[k] = some.rows[i * 2 * arm.n + k];
                if (i < some.inside) continue;
                const bool bounded = std::isfinite(arm.lower[k]) && std::isfinite(arm.upper[k]);
                const double middle = bounded ? 0.5 * (arm.lower[k] + arm.upper[k]) : 0.0, turn = 2.0 * std::acos(-1.0);
                if (arm.periodic[k]) row[k] += turn * std::nearbyint((middle - row[k]) / turn);
                const double off = std::fabs(row[k] - std::fmin(std::fmax(row[k], arm.lower[k]), arm.upper[k]));
                square += off * off;
                most = std::fmax(most, off);
            }
            if (i >= some.inside) beyond = std::fmin(beyond, most);
            const double rank = i < some.inside ? some.distance[i] - 1e6 : square;  // a distance is a share of a range
            if (!(rank < best)) continue;
            best = rank;
            for (int k = 0; k < arm.n; ++k) theta[k] = row[k];
        }
    }
};

// Corrects the answer. Returns whether it is certain that nothing inside the limits meets the target exactly.
inline bool decide(const Arm& arm, const Form* form, Query query, Question asked, Answer& answer) {
    if (answer.stop == 0 || answer.restarts <= 1) return false;
    if (form == nullptr || !form->decides) {
        if (answer.stop != blocked) return false;
        Answer again{};
        query.seed = other_seed;
        query.searches = answer.restarts;
        asked.posture = nullptr;
        arm.engine->solve(query, asked, again);
        if (again.stop == 0) answer = again;
        return false;
    }
    static Configurations some;
    Found found;
    for (int s = 0; s < (form->swept < 0 ? 1 : samples); ++s) {
        double held[most_joints];
        for (std::size_t h = 0; h < form->held.size(); ++h) {
            const int k = form->held[h];
            held[h] = std::fmin(std::fmax(asked.theta0[k], arm.lower[k]), arm.upper[k]);
            if (k == form->swept) held[h] = arm.start_lower[k] + s * (arm.start_upper[k] - arm.start_lower[k]) / (samples - 1);
        }
        form->engine->solve(asked.numbers, asked.theta0, held, std::fmin(query.position_tolerance, exact),
                            std::fmin(query.orientation_tolerance, exact), some);
        found.add(arm, some);
    }
    const bool misses = std::fmax(answer.position_error, answer.orientation_error) > far;
    if (found.inside > 0) {
        const Errors errors = arm.errors(query.kind, asked.numbers, found.theta);
        answer.position_error = errors.position;
        answer.orientation_error = errors.orientation;
        answer.stop = 0;
        answer.has_unlimited = answer.nearest = answer.other_branch = false;
    } else if (found.outside > 0) {
        bool known = answer.has_unlimited;
        if (known) {
            const Errors errors = arm.errors(query.kind, asked.numbers, answer.unlimited);
            known = errors.position <= query.position_tolerance && errors.orientation <= query.orientation_tolerance;
        }
        if (!known) {
            answer.stop = blocked;
            answer.has_unlimited = true;
        }
        for (int k = 0; k < arm.n && !known; ++k) answer.unlimited[k] = found.theta[k];
    }
    for (int k = 0; k < arm.n && found.inside > 0; ++k) answer.theta[k] = found.theta[k];
    return found.inside == 0 && form->exact && form->swept < 0 && found.left == 0 && found.beyond > barely_outside && misses;
}

}  // namespace wasm
