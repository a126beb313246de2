#include "vdbcloud/sweep/block_sweep.h"

#include <algorithm>
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
VDBCLOUD_INLINE Lanes at_least(Lanes x, float limit) { return x < all(limit) ? all(limit) : x; }

constexpr float series_below = 0.3f;

/// (1 - e^-t) / t - e^-t: by its series where that would cancel; `inverse` is 1 / t elsewhere.
VDBCLOUD_INLINE Lanes ramp(Lanes t, Lanes inverse, Lanes lost, Lanes e)
{
    Lanes s = all(1.0f / 144) - t * all(1.0f / 840);
    s = all(1.0f / 30) - t * s;
    s = all(1.0f / 8) - t * s;
    s = all(1.0f / 3) - t * s;
    s = t * (all(0.5f) - t * s);
    return t < all(series_below) ? s : lost * inverse - e;
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

/// Where row `i` of a layout's 64 rows begins in a padded block.
VDBCLOUD_INLINE int row_at(int i) { return (i / 8 + 1) * 160 + (i % 8 + 1) * 16 + 4; }

}  // namespace

Frame::Frame(const Vec3d& along) : step(along)
{
    int w = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(step[a]) > std::abs(step[w])) w = a;
    layout = w == 2 ? &turned : &natural;
    const int v = w == 2 ? 1 : 2, u = 3 - w - v;
    axis = {w, u, v};
    for (int k = 0; k < 3; ++k) {
        const double along_axis = step[axis[k]];
        stride[k] = layout->stride[axis[k]];
        q_stride[k] = layout->row_stride[axis[k]];
        sign[k] = along_axis < 0 ? -1 : 1;
        before[k] = sign[k] > 0 ? -1 : 8;
        last[k] = sign[k] > 0 ? 7 : 0;
        half_exit[k] = float(0.5 / std::max(std::abs(along_axis), 1e-30));
    }
    for (int n = 0; n < regions; ++n) {
        region[n] = 0;
        for (int k = 0; k < 3; ++k) region[n] |= (region_axes[n] >> k & 1) << axis[k];
    }
    const double ds = 1 / std::abs(step[w]), mu = std::abs(step[u]) * ds, mv = std::abs(step[v]) * ds;
    c00 = float((1 - mu) * (1 - mv));
    c01 = float((1 - mu) * mv);
    c10 = float(mu * (1 - mv));
    c11 = float(mu * mv);
    half_step = float(ds / 2);
}

Rows::Rows(const BlockMask& mask)
{
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            row[count] = uint8_t(x * 8 + y);
            count += (mask[size_t(x)] >> (8 * y) & 255) != 0;
        }
}

VDBCLOUD_CLONES void load_inside(const Layout& to, const float* values, float* padded)
{
    if (to.stride[2] == 1)
        for (int i = 0; i < 64; ++i) store(padded + row_at(i), load(values + i * 8));
    else  // rows along y, planes of z: for each x, (y, z) -> (z, y)
        for (int x = 0; x < 8; ++x) transpose(values + x * 64, 8, padded + 160 + (x + 1) * 16 + 4, 160);
}

void fetch(const Rows& rows, int terms, float* const* moments)
{
    for (int k = 0; k < terms; ++k)
        for (int n = 0; n < rows.count; ++n) __builtin_prefetch(moments[k] + rows.row[n] * 8, 1);
}

VDBCLOUD_CLONES void expand(const Rows& rows, int n, int terms, const float* const* source, const float* basis,
                            Scratch& s)
{
    for (int g = 0; g < n; g += group) {
        if (rows.count < 64) std::memset(s.q[g], 0, group * sizeof s.q[0]);
        for (int r = 0; r < rows.count; ++r) {
            const int i = rows.row[r] * 8;
            const Lanes first = load(source[0] + i);
            Lanes sum[group];
            for (int d = 0; d < group; ++d) sum[d] = all(basis[g + d]) * first;
            for (int k = 1; k < terms; ++k) {
                const Lanes term = load(source[k] + i);
                for (int d = 0; d < group; ++d) sum[d] += all(basis[k * batch + g + d]) * term;
            }
            for (int d = 0; d < group; ++d) store(s.q[g + d] + i, sum[d]);
        }
    }
}

VDBCLOUD_CLONES void prepare(const Frame& frame, int d, Scratch& s)
{
    float* q = s.q[d];
    if (frame.layout == &turned) {
        alignas(64) float to[512];
        for (int x = 0; x < 8; ++x) transpose(q + x * 64, 8, to + x * 8, 64);
        std::memcpy(q, to, sizeof to);
    }
    for (int i = 0; i < 64; ++i) store(s.source + row_at(i), load(s.sigma + row_at(i)) * load(q + i * 8));
}

void find_lit(const Frame& frame, Scratch& s)
{
    // Bit r + 1 of active[p + 1]: row r of plane p, with the apron's value at its upstream end.
    uint32_t active[10] = {};
    const auto bits = [&](int at) {
        uint64_t word;
        std::memcpy(&word, s.sigma + at, sizeof word);
        return word;
    };
    const int lo[2] = {std::min(frame.before[0], 0), std::min(frame.before[1], 0)};
    for (int p = lo[0]; p <= lo[0] + 8; ++p)
        for (int r = lo[1]; r <= lo[1] + 8; ++r) {
            const int row = frame.at(p, r, 0);
            const uint64_t any = bits(row) | bits(row + 2) | bits(row + 4) | bits(row + 6);
            const bool apron = s.sigma[frame.at(p, r, frame.before[2])] != 0;
            active[p + 1] |= uint32_t(any != 0 || apron) << (r + 1);
        }
    for (int p = 0; p < 8; ++p) {
        const uint32_t up = active[p + 1 - frame.sign[0]];
        const uint32_t aside = frame.sign[1] > 0 ? up << 1 : up >> 1;
        s.lit[size_t(p)] = uint8_t((active[p + 1] | up | aside) >> 1);
    }
}

VDBCLOUD_CLONES void set_apron(const Frame& frame, int region, const float* values, float* padded)
{
    const int p = frame.before[0], r = frame.before[1], c = frame.before[2];
    switch (region_axes[region]) {
    case 1:
        for (int i = 0; i < 8; ++i) store(padded + frame.at(p, i, 0), load(values + i * 8));
        break;
    case 2:
        for (int i = 0; i < 8; ++i) store(padded + frame.at(i, r, 0), load(values + i * 8));
        break;
    case 4:
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) padded[frame.at(i, j, c)] = values[i * 8 + j];
        break;
    case 3: store(padded + frame.at(p, r, 0), load(values)); break;
    case 5:
        for (int i = 0; i < 8; ++i) padded[frame.at(p, i, c)] = values[i];
        break;
    case 6:
        for (int i = 0; i < 8; ++i) padded[frame.at(i, r, c)] = values[i];
        break;
    default: padded[frame.at(p, r, c)] = values[0];
    }
}

void fill_apron(const Frame& frame, int region, float value, float* padded)
{
    alignas(32) float values[64];
    std::fill_n(values, region_size(region), value);
    set_apron(frame, region, values, padded);
}

void set_apron(const Frame& frame, int region, const Faces& from, float* padded)
{
    const int u = frame.last[1], v = frame.last[2];
    alignas(32) float values[8];
    switch (region_axes[region]) {
    case 1: set_apron(frame, region, from[0].data(), padded); return;
    case 2: set_apron(frame, region, from[1].data(), padded); return;
    case 4: set_apron(frame, region, from[2].data(), padded); return;
    case 3: set_apron(frame, region, from[0].data() + u * 8, padded); return;
    case 5:
        for (int i = 0; i < 8; ++i) values[i] = from[0][size_t(i * 8 + v)];
        break;
    case 6:
        for (int i = 0; i < 8; ++i) values[i] = from[1][size_t(i * 8 + v)];
        break;
    default: values[0] = from[0][size_t(u * 8 + v)];
    }
    set_apron(frame, region, values, padded);
}

VDBCLOUD_CLONES void sweep_planes(const Frame& frame, int d, Scratch& s)
{
    const int plane = frame.stride[0], row = frame.stride[1], q_plane = frame.q_stride[0], q_row = frame.q_stride[1];
    const int sw = frame.sign[0], du = -frame.sign[1] * row, dv = -frame.sign[2];
    const Lanes c00 = all(frame.c00), c01 = all(frame.c01), c10 = all(frame.c10), c11 = all(frame.c11);
    const Lanes half = all(frame.half_step);
    const float* from = s.q[d];
    for (int k = 0; k < 8; ++k) {
        const int p = sw > 0 ? k : 7 - k;
        const unsigned lit = s.lit[size_t(p)];
        for (int r = 0; r < 8; ++r) {
            const int here = (p + 1) * plane + (r + 1) * row + 4, up = here - sw * plane;
            const auto before = [&](const float* f) {
                return (c00 * load(f + up) + c01 * load(f + up + dv)) +
                       (c10 * load(f + up + du) + c11 * load(f + up + du + dv));
            };
            const Lanes radiance = before(s.radiance);
            if (!(lit >> r & 1)) {  // light passes
                store(s.radiance + here, radiance);
                continue;
            }
            const Lanes sigma_u = before(s.sigma), source_u = before(s.source);
            const Lanes own = load(from + p * q_plane + r * q_row), sigma = load(s.sigma + here);
            const Lanes t = (sigma_u + sigma) * half;
            // 1 / sigma_u and 1 / t by one division.
            const Lanes divisor = at_least(sigma_u, 1e-30f), length = at_least(t, series_below);
            const Lanes inverse = all(1.0f) / (divisor * length);
            const Lanes q_u = sigma_u > all(0.0f) ? source_u * (inverse * length) : own;
            const Lanes q = sigma > all(0.0f) ? own : q_u;
            const Lanes e = exp_minus(at_most(t, 80.0f)), lost = all(1.0f) - e;
            store(s.radiance + here, radiance * e + q * lost + (q_u - q) * ramp(t, inverse * divisor, lost, e));
        }
    }
    float* out = s.out[d];
    if (frame.layout == &turned)
        for (int x = 0; x < 8; ++x) transpose(s.radiance + 160 + (x + 1) * 16 + 4, 160, out + x * 64, 8);
    else
        for (int i = 0; i < 64; ++i) store(out + i * 8, load(s.radiance + row_at(i)));
}

VDBCLOUD_CLONES void take_faces(const Frame& frame, const float* padded, Faces& to)
{
    for (int i = 0; i < 8; ++i) {
        store(to[0].data() + i * 8, load(padded + frame.at(frame.last[0], i, 0)));
        store(to[1].data() + i * 8, load(padded + frame.at(i, frame.last[1], 0)));
        for (int j = 0; j < 8; ++j) to[2][size_t(i * 8 + j)] = padded[frame.at(i, j, frame.last[2])];
    }
}

void leave_face(const Frame& frame, int face, int d, const Scratch& s, const std::array<float, 64>& radiance, float* to)
{
    alignas(32) float sigma[64], q[64];
    const int first = face == 0 ? 1 : 0, second = face == 2 ? 1 : 2;  // the coordinates that run
    const int at = frame.at(0, 0, 0) + frame.last[size_t(face)] * frame.stride[size_t(face)];
    const float* from = s.q[d] + frame.last[size_t(face)] * frame.q_stride[size_t(face)];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            sigma[i * 8 + j] = s.sigma[at + i * frame.stride[size_t(first)] + j * frame.stride[size_t(second)]];
            q[i * 8 + j] = from[i * frame.q_stride[size_t(first)] + j * frame.q_stride[size_t(second)]];
        }
    leave(64, radiance.data(), sigma, q, frame.half_exit[size_t(face)], to);
}

namespace {

template<int groups, bool first>
VDBCLOUD_INLINE void accumulate_groups(const Rows& rows, float* to, const float* weight, const Scratch& s)
{
    Lanes w[groups * group];
    for (int d = 0; d < groups * group; ++d) w[d] = all(weight[d]);
    for (int r = 0; r < rows.count; ++r) {
        const int i = rows.row[r] * 8;
        const auto sum = [&](int g) {
            return (w[g] * load(s.out[g] + i) + w[g + 1] * load(s.out[g + 1] + i)) +
                   (w[g + 2] * load(s.out[g + 2] + i) + w[g + 3] * load(s.out[g + 3] + i));
        };
        Lanes total = sum(0);
        if (groups == 2) total += sum(group * (groups - 1));
        store(to + i, first ? total : load(to + i) + total);
    }
}

}  // namespace

VDBCLOUD_CLONES void accumulate(const Rows& rows, int n, int terms, bool first, float* const* moments,
                                const float* weight, const Scratch& s)
{
    static_assert(group == 4 && batch == 2 * group);
    for (int k = 0; k < terms; ++k) {
        const float* w = weight + k * batch;
        if (first && rows.count < 64) std::memset(moments[k], 0, 512 * sizeof(float));
        if (n > group)
            first ? accumulate_groups<2, true>(rows, moments[k], w, s)
                  : accumulate_groups<2, false>(rows, moments[k], w, s);
        else
            first ? accumulate_groups<1, true>(rows, moments[k], w, s)
                  : accumulate_groups<1, false>(rows, moments[k], w, s);
    }
}

VDBCLOUD_CLONES void leave(int n, const float* radiance, const float* sigma, const float* q, float length,
                           float* result)
{
    const Lanes along = all(length);
    for (int i = 0; i < n; i += 8) {
        const Lanes e = exp_minus(at_most(load(sigma + i) * along, 80.0f));
        store(result + i, load(radiance + i) * e + load(q + i) * (all(1.0f) - e));
    }
}

VDBCLOUD_CLONES void add(size_t n, const float* values, const std::array<float, 3>& factor,
                         const std::array<float*, 3>& to)
{
    for (size_t a = 0; a < 3; ++a)
        for (size_t i = 0; i < n; ++i) to[a][i] += factor[a] * values[i];
}

}  // namespace vdbcloud::block_sweep
