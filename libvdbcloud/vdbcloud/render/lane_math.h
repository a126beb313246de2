#pragma once
// Arithmetic on four doubles at a time. Private to render/: inlined into loops that are compiled for several
// instruction sets, where all operations are element by element, so all give equal bits.
#include "vdbcloud/core/clones.h"

#include <cstdint>
#include <cstring>

namespace vdbcloud::lanes4 {

// Every function here is inlined: nobody needs the calling convention of these vectors.
#pragma GCC diagnostic ignored "-Wpsabi"

using Lanes = double __attribute__((vector_size(32)));
using Ints = int64_t __attribute__((vector_size(32)));
using Floats = float __attribute__((vector_size(16)));

VDBCLOUD_INLINE Lanes all(double x) { return Lanes{x, x, x, x}; }
VDBCLOUD_INLINE Lanes load(const double* from)
{
    Lanes v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
VDBCLOUD_INLINE void store(double* to, Lanes v) { std::memcpy(to, &v, sizeof v); }
VDBCLOUD_INLINE Floats floats(const float* from)
{
    Floats v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
VDBCLOUD_INLINE Lanes wide(Floats v) { return __builtin_convertvector(v, Lanes); }
VDBCLOUD_INLINE Lanes as_lanes(Ints v)
{
    Lanes x;
    std::memcpy(&x, &v, sizeof x);
    return x;
}
VDBCLOUD_INLINE Ints as_ints(Lanes v)
{
    Ints x;
    std::memcpy(&x, &v, sizeof x);
    return x;
}
VDBCLOUD_INLINE Lanes magnitude(Lanes v) { return as_lanes(as_ints(v) & INT64_MAX); }
VDBCLOUD_INLINE double sum(Lanes v) { return (v[0] + v[1]) + (v[2] + v[3]); }

/// exp(x), relative error below 4e-16. x is clamped to [-700, 700]: e^-700 = 1e-304 stands for 0.
VDBCLOUD_INLINE Lanes exponential(Lanes x)
{
    x = x < all(-700) ? all(-700) : x;
    x = x > all(700) ? all(700) : x;
    // x = n ln 2 + r, |r| <= 0.3466. Adding 1.5 * 2^52 leaves n in the low bits of the sum.
    const Lanes magic = all(6755399441055744.0), shifted = x * all(1.4426950408889634) + magic, n = shifted - magic;
    const Lanes r = (x - n * all(6.93147180369123816490e-01)) - n * all(1.90821492927058770002e-10);
    // Taylor's series to degree 12; the next term is below 1.7e-16.
    const Lanes r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
    const Lanes a = (all(1) + r) + r2 * (all(1.0 / 2) + r * all(1.0 / 6));
    const Lanes b = (all(1.0 / 24) + r * all(1.0 / 120)) + r2 * (all(1.0 / 720) + r * all(1.0 / 5040));
    const Lanes c = (all(1.0 / 40320) + r * all(1.0 / 362880)) + r2 * (all(1.0 / 3628800) + r * all(1.0 / 39916800)) +
                    r4 * all(1.0 / 479001600);
    const Ints power = (as_ints(shifted) - as_ints(magic) + 1023) << 52;
    return (a + r4 * b + r8 * c) * as_lanes(power);
}

/// log(x) for 1 <= x < 2^100, absolute error below 1e-15 (1 + log x).
VDBCLOUD_INLINE Lanes logarithm(Lanes x)
{
    // x = m 2^e with m in [0.7071, 1.4143); log m = 2 artanh((m - 1) / (m + 1)).
    constexpr uint64_t root_of_half = 0x3fe6a09e667f3bcd;
    using Words = uint64_t __attribute__((vector_size(32)));
    Words bits;
    std::memcpy(&bits, &x, sizeof bits);
    const Words e = (bits - root_of_half) >> 52;
    const Lanes m = as_lanes(Ints(bits - (e << 52))), magic = all(6755399441055744.0);
    const Lanes exponent = as_lanes(Ints(e) + as_ints(magic)) - magic;
    const Lanes s = (m - all(1)) / (m + all(1)), q = s * s;
    Lanes p = all(1.0 / 21);
    for (int k = 19; k >= 1; k -= 2) p = all(1.0 / k) + q * p;
    return all(0.69314718055994531) * exponent + all(2) * s * p;
}

/// As mean_exponential() of cell_rule.h.
VDBCLOUD_INLINE Lanes mean_exponential(Lanes at_0, Lanes at_1, Lanes x)
{
    const Lanes series =
        at_0 * (all(1) - x * all(1.0 / 2) *
                             (all(1) - x * all(1.0 / 3) * (all(1) - x * all(1.0 / 4) * (all(1) - x * all(1.0 / 5)))));
    const auto far = magnitude(x) > all(1e-2);
    return far ? (at_0 - at_1) / (far ? x : all(1)) : series;
}

}  // namespace vdbcloud::lanes4
