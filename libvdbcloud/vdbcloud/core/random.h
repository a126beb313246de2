#pragma once
// Random numbers as a function of (seed, integer position). Without state, results do not depend on order or threads.
#include "vdbcloud/core/constants.h"

#include <cmath>
#include <cstdint>

namespace vdbcloud {

/// A well-mixed 64-bit hash of `x` (the finaliser of SplitMix64, Steele et al. 2014).
inline uint64_t hash_bits(uint64_t x)
{
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// Hash of a seed and up to four integers.
inline uint64_t hash_bits(uint64_t seed, uint64_t a, uint64_t b = 0, uint64_t c = 0, uint64_t d = 0)
{
    return hash_bits(hash_bits(hash_bits(hash_bits(hash_bits(seed) ^ a) ^ b) ^ c) ^ d);
}

/// Uniform in [0, 1), with 53 bits, from a hash.
inline double uniform(uint64_t bits) { return double(bits >> 11) * 0x1p-53; }

/// Standard normal from a hash (Box and Muller 1958; the cosine variate of the pair).
inline double normal(uint64_t bits)
{
    const double u = 1.0 - uniform(bits), v = uniform(hash_bits(bits));
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2 * pi * v);
}

}  // namespace vdbcloud
