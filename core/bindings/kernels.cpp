// The engine of any arm, of one instruction set.
#include "engines.hpp"

#define TWISTARM_TEXT_OF(name) #name
#define TWISTARM_TEXT(name) TWISTARM_TEXT_OF(name)

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {

TWISTARM_SEARCHES()

namespace engines {

GeneralEngine::GeneralEngine(const Model& metres, const Model& in_reaches)
    : arm_(metres.arm), range_(ranges_from(arm_, metres.numbers)), scaled_(in_reaches.arm),
      within_(ranges_from(scaled_, in_reaches.numbers)), reaches_(units_of(metres)),
      conclusion_(scaled_, within_, reaches_) {}

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
        solve_target<kind()>(scaled_, within_, conclusion_, query, question, answer);
    });
}

void GeneralEngine::solve(const Query& query, const Batch& batch, std::size_t begin, std::size_t end) const {
    with_kind(static_cast<target_kind>(query.kind), [&](auto kind) {
        solve_targets<kind()>(scaled_, within_, conclusion_, query, batch, begin, end);
    });
}

void GeneralEngine::find_reachable(const Query& query, const Chunk& chunk) const {
    with_kind(static_cast<target_kind>(query.kind), [&](auto kind) {
        reach_targets<kind()>(scaled_, within_, conclusion_, query, chunk);
    });
}

void GeneralEngine::split_rotation(int kind, const double* numbers, const double* theta, double* split) const {
    const rotation_split<double> found = conclusion_.split(kind, numbers, theta);
    const double values[] = {found.impossible, found.prevented, found.axis[0], found.axis[1], found.axis[2]};
    for (int k = 0; k < 5; ++k) split[k] = values[k];
}

ClosedFormEngine* GeneralEngine::closed_form(const FamilyNumbers& family) const {
    switch (static_cast<target_kind>(family.kind)) {
        case target_kind::pose: return new ClosedForm<target_kind::pose>(arm_, range_, family);
        case target_kind::position: return new ClosedForm<target_kind::position>(arm_, range_, family);
        case target_kind::approach: return new ClosedForm<target_kind::approach>(arm_, range_, family);
        case target_kind::task: break;
    }
    return nullptr;
}

// The numbers of the same arm in reaches.
struct Scaled {
    double screws[6 * most_joints], home[16], coupling[most_joints * most_joints], bounds[4][most_joints];
    ArmNumbers numbers;

    Scaled(const ArmNumbers& metres, const Reaches& units) : numbers(metres) {
        const double unit = units.metres;
        const int joints = metres.joints, n = metres.coordinates;
        for (int i = 0; i < 6 * joints; ++i) screws[i] = i < 3 * joints ? metres.screws[i] / unit : metres.screws[i];
        for (int i = 0; i < 16; ++i) home[i] = i < 12 && i % 4 == 3 ? metres.home[i] / unit : metres.home[i];
        const double* const from[4] = {metres.lower, metres.upper, metres.start_lower, metres.start_upper};
        for (int k = 0; k < n; ++k) {
            for (int i = 0; i < joints; ++i) coupling[i * n + k] = metres.coupling[i * n + k] * units.unit[k];
            for (int b = 0; b < 4; ++b) bounds[b][k] = from[b][k] * units.per_unit[k];
        }
        numbers.screws = screws;
        numbers.home = home;
        numbers.coupling = coupling;
        numbers.lower = bounds[0];
        numbers.upper = bounds[1];
        numbers.start_lower = bounds[2];
        numbers.start_upper = bounds[3];
        numbers.reach = 1.0;
    }
};

static bool chain_of(const ArmNumbers& numbers, general_chain& arm) {
    return chain_from_screws({numbers.joints, numbers.coordinates, numbers.screws, numbers.home, numbers.coupling}, arm);
}

static Engine* make(const ArmNumbers& numbers) {
    Model metres{{}, numbers};
    if (numbers.joints > most_joints || numbers.coordinates > most_joints || !chain_of(numbers, metres.arm)) return nullptr;
    const Scaled scaled(numbers, units_of(metres));
    Model in_reaches{{}, scaled.numbers};
    if (!chain_of(scaled.numbers, in_reaches.arm)) return nullptr;
    Engine* fixed = metres.arm.identity && in_reaches.arm.identity ? fixed_engine(metres, in_reaches) : nullptr;
    return fixed != nullptr ? fixed : new GeneralEngine(metres, in_reaches);
}

}  // namespace engines
}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm

namespace bindings {
extern const Kernels TWISTARM_KERNELS;
const Kernels TWISTARM_KERNELS = {TWISTARM_TEXT(TWISTARM_KERNELS), twistarm::engines::make};
}  // namespace bindings
