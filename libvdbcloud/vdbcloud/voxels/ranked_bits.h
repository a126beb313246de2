#pragma once
// A set of small numbers that tells how many of its members come before one: an index into a packed array.
#include <array>
#include <cstddef>
#include <cstdint>

namespace vdbcloud {

/// Numbers 0 .. N - 1. Memory: 5 N / 32 bytes, where a table of 32-bit indices has 4 N.
template<int N>
class RankedBits {
public:
    void set(int n) { mask_[size_t(n) >> 6] |= uint64_t(1) << (n & 63); }
    bool has(int n) const { return mask_[size_t(n) >> 6] >> (n & 63) & 1; }
    /// Counts the members before each word; returns the number of all members. Call after the last set().
    int count()
    {
        int sum = 0;
        for (size_t w = 0; w < words; ++w) {
            before_[w] = uint16_t(sum);
            sum += __builtin_popcountll(mask_[w]);
        }
        return sum;
    }
    /// Members less than n.
    int rank(int n) const
    {
        const size_t w = size_t(n) >> 6;
        return before_[w] + __builtin_popcountll(mask_[w] & ((uint64_t(1) << (n & 63)) - 1));
    }
    uint64_t word(size_t w) const { return mask_[w]; }

private:
    static constexpr size_t words = N / 64;
    static_assert(N % 64 == 0 && N <= 65536);
    std::array<uint64_t, words> mask_{};
    std::array<uint16_t, words> before_{};
};

}  // namespace vdbcloud
