// Which instruction set this translation unit is compiled for.
//
// Kernels are compiled once per instruction set, the same headers in several translation units with different flags.
// Everything stands in an inline namespace named after the set: the linker would otherwise keep one copy of each
// inline function for all of them, and a machine without AVX-512 might be handed the wrong one.
#pragma once

#if defined(__AVX512F__) && defined(__AVX512DQ__)
#define TWISTARM_INSTRUCTION_SET avx512
#define TWISTARM_REGISTER_BYTES 64
#elif defined(__AVX2__) && defined(__FMA__)
#define TWISTARM_INSTRUCTION_SET avx2
#define TWISTARM_REGISTER_BYTES 32
#else
#define TWISTARM_INSTRUCTION_SET portable
#define TWISTARM_REGISTER_BYTES 16
#endif

// Clang warns of each loop it cannot unroll, and where sizes are known only when the program runs it can unroll none.
#if defined(__clang__)
#define TWISTARM_QUIET _Pragma("clang diagnostic push") _Pragma("clang diagnostic ignored \"-Wpass-failed\"")
#define TWISTARM_LOUD _Pragma("clang diagnostic pop")
#else
#define TWISTARM_QUIET
#define TWISTARM_LOUD
#endif

#define TWISTARM_BEGIN TWISTARM_QUIET namespace twistarm { inline namespace TWISTARM_INSTRUCTION_SET {
#define TWISTARM_END } } TWISTARM_LOUD

// Kernels are small and called from one place each; a call would put every pack in them through memory.
#define TWISTARM_INLINE inline __attribute__((always_inline))

// Loops over joints and rows are short: unrolled, their arrays become registers.
#if defined(__clang__)
#define TWISTARM_UNROLL _Pragma("clang loop unroll(full)")
#else
#define TWISTARM_UNROLL _Pragma("GCC unroll 8")
#endif
