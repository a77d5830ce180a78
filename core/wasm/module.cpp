// The core as WebAssembly: one module for any arm, which is given as numbers. An instance holds one arm.
//
// JavaScript writes what it asks into `numbers` and reads the answer there, both as doubles in the order that each
// function states. Whole numbers and truth values are doubles too. What makes a thing returns 1, or 0 if it does not fit.
#include <memory>
#include <vector>

#include "../bindings/kernels.hpp"
#include "../bindings/servo_numbers.hpp"
#include "certainty.hpp"
#include "tree.hpp"

#include "twistarm/ik/ranges.hpp"

#define EXPORTED(name) extern "C" __attribute__((export_name(#name), visibility("default")))

namespace {

using namespace bindings;

constexpr std::size_t least_room = 1 << 13;  // holds what is asked and answered but by a large tree
std::vector<double> shared(least_room);

// Numbers in turn.
struct Read {
    const double* at = shared.data();

    const double* many(int count) {
        const double* const first = at;
        at += count;
        return first;
    }
    double one() { return *at++; }
    int whole() { return static_cast<int>(one()); }
    bool flag() { return one() != 0.0; }
};

struct Write {
    double* at = shared.data();

    void one(double value) { *at++ = value; }
    void many(const double* values, int count) {
        for (int i = 0; i < count; ++i) *at++ = values[i];
    }
    void row(std::initializer_list<double> values) {
        for (const double value : values) one(value);
    }
};

wasm::Arm arm;
std::unique_ptr<wasm::Form> forms[kinds];
std::unique_ptr<ArmServo> servo;
wasm::Tree tree;

bool never(const void*) { return false; }

}  // namespace

// Where the numbers lie: at least `count` of them. It may have moved since the last call.
EXPORTED(numbers) double* numbers(std::size_t count) {
    if (count > shared.size()) shared.resize(count);
    return shared.data();
}

// joints m, coordinates n, screws (6, m), home (4, 4), coupling (m, n), lower, upper, least and greatest of random
// starts (n,), reach [m].
EXPORTED(arm) int make_arm() {
    Read in;
    ArmNumbers given{};
    const int m = given.joints = in.whole(), n = given.coordinates = in.whole();
    given.screws = in.many(6 * m);
    given.home = in.many(16);
    given.coupling = in.many(m * n);
    given.lower = in.many(n);
    given.upper = in.many(n);
    given.start_lower = in.many(n);
    given.start_upper = in.many(n);
    given.reach = in.one();
    arm.engine.reset(baseline.make(given));
    if (arm.engine == nullptr) return 0;
    twistarm::chain<double, twistarm::dynamic, twistarm::dynamic> chain{};
    twistarm::chain_from_screws({m, n, given.screws, given.home, given.coupling}, chain);
    twistarm::find_periodic(chain, arm.periodic);
    arm.n = n;
    for (int k = 0; k < n; ++k) {
        arm.lower[k] = given.lower[k];
        arm.upper[k] = given.upper[k];
        arm.start_lower[k] = given.start_lower[k];
        arm.start_upper[k] = given.start_upper[k];
    }
    return 1;
}

// theta (n,) → pose (4, 4), spatial and body Jacobian (6, n).
EXPORTED(kinematics) void kinematics() {
    double theta[most_joints];
    for (int k = 0; k < arm.n; ++k) theta[k] = shared[static_cast<std::size_t>(k)];
    double* const out = shared.data();
    arm.engine->kinematics(theta, 1, out, out + 16, out + 16 + 6 * arm.n);
}

// kind, tolerances [m], [rad], searches, 1 for a posture, the target's numbers (23,), theta0 (n,), posture (n,) → stop,
// nearest, other_branch, certain, has_unlimited, errors [m], [rad], iterations, restarts, theta (n,), unlimited (n,).
EXPORTED(solve) void solve() {
    Read in;
    Query query{};
    query.kind = in.whole();
    query.position_tolerance = in.one();
    query.orientation_tolerance = in.one();
    query.searches = in.whole();
    query.stopped = never;
    const bool posed = in.flag();
    Question question{};
    question.numbers = in.many(most_numbers);
    question.theta0 = in.many(arm.n);
    question.posture = posed ? in.many(arm.n) : nullptr;
    Answer answer{};
    arm.engine->solve(query, question, answer);
    const bool certain = wasm::decide(arm, forms[query.kind].get(), query, question, answer);
    Write out;
    out.row({double(answer.stop), double(answer.nearest), double(answer.other_branch), double(certain),
             double(answer.has_unlimited), answer.position_error, answer.orientation_error, double(answer.iterations),
             double(answer.restarts)});
    out.many(answer.theta, arm.n);
    if (answer.has_unlimited) out.many(answer.unlimited, arm.n);
}

// kind, the target's numbers (23,), theta (n,) → the impossible and the prevented part of the rotation error [rad], and
// an axis (3,).
EXPORTED(split) void split() {
    Read in;
    const int kind = in.whole();
    const double* const target = in.many(most_numbers);
    double parts[5];
    arm.engine->split_rotation(kind, target, in.many(arm.n), parts);
    Write().many(parts, 5);
}

// The fields of Form, decides, exact, swept, and of FamilyNumbers: kind, count, first, last, keeps, held count, axes
// (count, 7), kept (4,), joint (count,), held, held axes (7), rate (n,), home (4, 4), idle (n,).
EXPORTED(closed_form) int make_closed_form() {
    Read in;
    auto form = std::make_unique<wasm::Form>();
    form->decides = in.flag();
    form->exact = in.flag();
    form->swept = in.whole();
    FamilyNumbers family{};
    family.kind = in.whole();
    family.count = in.whole();
    family.first = in.whole();
    family.last = in.whole();
    family.keeps = in.whole();
    family.held_count = in.whole();
    family.axes = in.many(7 * family.count);
    family.kept = in.many(4);
    std::vector<int> joint;
    for (int i = 0; i < family.count; ++i) joint.push_back(in.whole());
    for (int i = 0; i < family.held_count; ++i) form->held.push_back(in.whole());
    family.joint = joint.data();
    family.held = form->held.data();
    family.held_axes = in.many(7 * family.held_count);
    family.rate = in.many(arm.n);
    family.home = in.many(16);
    for (int k = 0; k < arm.n; ++k) family.idle |= static_cast<std::uint64_t>(in.flag()) << k;
    form->engine.reset(arm.engine->closed_form(family));
    const bool made = form->engine != nullptr;
    if (made) forms[family.kind] = std::move(form);
    return made;
}

// kind, tolerances [m], [rad], the target's numbers (23,), near (n,) → count, inside, families; for each theta (n,) and
// which coordinates may move (n,). Held joints stay where `near` has them.
EXPORTED(configurations) void configurations() {
    Read in;
    const int kind = in.whole();
    const double position = in.one(), orientation = in.one();
    const double* const target = in.many(most_numbers);
    static Configurations found;
    forms[kind]->engine->solve(target, in.many(arm.n), nullptr, position, orientation, found);
    Write out;
    out.row({double(found.count), double(found.inside), double(found.families)});
    out.many(found.rows, found.count * 2 * arm.n);
}

// The fields of ServoNumbers: joints m, coordinates n, motors k, length, below, damping, screws (6, m), home (4, 4),
// coupling (m, n), C (k, n), c (k,), lower, upper, velocity, acceleration (k + n,), unit, ready (n,).
EXPORTED(servo) int make_servo() {
    Read in;
    ServoNumbers given{};
    given.joints = in.whole();
    given.coordinates = in.whole();
    given.motors = in.whole();
    given.length = in.one();
    given.below = in.one();
    given.damping = in.one();
    const int m = given.joints, n = given.coordinates, k = given.motors;
    given.screws = in.many(6 * m);
    given.home = in.many(16);
    given.coupling = in.many(m * n);
    given.C = in.many(k * n);
    given.c = in.many(k);
    for (const double*& limits : given.limits) limits = in.many(k + n);
    given.unit = in.many(n);
    given.ready = in.many(n);
    servo = std::make_unique<ArmServo>();
    return servo->read(given);
}

// 1 to stop where the command cannot be followed, kind, flags, dt, period, 1 for a held pose, the command's numbers,
// theta, theta_dot (n,), held (4, 4) → cause, row, scale, lost share, halted, remaining [m], [rad], period, lost (6,),
// theta, theta_dot (n,), held (4, 4).
EXPORTED(servo_step) void servo_step() {
    const int n = servo->bounds.motion.coordinates;
    Read in;
    servo->bounds.stops = in.flag();
    const auto kind = static_cast<twistarm::servo_kind>(in.whole());
    const unsigned flags = static_cast<unsigned>(in.whole());
    const double dt = in.one(), period = in.one();
    const bool holding = in.flag();
    const ServoCommand command = servo->command(kind, flags, in.many(servo->width(kind)));
    const double *const theta = in.many(n), *const theta_dot = in.many(n);
    ServoState state = servo->state(command, theta, theta_dot, holding ? in.many(16) : nullptr, period);
    twistarm::servo_output<double> result;
    twistarm::servo_step(servo->chain, servo->bounds, command, dt, state, result);
    Write out;
    out.row({double(static_cast<int>(result.cause)), double(result.row), result.scale, result.lost_share,
             double(result.halted), result.remaining[0], result.remaining[1], state.period});
    out.many(result.lost, 6);
    out.many(state.theta, n);
    out.many(state.theta_dot, n);
    double held[16];
    twistarm::frame_to_rows(state.held, held);
    out.many(held, 16);
}

// coordinates, base, joints, nodes; for each joint its parent, screw (6,) and terms (coordinates,); for each node its
// joint and its pose at rest (4, 4) by columns.
EXPORTED(tree) void make_tree() {
    Read in;
    tree = {};
    tree.coordinates = in.whole();
    tree.base = in.whole();
    const int joints = in.whole(), nodes = in.whole();
    for (int j = 0; j < joints; ++j) {
        wasm::Tree::Joint joint{in.whole(), {}};
        for (double& part : joint.screw) part = in.one();
        tree.joints.push_back(joint);
        for (int i = 0; i < tree.coordinates; ++i) tree.terms.push_back(in.one());
    }
    for (int k = 0; k < nodes; ++k) {
        wasm::Tree::Node node{in.whole(), {}};
        for (double* const column : {node.rest.x, node.rest.y, node.rest.z, node.rest.p}) {
            for (int r = 0; r < 3; ++r) column[r] = in.one();
            in.one();
        }
        tree.nodes.push_back(node);
    }
}

// x (coordinates,) → the pose (4, 4) of each node by columns.
EXPORTED(poses) void poses() {
    const std::vector<double> x(shared.data(), shared.data() + tree.coordinates);
    tree.poses(x.data(), shared.data());
}
