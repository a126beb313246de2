#pragma once
// Arithmetic on eight floats at a time, one row of a block. Private to sweep/: inlined into loops that are compiled for
// several instruction sets.
#include "vdbcloud/core/eight.h"

#include <cstring>

namespace vdbcloud::lanes {

using Lanes = eight::Floats;
using Ints = eight::Ints;
using eight::load;
using eight::store;

VDBCLOUD_INLINE Lanes all(float x) { return eight::all(x); }

/// exp(-t) for t in [0, 80], relative error 1e-7.
VDBCLOUD_INLINE Lanes exp_minus(Lanes t)
{
    const Lanes x = t * all(-1.44269504f);
    const Ints n = __builtin_convertvector(x - all(0.5f), Ints);
    const Lanes z = (x - __builtin_convertvector(n, Lanes)) * all(0.69314718f);
    // The series in pairs (Estrin): half the latency of one term after another.
    const Lanes zz = z * z;
    const Lanes high = (all(1.0f / 24) + z * all(1.0f / 120)) + zz * (all(1.0f / 720) + z * all(1.0f / 5040));
    const Lanes p = (all(1.0f) + z) + zz * ((all(0.5f) + z * all(1.0f / 6)) + zz * high);
    const Ints scale = (n + 127) << 23;
    Lanes power;
    std::memcpy(&power, &scale, sizeof power);
    return p * power;
}

VDBCLOUD_INLINE Ints bits_of(Lanes x)
{
    Ints bits;
    std::memcpy(&bits, &x, sizeof bits);
    return bits;
}
VDBCLOUD_INLINE Lanes of_bits(Ints bits)
{
    Lanes x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}
/// Of values >= 0, whose bits have the order of the values: one instruction for integers, two for floats.
VDBCLOUD_INLINE Lanes at_most(Lanes x, float limit)
{
    const Ints a = bits_of(x), b = bits_of(all(limit));
    return of_bits(a > b ? b : a);
}
VDBCLOUD_INLINE Lanes at_least(Lanes x, float limit)
{
    const Ints a = bits_of(x), b = bits_of(all(limit));
    return of_bits(a < b ? b : a);
}

/// Whether any bit is set.
template<typename Row>
VDBCLOUD_INLINE bool any(const Row& x)
{
    uint64_t bits[4];
    std::memcpy(bits, &x, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
}

/// Transposes 8 x 8: rows of `from` (stride 8) become columns.
VDBCLOUD_INLINE void transpose(const float* from, int from_stride, float* to, int to_stride)
{
    Lanes r[8], s[8];
    for (int i = 0; i < 8; ++i) r[i] = load(from + i * from_stride);
    for (int i = 0; i < 8; i += 2) {
        s[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        s[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (int h = 0; h < 8; h += 4)
        for (int i = 0; i < 2; ++i) {
            r[h + 2 * i] = __builtin_shufflevector(s[h + i], s[h + i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            r[h + 2 * i + 1] = __builtin_shufflevector(s[h + i], s[h + i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (int i = 0; i < 4; ++i) {
        store(to + i * to_stride, __builtin_shufflevector(r[i], r[i + 4], 0, 1, 2, 3, 8, 9, 10, 11));
        store(to + (i + 4) * to_stride, __builtin_shufflevector(r[i], r[i + 4], 4, 5, 6, 7, 12, 13, 14, 15));
    }
}

}  // namespace vdbcloud::lanes
