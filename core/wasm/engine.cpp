// No copy of the engine for each number of joints: three would triple the file.
#include "../bindings/engines.hpp"

namespace twistarm {
inline namespace TWISTARM_INSTRUCTION_SET {
namespace engines {

Engine* fixed_engine(const Model&, const Model&) { return nullptr; }

}  // namespace engines
}  // namespace TWISTARM_INSTRUCTION_SET
}  // namespace twistarm
