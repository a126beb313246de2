#pragma once
// Two machine codes of one kernel, chosen when the program starts: 8 floats at a time where the processor can. Both
// give the same bits, as nothing is contracted (-ffp-contract=off) or reordered.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define VDBCLOUD_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VDBCLOUD_CLONES
#endif
#define VDBCLOUD_INLINE inline __attribute__((always_inline))
