// Which copies of the kernels this processor can run.
#include "kernels.hpp"
#include "processor.hpp"

namespace bindings {

const Kernels* const* kernels() {
    static const Kernels* found[4] = {};
    if (found[0]) return found;
    [[maybe_unused]] const int best = best_set();
    int count = 0;
#ifdef TWISTARM_HAS_AVX512
    if (best <= 0) found[count++] = &avx512;
#endif
#ifdef TWISTARM_HAS_AVX2
    if (best <= 1) found[count++] = &avx2;
#endif
#ifdef TWISTARM_HAS_BASELINE
    found[count++] = &baseline;
#endif
    return found;
}

}  // namespace bindings
