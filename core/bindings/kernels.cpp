// The engine of any arm, and what comes after the searches of all: of one instruction set.
#include "engines.hpp"

#define TWISTARM_TEXT_OF(name) #name
#define TWISTARM_TEXT(name) TWISTARM_TEXT_OF(name)

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {
namespace engines {

void Conclusion::make(const Query& query, const Question& question, const solution<double, dynamic>& found,
                      const double* ends, Clock& stopped, Answer& answer) const {
    twistarm::answer<double, dynamic> whole;
    conclude(arm_, range_, settings(query), target_from(query.kind, question.numbers), question.theta0, query.seed,
             reach_, question.posture, stopped, found, ends, found.restarts, whole);
    const int n = arm_.coordinates();
    copy(whole.found, n, answer);
    answer.stop = static_cast<int>(whole.stop);
    answer.nearest = whole.nearest;
    answer.other_branch = whole.other_branch;
    answer.has_unlimited = whole.has_unlimited;
    for (int k = 0; k < n && whole.has_unlimited; ++k) answer.unlimited[k] = whole.unlimited[k];
}

GeneralEngine::GeneralEngine(const general_chain& arm, const ArmNumbers& numbers)
    : arm_(arm), range_(ranges_of(arm, numbers.lower, numbers.upper, numbers.start_lower, numbers.start_upper)),
      conclusion_(arm_, range_, numbers) {}

void GeneralEngine::constants(Constants& out) const {
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

void GeneralEngine::kinematics(const double* theta, std::size_t count, double* poses, double* spatial,
                               double* body) const {
    all(arm_, theta, count, poses, spatial, body);
}

void GeneralEngine::solve(const Query& query, const Question& question, Answer& answer) const {
    with_kind(static_cast<target_kind>(query.kind), [&](auto kind) {
        solve_target<kind()>(arm_, range_, conclusion_, query, question, answer);
    });
}

void GeneralEngine::solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const {
    with_kind(static_cast<target_kind>(query.kind), [&](auto kind) {
        solve_targets<kind()>(arm_, range_, conclusion_, query, batch, begin, end);
    });
}

void GeneralEngine::find_reachable(const Query& query, const Chunk& chunk) const {
    with_kind(static_cast<target_kind>(query.kind), [&](auto kind) {
        reach_targets<kind()>(arm_, range_, conclusion_, query, chunk);
    });
}

void GeneralEngine::split_rotation(int kind, const double* numbers, const double* theta, double* split) const {
    const rotation_split<double> found = conclusion_.split(target_from(kind, numbers), theta);
    const double values[] = {found.impossible, found.prevented, found.axis[0], found.axis[1], found.axis[2]};
    for (int k = 0; k < 5; ++k) split[k] = values[k];
}

ClosedFormEngine* GeneralEngine::closed_form(const FamilyNumbers& family) const {
    switch (static_cast<target_kind>(family.kind)) {
        case target_kind::pose: return new ClosedForm<target_kind::pose, dynamic>(arm_, range_, family);
        case target_kind::position: return new ClosedForm<target_kind::position, dynamic>(arm_, range_, family);
        case target_kind::approach: return new ClosedForm<target_kind::approach, dynamic>(arm_, range_, family);
        case target_kind::task: break;
    }
    return nullptr;
}

static Engine* make(const ArmNumbers& numbers) {
    general_chain arm;
    const screw_model model{numbers.joints, numbers.coordinates, numbers.screws, numbers.home, numbers.coupling};
    if (!chain_from_screws(model, arm)) return nullptr;
    Engine* fixed = arm.identity ? fixed_engine(arm, numbers) : nullptr;
    return fixed != nullptr ? fixed : new GeneralEngine(arm, numbers);
}

}  // namespace engines
}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm

namespace bindings {
extern const Kernels TWISTARM_KERNELS;
const Kernels TWISTARM_KERNELS = {TWISTARM_TEXT(TWISTARM_KERNELS), twistarm::engines::make};
}  // namespace bindings
