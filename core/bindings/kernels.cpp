// The kernels for one instruction set. Compiled several times, each with its own flags and the name TWISTARM_KERNELS.
//
// Nothing of the standard library's templates may be used here: their code would carry this file's instructions under
// a name that the rest of the program shares.
#include "kernels.hpp"

#include "twistarm/answer.hpp"
#include "twistarm/batch.hpp"
#include "twistarm/conversion.hpp"
#include "twistarm/race.hpp"

#define TWISTARM_TEXT_OF(name) #name
#define TWISTARM_TEXT(name) TWISTARM_TEXT_OF(name)

namespace {

using namespace twistarm;
using bindings::Answer;
using bindings::Batch;
using bindings::Query;
using bindings::Question;

using general_chain = chain<double, dynamic, dynamic>;

// -- forward kinematics ----------------------------------------------------------------------------------------------

template <class V> void write_pose(const frame<V>& g, int count, double* poses) {
    for (int l = 0; l < count; ++l, poses += 16) {
        for (int k = 0; k < 3; ++k) {
            poses[4 * k] = lane(g.x[k], l);
            poses[4 * k + 1] = lane(g.y[k], l);
            poses[4 * k + 2] = lane(g.z[k], l);
            poses[4 * k + 3] = lane(g.p[k], l);
            poses[12 + k] = 0.0;
        }
        poses[15] = 1.0;
    }
}

template <class V> void write_jacobian(const column<V>* columns, int n, int count, double* J) {
    for (int l = 0; l < count; ++l, J += 6 * n)
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < 3; ++k) {
                J[k * n + i] = lane(columns[i].v[k], l);
                J[(k + 3) * n + i] = lane(columns[i].w[k], l);
            }
}

using eight = pack<double, lanes_in_round>;

// Eight configurations side by side, of which `count` are there. One alone goes the same way, so that it gets the bits
// that it would have got among others.
template <int N>
void several(const chain<double, N, N>& arm, const double* theta, int count, double* poses, double* spatial,
             double* body) {
    const int n = arm.coordinates();
    eight x[capacity(N)];
    for (int i = 0; i < n; ++i) {
        x[i] = eight(theta[i]);
        for (int l = 1; l < count; ++l) set_lane(x[i], l, theta[l * n + i]);
    }
    column<eight> columns[capacity(N)];
    frame<eight> g;
    if (body != nullptr) {
        g = forward_with_body_jacobian(arm, x, columns);
        write_jacobian(columns, n, count, body);
    } else if (spatial == nullptr) {
        g = forward(arm, x);
    }
    if (spatial != nullptr) {
        g = forward_with_spatial_jacobian(arm, x, columns);
        write_jacobian(columns, n, count, spatial);
    }
    if (poses != nullptr) write_pose(g, count, poses);
}

template <int N>
void all(const chain<double, N, N>& arm, const double* theta, std::size_t count, double* poses, double* spatial,
         double* body) {
    constexpr std::size_t width = lanes_in_round;
    const std::size_t n = static_cast<std::size_t>(arm.coordinates());
    for (std::size_t first = 0; first < count; first += width) {
        const int there = static_cast<int>(count - first < width ? count - first : width);
        several(arm, theta + first * n, there, poses != nullptr ? poses + first * 16 : nullptr,
                spatial != nullptr ? spatial + first * 6 * n : nullptr, body != nullptr ? body + first * 6 * n : nullptr);
    }
}

// -- inverse kinematics ----------------------------------------------------------------------------------------------

target<double> target_from(int kind, const double* numbers) {
    switch (static_cast<target_kind>(kind)) {
        case target_kind::position: return position_target(numbers);
        case target_kind::approach: return approach_target(numbers, numbers + 3, numbers + 6);
        case target_kind::task:
            return task_target(frame_from_rows<double>(numbers), numbers + 16, numbers[22] != 0.0);
        case target_kind::pose: break;
    }
    return pose_target(frame_from_rows<double>(numbers));
}

search_settings<double> settings_of(const Query& query) {
    search_settings<double> settings;
    settings.position_tolerance = query.position_tolerance;
    settings.orientation_tolerance = query.orientation_tolerance;
    settings.searches = query.searches;
    return settings;
}

// When the time is up, for good.
struct Clock {
    const Query& query;
    bool up = false;
    bool operator()() { return up = up || query.stopped(query.clock); }
};

template <int N, int K> solution<double, K> resized(const solution<double, N>& found, int n) {
    solution<double, K> same;
    for (int k = 0; k < n; ++k) same.theta[k] = found.theta[k];
    same.position_error = found.position_error;
    same.orientation_error = found.orientation_error;
    same.iterations = found.iterations;
    same.restarts = found.restarts;
    same.converged = found.converged;
    same.start_error = found.start_error;
    return same;
}

template <int N> void copy(const solution<double, N>& found, int n, Answer& answer) {
    for (int k = 0; k < n; ++k) answer.theta[k] = found.theta[k];
    answer.position_error = found.position_error;
    answer.orientation_error = found.orientation_error;
    answer.iterations = found.iterations;
    answer.restarts = found.restarts;
    answer.stop = 0;
    answer.nearest = answer.has_unlimited = answer.other_branch = false;
}

// What comes after the searches. It is rare, so that one copy for chains of any size does for all.
class Conclusion {
public:
    Conclusion(const general_chain& arm, const ranges<double, dynamic>& range, double reach)
        : arm_(arm), range_(range), reach_(reach) {}

    // The answer where `found` is all of it; else what it takes to make it so. `ends` as in `conclude`.
    template <int N>
    void operator()(const Query& query, const Question& question, const solution<double, N>& found, const double* ends,
                    Clock& stopped, Answer& answer) const {
        const int n = arm_.coordinates();
        double start[bindings::most_joints];
        for (int k = 0; k < n; ++k) start[k] = question.theta0[k];
        bring_inside(range_, n, start);
        answer.start_moved = false;
        for (int k = 0; k < n; ++k) answer.start_moved = answer.start_moved || start[k] != question.theta0[k];
        if (question.posture == nullptr && !is_open(found, settings_of(query), start, n)) return copy(found, n, answer);
        make(query, question, resized<N, dynamic>(found, n), ends, stopped, answer);
    }

private:
    void make(const Query& query, const Question& question, const solution<double, dynamic>& found, const double* ends,
              Clock& stopped, Answer& answer) const;

    const general_chain& arm_;
    const ranges<double, dynamic>& range_;
    double reach_;
};

void Conclusion::make(const Query& query, const Question& question, const solution<double, dynamic>& found,
                      const double* ends, Clock& stopped, Answer& answer) const {
    twistarm::answer<double, dynamic> whole;
    conclude(arm_, range_, settings_of(query), target_from(query.kind, question.numbers), question.theta0, query.seed,
             reach_, question.posture, stopped, found, ends, found.restarts, whole);
    const int n = arm_.coordinates();
    copy(whole.found, n, answer);
    answer.stop = static_cast<int>(whole.stop);
    answer.nearest = whole.nearest;
    answer.other_branch = whole.other_branch;
    answer.has_unlimited = whole.has_unlimited;
    for (int k = 0; k < n && whole.has_unlimited; ++k) answer.unlimited[k] = whole.unlimited[k];
}

// Memory for a while.
struct Room {
    explicit Room(std::size_t size) : first(new double[size]) {}
    ~Room() { delete[] first; }
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    double* first;
};

// What `solve_batch` asks for and gives back.
template <int N> struct Job {
    const Query& query;
    const Batch& batch;
    const Conclusion& conclusion;
    std::size_t begin, end;
    int n;
    Clock clock;
    Room room;

    std::int64_t count() const { return static_cast<std::int64_t>(end - begin); }
    target<double> asked(std::int64_t t) const {
        return target_from(query.kind, question(t).numbers);
    }
    void start(std::int64_t t, double* theta) const {
        for (int k = 0; k < n; ++k) theta[k] = question(t).theta0[k];
    }
    std::uint64_t seed(std::int64_t) const { return query.seed; }
    double* ends(int lane) { return room.first + static_cast<std::size_t>(lane * n) * most_ends; }
    void store(std::int64_t t, const solution<double, N>& found, const double* ends) {
        Answer answer;
        conclusion(query, question(t), found, ends, clock, answer);
        batch.store(batch.owner, at(t), answer);
    }
    bool goes_on(std::int64_t) const { return batch.goes_on(batch.owner); }

private:
    std::size_t at(std::int64_t t) const { return begin + static_cast<std::size_t>(t); }
    Question question(std::int64_t t) const {
        const Question& first = batch.first;
        return {first.numbers + at(t) * bindings::numbers_of_kind[query.kind],
                first.theta0 + at(t) * batch.start_step,
                first.posture != nullptr ? first.posture + at(t) * batch.posture_step : nullptr};
    }
};

template <target_kind Kind, int N>
void solve_targets(const chain<double, N, N>& arm, const ranges<double, N>& range, const Conclusion& conclusion,
                   const Query& query, const Batch& batch, std::size_t begin, std::size_t end) {
    Job<N> job{query, batch, conclusion, begin, end, arm.coordinates(), {query},
               Room(static_cast<std::size_t>(lanes_in_round * arm.coordinates()) * most_ends)};
    solve_batch<Kind>(arm, range, settings_of(query), job);
}

template <target_kind Kind, int N>
void solve_target(const chain<double, N, N>& arm, const ranges<double, N>& range, const Conclusion& conclusion,
                  const Query& query, const Question& question, Answer& answer) {
    solution<double, N> found{};
    double ends[most_ends * capacity(N)];
    Clock clock{query};
    solve_kind<Kind>(arm, range, settings_of(query), target_from(query.kind, question.numbers), question.theta0,
                     query.seed, found, ends, most_ends, clock);
    conclusion(query, question, found, ends, clock, answer);
}

// -- one arm ---------------------------------------------------------------------------------------------------------

// Any arm.
class GeneralEngine : public bindings::Engine {
public:
    GeneralEngine(const general_chain& arm, const bindings::ArmNumbers& numbers)
        : arm_(arm),
          range_(ranges_of(arm, numbers.lower, numbers.upper, numbers.start_lower, numbers.start_upper)),
          conclusion_(arm_, range_, numbers.reach) {}

    void constants(bindings::Constants& out) const override {
        out.joints = arm_.joints();
        out.coordinates = arm_.coordinates();
        out.identity = arm_.identity;
        frame_to_rows(arm_.base, out.base);
        frame_to_rows(arm_.tip, out.tip);
        for (int i = 0; i < out.joints; ++i) {
            const link<double>& from = arm_.links[i];
            out.links[i] = {{from.offset[0], from.offset[1], from.offset[2]}, from.cos_alpha, from.sin_alpha, from.turn,
                            from.phase, from.slide, from.revolute};
            for (int k = 0; k < out.coordinates; ++k) out.coupling[i][k] = arm_.coupling[i][k];
        }
    }

    void kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                    double* body) const override {
        all(arm_, theta, count, poses, spatial, body);
    }

    void solve(const Query& query, const Question& question, Answer& answer) const override {
        switch (static_cast<target_kind>(query.kind)) {
            case target_kind::pose: return one<target_kind::pose>(query, question, answer);
            case target_kind::position: return one<target_kind::position>(query, question, answer);
            case target_kind::approach: return one<target_kind::approach>(query, question, answer);
            case target_kind::task: return one<target_kind::task>(query, question, answer);
        }
    }

    void solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const override {
        switch (static_cast<target_kind>(query.kind)) {
            case target_kind::pose: return many<target_kind::pose>(query, batch, begin, end);
            case target_kind::position: return many<target_kind::position>(query, batch, begin, end);
            case target_kind::approach: return many<target_kind::approach>(query, batch, begin, end);
            case target_kind::task: return many<target_kind::task>(query, batch, begin, end);
        }
    }

protected:
    template <target_kind Kind> void one(const Query& query, const Question& question, Answer& answer) const {
        solve_target<Kind>(arm_, range_, conclusion_, query, question, answer);
    }
    template <target_kind Kind>
    void many(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const {
        solve_targets<Kind>(arm_, range_, conclusion_, query, batch, begin, end);
    }

    const general_chain arm_;
    const ranges<double, dynamic> range_;
    const Conclusion conclusion_;
};

// An arm of N joints, each its own coordinate: code of its own for what is asked most, kinematics and poses.
template <int N> class FixedEngine final : public GeneralEngine {
public:
    FixedEngine(const general_chain& arm, const bindings::ArmNumbers& numbers)
        : GeneralEngine(arm, numbers), fixed_(narrowed<double, N, N>(arm)),
          within_(ranges_of(fixed_, numbers.lower, numbers.upper, numbers.start_lower, numbers.start_upper)) {}

    void kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                    double* body) const override {
        all(fixed_, theta, count, poses, spatial, body);
    }

    void solve(const Query& query, const Question& question, Answer& answer) const override {
        if (static_cast<target_kind>(query.kind) != target_kind::pose)
            return GeneralEngine::solve(query, question, answer);
        solve_target<target_kind::pose>(fixed_, within_, conclusion_, query, question, answer);
    }

    void solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const override {
        if (static_cast<target_kind>(query.kind) != target_kind::pose)
            return GeneralEngine::solve(query, batch, begin, end);
        solve_targets<target_kind::pose>(fixed_, within_, conclusion_, query, batch, begin, end);
    }

private:
    const chain<double, N, N> fixed_;
    const ranges<double, N> within_;
};

template <int N> bindings::Engine* engine_of(const general_chain& arm, const bindings::ArmNumbers& numbers) {
    if constexpr (N >= TWISTARM_SMALLEST_FIXED) {
        if (arm.identity && arm.joint_count == N) return new FixedEngine<N>(arm, numbers);
        return engine_of<N - 1>(arm, numbers);
    } else {
        return new GeneralEngine(arm, numbers);
    }
}

bindings::Engine* make(const bindings::ArmNumbers& numbers) {
    general_chain arm;
    const screw_model model{numbers.joints, numbers.coordinates, numbers.screws, numbers.home, numbers.coupling};
    return chain_from_screws(model, arm) ? engine_of<TWISTARM_LARGEST_FIXED>(arm, numbers) : nullptr;
}

}  // namespace

namespace bindings {
extern const Kernels TWISTARM_KERNELS;
const Kernels TWISTARM_KERNELS = {TWISTARM_TEXT(TWISTARM_KERNELS), make};
}  // namespace bindings
