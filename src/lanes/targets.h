#pragma once

/// TACTILE_CLAY_MULTIVERSION in front of a function compiles it for any x86-64, for AVX2, and (with GCC 12 or
/// later) for AVX-512 with its 32 registers. The loader selects the version. All versions give the same bits:
/// the width of lanes belongs to the data, not to the processor, and no compiler may fuse or reorder sums.
/// Functions that such a function calls are inlined into it (TACTILE_CLAY_INLINE). Sanitizers cannot
/// instrument the selection.
///
/// TACTILE_CLAY_TARGETS is 1 if there is more than one target.
/// @note TACTILE_CLAY_ONE_TARGET switches the other targets off, for a test that compares the bits.
#if !defined(__x86_64__) || !defined(__GNUC__) || defined(__clang__) || defined(__SANITIZE_ADDRESS__) || \
    defined(__SANITIZE_THREAD__) || defined(TACTILE_CLAY_ONE_TARGET)
#define TACTILE_CLAY_TARGETS 0
#define TACTILE_CLAY_MULTIVERSION
#elif __GNUC__ >= 12
#define TACTILE_CLAY_TARGETS 1
#define TACTILE_CLAY_MULTIVERSION __attribute__((target_clones("default", "avx2", "arch=x86-64-v4")))
#else
#define TACTILE_CLAY_TARGETS 1
#define TACTILE_CLAY_MULTIVERSION __attribute__((target_clones("default", "avx2")))
#endif
#define TACTILE_CLAY_INLINE inline __attribute__((always_inline))
