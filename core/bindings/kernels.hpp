// What each instruction set's copy of the kernels offers: plain structures and one interface, no templates.
#pragma once

#include <cstddef>
#include <cstdint>

namespace bindings {

constexpr int most_joints = 64;

// An arm as numbers, all row-major. Bounds (coordinates,) are infinite without limits, except those of the random
// starts.
struct ArmNumbers {
    int joints, coordinates;
    const double *screws, *home, *coupling, *lower, *upper, *start_lower, *start_upper;
    double reach;  // [m]: the unit of length of inverse kinematics
};

// Kinds of targets, in the order of twistarm::target_kind, and how many numbers each is written with:
// g (16) | p (3) | p, direction, tool axis (9) | g, six tolerances, 1 for base axes (23).
constexpr int kinds = 4;
constexpr std::size_t numbers_of_kind[kinds] = {16, 3, 9, 23}, most_numbers = 23;

// Settings of a solver, without the target.
struct Query {
    int kind;
    double position_tolerance, orientation_tolerance;
    int searches;
    std::uint64_t seed;
    bool (*stopped)(const void* clock);
    const void* clock;
};

struct Answer {
    double theta[most_joints], unlimited[most_joints];
    double position_error, orientation_error;
    int iterations, restarts, stop;
    bool nearest, has_unlimited, other_branch, start_moved;
};

// One target: its numbers, its start and where the arm would rather stand (null: nowhere).
struct Question {
    const double *numbers, *theta0, *posture;
};

// Targets of one kind, and where their answers go. What they share has a step of 0.
struct Batch {
    Question first;
    std::size_t start_step, posture_step;
    void (*store)(void* owner, std::size_t t, const Answer& answer);
    bool (*goes_on)(void* owner);
    void* owner;
};

// Targets of one kind that follow one another, and where their verdicts go: converged (count,), theta (count, n).
struct Chunk {
    const double *numbers, *theta0;
    std::size_t count;
    bool* converged;
    double* theta;
};

// The kernels' form of screws and home (twistarm::chain): base · T(offset) Rx(alpha) Rz(turn x + phase) Tz(slide x) … ·
// tip. Poses are (4, 4), coupling is (joints, coordinates).
struct Constants {
    struct Link {
        double offset[3], cos_alpha, sin_alpha, turn, phase, slide;
        bool revolute;
    };
    int joints, coordinates;
    bool identity;
    double base[16], tip[16], coupling[most_joints][most_joints];
    Link links[most_joints];
};

// The recognised family of an arm for one kind of target (twistarm::solved_arm), as numbers.
struct FamilyNumbers {
    int kind, count, first, last;
    int keeps;                   // twistarm::closed_form::keeps
    const double *axes, *kept;   // (count, 7): w, o, 1 for a slide; a point and 0, or a normal and d
    const int* joint;            // (count,)
    int held_count;
    const int* held;             // (held_count,)
    const double *held_axes, *rate, *home;  // (held_count, 7), (coordinates,), (4, 4)
    std::uint64_t idle;
};

constexpr int most_configurations = 32, most_candidates = 64;

// Every configuration for one target: theta (n) and, as 0 and 1, which coordinates may move (n), row by row.
struct Configurations {
    double rows[most_configurations * 2 * most_joints], distance[most_configurations];
    int count, inside, left, families;  // families: of a continuous family; left: those of them outside
};

// The closed form of one arm's family.
class ClosedFormEngine {
public:
    virtual ~ClosedFormEngine() = default;
    // held: values of the held joints, or null: those of `near`.
    virtual void solve(const double* numbers, const double* near, const double* held, double position_tolerance,
                       double orientation_tolerance, Configurations& found) const = 0;
    // What forward kinematics finds among candidates (count, n). All have held joints at the values of the first.
    virtual void verify(const double* numbers, const double* near, const double* rows, std::size_t count,
                        double position_tolerance, double orientation_tolerance, Configurations& found) const = 0;
    // The nth list of candidates that nobody has verified: rows (most_candidates, n), and how many there are. The next
    // list has the joints in `open`, as bits, elsewhere. The last list leaves none open.
    virtual int candidates(const double* numbers, const double* near, const double* held, double slack, int nth,
                           unsigned& open, double* rows) const = 0;
};

// One arm, its chain in the form and the instructions that suit it best.
class Engine {
public:
    virtual ~Engine() = default;
    virtual void constants(Constants& out) const = 0;
    // Poses (count, 4, 4), spatial and body Jacobians (count, 6, n) of configurations (count, n); null: not wanted.
    virtual void kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                            double* body) const = 0;
    virtual void solve(const Query& query, const Question& question, Answer& answer) const = 0;
    virtual void solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const = 0;
    // Which of the targets are reached; NaN for theta where one is not.
    virtual void find_reachable(const Query& query, const Chunk& chunk) const = 0;
    // The rotation error of a target at theta: its impossible part, its prevented part, and an axis (3,) of the tool.
    virtual void split_rotation(int kind, const double* numbers, const double* theta, double* split) const = 0;
    // It must not outlive this engine.
    virtual ClosedFormEngine* closed_form(const FamilyNumbers& family) const = 0;
};

struct Kernels {
    const char* name;
    // The engine of an arm, or null if it does not fit into one.
    Engine* (*make)(const ArmNumbers& arm);
};

// What this processor can run, best first; ends with a null pointer.
const Kernels* const* kernels();

extern const Kernels baseline, avx2, avx512;

}  // namespace bindings
