// Engines for arms with `smallest` to `largest` joints. They are 10 to 20 % faster than the general one.
#include "engines.hpp"

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {
namespace engines {
namespace {

constexpr int smallest = 5, largest = 7;

// An arm of N uncoupled joints. The most frequent calls, kinematics and poses, have code of their own.
template <int N> class FixedEngine final : public GeneralEngine {
public:
    FixedEngine(const Model& metres, const Model& in_reaches)
        : GeneralEngine(metres, in_reaches), fixed_(narrowed<double, N, N>(metres.arm)),
          scaled_(narrowed<double, N, N>(in_reaches.arm)),
          within_(ranges_from(scaled_, in_reaches.numbers)) {}

    void kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                    double* body) const override {
        all(fixed_, theta, count, poses, spatial, body);
    }

    void solve(const Query& query, const Question& question, Answer& answer) const override {
        if (static_cast<target_kind>(query.kind) != target_kind::pose)
            return GeneralEngine::solve(query, question, answer);
        solve_target<target_kind::pose>(scaled_, within_, conclusion_, query, question, answer);
    }

    void solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const override {
        if (static_cast<target_kind>(query.kind) != target_kind::pose)
            return GeneralEngine::solve(query, batch, begin, end);
        solve_targets<target_kind::pose>(scaled_, within_, conclusion_, query, batch, begin, end);
    }

    void find_reachable(const Query& query, const Chunk& chunk) const override {
        if (static_cast<target_kind>(query.kind) != target_kind::pose)
            return GeneralEngine::find_reachable(query, chunk);
        reach_targets<target_kind::pose>(scaled_, within_, conclusion_, query, chunk);
    }

private:
    const chain<double, N, N> fixed_;
    const chain<double, N, N> scaled_;
    const ranges<double, N> within_;
};

template <int N> Engine* engine_of(const Model& metres, const Model& in_reaches) {
    if (metres.arm.joint_count == N) return new FixedEngine<N>(metres, in_reaches);
    if constexpr (N > smallest) return engine_of<N - 1>(metres, in_reaches);
    return nullptr;
}

}  // namespace

Engine* fixed_engine(const Model& metres, const Model& in_reaches) { return engine_of<largest>(metres, in_reaches); }

}  // namespace engines
}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm
