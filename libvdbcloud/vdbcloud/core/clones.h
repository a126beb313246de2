#pragma once
// Kernels compiled for several instruction sets. The program selects one at its start: AVX2, 8 floats at a time, where
// the processor has AVX2; WIDE kernels 16 at a time with AVX-512, for loops whose arithmetic takes longer than their
// loads. All give bitwise equal results: -ffp-contract=off, and no operation is reordered. With the thread sanitizer
// there is one: it instruments what selects, which runs before its runtime has started.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define VDBCLOUD_CLONES __attribute__((target_clones("avx2", "default")))
#define VDBCLOUD_WIDE_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define VDBCLOUD_CLONES
#define VDBCLOUD_WIDE_CLONES
#endif
#define VDBCLOUD_INLINE inline __attribute__((always_inline))
