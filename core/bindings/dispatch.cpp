// Which copies of the kernels this processor can run.
#include "kernels.hpp"

namespace bindings {

const Kernels* const* kernels() {
    static const Kernels* found[4] = {};
    if (found[0]) return found;
    int count = 0;
#ifdef TWISTARM_DISPATCH_X86
    __builtin_cpu_init();
    const bool second = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (second && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        found[count++] = &avx512;
    if (second) found[count++] = &avx2;
#endif
    found[count] = &baseline;
    return found;
}

}  // namespace bindings
