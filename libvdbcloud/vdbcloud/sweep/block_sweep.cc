#include "vdbcloud/sweep/block_sweep.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace vdbcloud::block_sweep {

namespace {

#define VDBCLOUD_CLONES __attribute__((target_clones("avx2", "default")))
#define VDBCLOUD_INLINE inline __attribute__((always_inline))

// Eight lanes: one row of a block. Operations are element by element, so both clones give equal values.
using Lanes = float __attribute__((vector_size(32)));
using Ints = int32_t __attribute__((vector_size(32)));

VDBCLOUD_INLINE Lanes load(const float* from)
{
    Lanes v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
VDBCLOUD_INLINE void store(float* to, Lanes v) { std::memcpy(to, &v, sizeof v); }
VDBCLOUD_INLINE Lanes all(float x) { return Lanes{x, x, x, x, x, x, x, x}; }

/// exp(-t) for t in [0, 80], relative error 1e-7.
VDBCLOUD_INLINE Lanes exp_minus(Lanes t)
{
    const Lanes x = t * all(-1.44269504f);
    const Ints n = __builtin_convertvector(x - all(0.5f), Ints);
    const Lanes z = (x - __builtin_convertvector(n, Lanes)) * all(0.69314718f);
    Lanes p = all(1.0f / 720) + z * all(1.0f / 5040);
    p = all(1.0f / 120) + z * p;
    p = all(1.0f / 24) + z * p;
    p = all(1.0f / 6) + z * p;
    p = all(0.5f) + z * p;
    p = all(1.0f) + z * (all(1.0f) + z * p);
    const Ints scale = (n + 127) << 23;
    Lanes power;
    std::memcpy(&power, &scale, sizeof power);
    return p * power;
}

VDBCLOUD_INLINE Lanes at_most(Lanes x, float limit) { return x > all(limit) ? all(limit) : x; }

/// (1 - e^-t) / t - e^-t: by its series where that would cancel.
VDBCLOUD_INLINE Lanes ramp(Lanes t, Lanes lost, Lanes e)
{
    Lanes s = all(1.0f / 144) - t * all(1.0f / 840);
    s = all(1.0f / 30) - t * s;
    s = all(1.0f / 8) - t * s;
    s = all(1.0f / 3) - t * s;
    s = t * (all(0.5f) - t * s);
    const Lanes large = lost / (t + all(1e-20f)) - e;
    return t < all(0.3f) ? s : large;
}

/// Transposes 8 x 8: rows of `from` (stride 8) become columns.
VDBCLOUD_INLINE void transpose(const float* from, int from_stride, float* to, int to_stride)
{
    Lanes r[8], s[8];
    for (int i = 0; i < 8; ++i) r[i] = load(from + i * from_stride);
    for (int i = 0; i < 8; i += 2) {
        s[i] = __builtin_shuffle(r[i], r[i + 1], Ints{0, 8, 1, 9, 4, 12, 5, 13});
        s[i + 1] = __builtin_shuffle(r[i], r[i + 1], Ints{2, 10, 3, 11, 6, 14, 7, 15});
    }
    for (int h = 0; h < 8; h += 4)
        for (int i = 0; i < 2; ++i) {
            r[h + 2 * i] = __builtin_shuffle(s[h + i], s[h + i + 2], Ints{0, 1, 8, 9, 4, 5, 12, 13});
            r[h + 2 * i + 1] = __builtin_shuffle(s[h + i], s[h + i + 2], Ints{2, 3, 10, 11, 6, 7, 14, 15});
        }
    for (int i = 0; i < 4; ++i) {
        store(to + i * to_stride, __builtin_shuffle(r[i], r[i + 4], Ints{0, 1, 2, 3, 8, 9, 10, 11}));
        store(to + (i + 4) * to_stride, __builtin_shuffle(r[i], r[i + 4], Ints{4, 5, 6, 7, 12, 13, 14, 15}));
    }
}

/// Where row `i` of a layout's 64 rows begins in a padded block.
VDBCLOUD_INLINE int row_at(int i) { return (i / 8 + 1) * 160 + (i % 8 + 1) * 16 + 4; }

}  // namespace

Frame::Frame(const Vec3d& step)
{
    w = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(step[a]) > std::abs(step[w])) w = a;
    layout = w == 2 ? &turned : &natural;
    v = w == 2 ? 1 : 2;
    u = 3 - w - v;
    const double ds = 1 / std::abs(step[w]), mu = std::abs(step[u]) * ds, mv = std::abs(step[v]) * ds;
    c00 = float((1 - mu) * (1 - mv));
    c01 = float((1 - mu) * mv);
    c10 = float(mu * (1 - mv));
    c11 = float(mu * mv);
    half_step = float(ds / 2);
    for (int a = 0; a < 3; ++a) {
        sign[a] = step[a] < 0 ? -1 : 1;
        half_exit[a] = float(0.5 / std::max(std::abs(step[a]), 1e-30));
    }
}

VDBCLOUD_CLONES void load_inside(const Layout& to, const float* values, float* padded)
{
    if (to.stride[2] == 1)
        for (int i = 0; i < 64; ++i) store(padded + row_at(i), load(values + i * 8));
    else  // rows along y, planes of z: for each x, (y, z) -> (z, y)
        for (int x = 0; x < 8; ++x) transpose(values + x * 64, 8, padded + 160 + (x + 1) * 16 + 4, 160);
}

VDBCLOUD_CLONES void prepare(const Frame& frame, int terms, const float* const* source, const float* basis, Scratch& s)
{
    float* to = frame.w == 2 ? s.out : s.q;
    for (int i = 0; i < 64; ++i) {
        Lanes sum = all(basis[0]) * load(source[0] + i * 8);
        for (int k = 1; k < terms; ++k) sum += all(basis[k]) * load(source[k] + i * 8);
        store(to + i * 8, sum);
    }
    if (frame.w == 2)
        for (int x = 0; x < 8; ++x) transpose(s.out + x * 64, 8, s.q + x * 8, 64);
    for (int i = 0; i < 64; ++i) store(s.source + row_at(i), load(s.sigma + row_at(i)) * load(s.q + i * 8));
}

VDBCLOUD_CLONES void sweep_planes(const Frame& frame, Scratch& s)
{
    const bool planes_of_rows = frame.w != 1;  // planes are 160 apart, rows 16; for y it is the other way
    const int plane = planes_of_rows ? 160 : 16, row = planes_of_rows ? 16 : 160;
    const int q_plane = planes_of_rows ? 64 : 8, q_row = planes_of_rows ? 8 : 64;
    const int sw = frame.sign[frame.w];
    const int du = -frame.sign[frame.u] * row, dv = -frame.sign[frame.v];
    const Lanes c00 = all(frame.c00), c01 = all(frame.c01), c10 = all(frame.c10), c11 = all(frame.c11);
    const Lanes half = all(frame.half_step);
    for (int k = 0; k < 8; ++k) {
        const int p = sw > 0 ? k : 7 - k;
        for (int r = 0; r < 8; ++r) {
            const int here = (p + 1) * plane + (r + 1) * row + 4, up = here - sw * plane;
            const auto before = [&](const float* f) {
                return (c00 * load(f + up) + c01 * load(f + up + dv)) +
                       (c10 * load(f + up + du) + c11 * load(f + up + du + dv));
            };
            const Lanes radiance = before(s.radiance), sigma_u = before(s.sigma), source_u = before(s.source);
            const Lanes own = load(s.q + p * q_plane + r * q_row), sigma = load(s.sigma + here);
            const Lanes t = at_most((sigma_u + sigma) * half, 80.0f);
            const Lanes q_u = sigma_u > all(0.0f) ? source_u / sigma_u : own;
            const Lanes q = sigma > all(0.0f) ? own : q_u;
            const Lanes e = exp_minus(t), lost = all(1.0f) - e;
            store(s.radiance + here, radiance * e + q * lost + (q_u - q) * ramp(t, lost, e));
        }
    }
    if (frame.w == 2)
        for (int x = 0; x < 8; ++x) transpose(s.radiance + 160 + (x + 1) * 16 + 4, 160, s.out + x * 64, 8);
    else
        for (int i = 0; i < 64; ++i) store(s.out + i * 8, load(s.radiance + row_at(i)));
}

VDBCLOUD_CLONES void accumulate(int terms, float* const* moments, const float* weight, const float* out)
{
    for (int k = 0; k < terms; ++k) {
        float* to = moments[k];
        const Lanes factor = all(weight[k]);
        for (int i = 0; i < 512; i += 8) store(to + i, load(to + i) + factor * load(out + i));
    }
}

VDBCLOUD_CLONES void leave(int n, const float* radiance, const float* sigma, const float* q, const float* length,
                           float* result)
{
    for (int i = 0; i < n; i += 8) {
        const Lanes e = exp_minus(at_most(load(sigma + i) * load(length + i), 80.0f));
        store(result + i, load(radiance + i) * e + load(q + i) * (all(1.0f) - e));
    }
}

}  // namespace vdbcloud::block_sweep
