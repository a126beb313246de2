#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/core/clones.h"

#include "vdbcloud/sweep/block_walk.h"
#include "vdbcloud/sweep/characteristic.h"
#include "vdbcloud/sweep/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace vdbcloud::block_sweep {

using namespace lanes;

namespace {

/// Where row `i` of a layout's 64 rows begins in a padded block.
VDBCLOUD_INLINE int row_at(int i) { return (i / 8 + 1) * 160 + (i % 8 + 1) * 16 + 4; }

}  // namespace

Traversal::Traversal(const Vec3d& along) : step(along)
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
    const double ds = 1 / std::abs(step[w]);
    const double mu = snapped(std::abs(step[u]) * ds), mv = snapped(std::abs(step[v]) * ds);
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

VDBCLOUD_CLONES void prepare(const Traversal& traversal, int d, Scratch& s)
{
    float* q = s.q[d];
    if (traversal.layout == &turned) {
        alignas(64) float to[512];
        for (int x = 0; x < 8; ++x) transpose(q + x * 64, 8, to + x * 8, 64);
        std::memcpy(q, to, sizeof to);
    }
    for (int i = 0; i < 64; ++i) store(s.source + row_at(i), load(s.sigma + row_at(i)) * load(q + i * 8));
}

void find_lit(const Traversal& traversal, Scratch& s)
{
    // Bit r + 1 of active[p + 1]: row r of plane p, with the apron's value at its upstream end.
    uint32_t active[10] = {};
    const auto bits = [&](int at) {
        uint64_t word;
        std::memcpy(&word, s.sigma + at, sizeof word);
        return word;
    };
    const int lo[2] = {std::min(traversal.before[0], 0), std::min(traversal.before[1], 0)};
    for (int p = lo[0]; p <= lo[0] + 8; ++p)
        for (int r = lo[1]; r <= lo[1] + 8; ++r) {
            const int row = traversal.at(p, r, 0);
            const uint64_t any = bits(row) | bits(row + 2) | bits(row + 4) | bits(row + 6);
            const bool apron = s.sigma[traversal.at(p, r, traversal.before[2])] != 0;
            active[p + 1] |= uint32_t(any != 0 || apron) << (r + 1);
        }
    for (int p = 0; p < 8; ++p) {
        const uint32_t up = active[p + 1 - traversal.sign[0]];
        const uint32_t aside = traversal.sign[1] > 0 ? up << 1 : up >> 1;
        s.lit[size_t(p)] = uint8_t((active[p + 1] | up | aside) >> 1);
    }
}

VDBCLOUD_CLONES void set_apron(const Traversal& traversal, int region, const float* values, float* padded)
{
    const int p = traversal.before[0], r = traversal.before[1], c = traversal.before[2];
    switch (region_axes[region]) {
    case 1:
        for (int i = 0; i < 8; ++i) store(padded + traversal.at(p, i, 0), load(values + i * 8));
        break;
    case 2:
        for (int i = 0; i < 8; ++i) store(padded + traversal.at(i, r, 0), load(values + i * 8));
        break;
    case 4:
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) padded[traversal.at(i, j, c)] = values[i * 8 + j];
        break;
    case 3: store(padded + traversal.at(p, r, 0), load(values)); break;
    case 5:
        for (int i = 0; i < 8; ++i) padded[traversal.at(p, i, c)] = values[i];
        break;
    case 6:
        for (int i = 0; i < 8; ++i) padded[traversal.at(i, r, c)] = values[i];
        break;
    default: padded[traversal.at(p, r, c)] = values[0];
    }
}

void fill_apron(const Traversal& traversal, int region, float value, float* padded)
{
    alignas(32) float values[64];
    std::fill_n(values, region_size(region), value);
    set_apron(traversal, region, values, padded);
}

void set_apron(const Traversal& traversal, int region, const FaceValues& from, float* padded)
{
    const int u = traversal.last[1], v = traversal.last[2];
    alignas(32) float values[8];
    switch (region_axes[region]) {
    case 1: set_apron(traversal, region, from[0].data(), padded); return;
    case 2: set_apron(traversal, region, from[1].data(), padded); return;
    case 4: set_apron(traversal, region, from[2].data(), padded); return;
    case 3: set_apron(traversal, region, from[0].data() + u * 8, padded); return;
    case 5:
        for (int i = 0; i < 8; ++i) values[i] = from[0][size_t(i * 8 + v)];
        break;
    case 6:
        for (int i = 0; i < 8; ++i) values[i] = from[1][size_t(i * 8 + v)];
        break;
    default: values[0] = from[0][size_t(u * 8 + v)];
    }
    set_apron(traversal, region, values, padded);
}

namespace {

template<bool emission>
VDBCLOUD_INLINE void sweep_inside(const Traversal& traversal, int d, Scratch& s)
{
    const int plane = traversal.stride[0], row = traversal.stride[1], q_plane = traversal.q_stride[0],
              q_row = traversal.q_stride[1];
    const int sw = traversal.sign[0], du = -traversal.sign[1] * row, dv = -traversal.sign[2];
    const Lanes c00 = all(traversal.c00), c01 = all(traversal.c01), c10 = all(traversal.c10), c11 = all(traversal.c11);
    const Lanes half = all(traversal.half_step);
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
            store(s.radiance + here, characteristic<emission>(radiance, sigma_u, source_u, sigma, own, half));
        }
    }
}

}  // namespace

VDBCLOUD_CLONES void sweep_planes(const Traversal& traversal, int d, bool emission, Scratch& s)
{
    if (emission)
        sweep_inside<true>(traversal, d, s);
    else
        sweep_inside<false>(traversal, d, s);
    float* out = s.out[d];
    if (traversal.layout == &turned)
        for (int x = 0; x < 8; ++x) transpose(s.radiance + 160 + (x + 1) * 16 + 4, 160, out + x * 64, 8);
    else
        for (int i = 0; i < 64; ++i) store(out + i * 8, load(s.radiance + row_at(i)));
}

VDBCLOUD_CLONES void take_faces(const Traversal& traversal, const float* padded, FaceValues& to)
{
    for (int i = 0; i < 8; ++i) {
        store(to[0].data() + i * 8, load(padded + traversal.at(traversal.last[0], i, 0)));
        store(to[1].data() + i * 8, load(padded + traversal.at(i, traversal.last[1], 0)));
        for (int j = 0; j < 8; ++j) to[2][size_t(i * 8 + j)] = padded[traversal.at(i, j, traversal.last[2])];
    }
}

void leave_face(const Traversal& traversal, int face, int d, const Scratch& s, const std::array<float, 64>& radiance,
                float* to)
{
    alignas(32) float sigma[64], q[64];
    const int first = face == 0 ? 1 : 0, second = face == 2 ? 1 : 2;  // the coordinates that run
    const int at = traversal.at(0, 0, 0) + traversal.last[size_t(face)] * traversal.stride[size_t(face)];
    const float* from = s.q[d] + traversal.last[size_t(face)] * traversal.q_stride[size_t(face)];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            sigma[i * 8 + j] = s.sigma[at + i * traversal.stride[size_t(first)] + j * traversal.stride[size_t(second)]];
            q[i * 8 + j] = from[i * traversal.q_stride[size_t(first)] + j * traversal.q_stride[size_t(second)]];
        }
    leave(64, radiance.data(), sigma, q, traversal.half_exit[size_t(face)], to);
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
