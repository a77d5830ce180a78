// Instruction set for which this translation unit is compiled: the name of the inline namespace.
//
// Kernels are compiled once per instruction set: the same headers in several translation units with different flags.
// All of them are in an inline namespace with the set's name. Otherwise the linker keeps one copy of each inline
// function, and a machine without AVX-512 may run the wrong one.
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

#define TWISTARM_BEGIN namespace twistarm { inline namespace TWISTARM_INSTRUCTION_SET {
#define TWISTARM_END } }

// Small kernels, and those of one place. A call would put every pack through memory.
// WebAssembly is small before it is fast: there the compiler decides.
#if defined(__wasm__)
#define TWISTARM_INLINE inline
#else
#define TWISTARM_INLINE inline __attribute__((always_inline))
#endif

// Large kernels that several loops share. A call costs no time that shows, and saves a third of the compilation.
#define TWISTARM_CALLED __attribute__((noinline))

// Loops over joints and rows are short; unrolled, their arrays become registers. The pragma has a count instead of
// "full", because Clang then warns, in the user's file, of each loop with a run-time length.
#if defined(__wasm__)
#define TWISTARM_UNROLL
#elif defined(__clang__)
#define TWISTARM_UNROLL _Pragma("clang loop unroll_count(8)")
#else
#define TWISTARM_UNROLL _Pragma("GCC unroll 8")
#endif
