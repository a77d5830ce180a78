// What comes after the searches of all engines, of one instruction set.
#include "engines.hpp"

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {

TWISTARM_SEARCHES(extern)

namespace engines {

void Conclusion::make(const Query& query, const Question& question, const double* theta0,
                      const solution<double, dynamic>& found, const double* ends, Clock& stopped,
                      Answer& answer) const {
    twistarm::answer<double, dynamic> whole;
    double there[most_joints];
    const double* posture = question.posture != nullptr ? reaches_.theta(question.posture, there) : nullptr;
    conclude(arm_, range_, settings(query), reaches_.asked(target_from(query.kind, question.numbers)), theta0, query.seed, 1.0,
             posture, stopped, found, ends, found.restarts, whole);
    copy(whole.found, answer);
    answer.stop = static_cast<int>(whole.stop);
    answer.nearest = whole.nearest;
    answer.other_branch = whole.other_branch;
    answer.has_unlimited = whole.has_unlimited;
    if (whole.has_unlimited) reaches_.back(whole.unlimited, false, answer.unlimited);
}

rotation_split<double> Conclusion::split(int kind, const double* numbers, const double* theta) const {
    double there[most_joints];
    return split_rotation(arm_, reaches_.asked(target_from(kind, numbers)), reaches_.theta(theta, there), 1.0);
}

}  // namespace engines
}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm
