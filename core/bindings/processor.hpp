// Which of the instruction sets avx512, avx2, baseline this processor has.
#pragma once

namespace bindings {

// The best set that it has, counted from avx512; those after it, it has too.
inline int best_set() {
#ifdef __x86_64__
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return 2;
    const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
    return wide ? 0 : 1;
#else
    return 2;
#endif
}

}  // namespace bindings
