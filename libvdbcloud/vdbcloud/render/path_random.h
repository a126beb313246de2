#pragma once
// The random numbers of one light path, a function of (seed, pixel, sample, dimension). Private to render/.
#include "vdbcloud/core/random.h"

namespace vdbcloud {

/// A stream of uniform numbers in [0, 1). Equal (seed, i, j, sample) give equal streams, in any order and thread;
/// other streams are independent of it. The k-th number is the hash of a counter (SplitMix64, Steele et al. 2014).
class PathRandom {
public:
    PathRandom(uint64_t seed, int i, int j, uint64_t sample)
        : state_(hash_bits(seed, uint64_t(uint32_t(i)), uint64_t(uint32_t(j)), sample))
    {
    }
    /// Another stream, that goes on from the next number of this one.
    PathRandom branch()
    {
        PathRandom other = *this;
        other.state_ = hash_bits(state_ += 0x9e3779b97f4a7c15ull);
        return other;
    }
    double next() { return uniform(hash_bits(state_ += 0x9e3779b97f4a7c15ull)); }

private:
    uint64_t state_;
};

}  // namespace vdbcloud
