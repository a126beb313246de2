#include "vdbcloud/sweep/block_sweep.h"
#include "vdbcloud/core/clones.h"

#include "vdbcloud/sweep/block_walk.h"
#include "vdbcloud/sweep/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

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
        row_stride[k] = layout->row_stride[axis[k]];
        slot_stride[k] = natural.row_stride[axis[k]];
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
    u_up = float(snapped(std::abs(step[u]) * ds));
    v_up = float(snapped(std::abs(step[v]) * ds));
    half_step = float(ds / 2);
}

Rows::Rows(const BlockMask& mask)
{
    for (int i = 0; i < 64; ++i) {
        row[count] = uint8_t(i);
        count += (mask[size_t(i / 8)] >> (8 * (i % 8)) & 255) != 0;
    }
    for (int i = 0; i < 32; ++i) {
        line[lines] = uint8_t(i);
        lines += (mask[size_t(i / 4)] >> (16 * (i % 4)) & 0xffff) != 0;
    }
}

VDBCLOUD_CLONES void take_sigma(const Layout& layout, const float* values, Scratch& s)
{
    s.sigma = &layout == &natural ? values : s.turned_sigma;
    if (&layout == &turned)  // rows along y, planes of z: for each x, (y, z) -> (z, y)
        for (int x = 0; x < 8; ++x) transpose(values + x * 64, 8, s.turned_sigma + x * 8, 64);
}

VDBCLOUD_CLONES void take_region(const Traversal& traversal, int region, const float* values, float* to)
{
    int stride[2] = {0, 0}, runs = 0;
    for (int k = 0; k < 3; ++k) {
        if (region_axes[region] >> k & 1)
            values += traversal.last[k] * traversal.slot_stride[k];
        else
            stride[runs++] = traversal.slot_stride[k];
    }
    if (runs < 2)
        for (int n = 0; n < region_size(region); ++n) to[n] = values[n * stride[0]];
    else if (stride[1] == 1)
        for (int i = 0; i < 8; ++i) store(to + i * 8, load(values + i * stride[0]));
    else if (stride[0] == 1)
        transpose(values, stride[1], to, 8);
    else
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) to[i * 8 + j] = values[i * stride[0] + j * stride[1]];
}

void fetch(const Rows& rows, int from, int to, float* const* moments)
{
    for (int k = from; k < to; ++k)
        for (int n = 0; n < rows.lines; ++n) __builtin_prefetch(moments[k] + rows.line[n] * 16, 1);
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
    if (traversal.layout == &natural) return;
    float* q = s.q[d];
    alignas(64) float to[512];
    for (int x = 0; x < 8; ++x) transpose(q + x * 64, 8, to + x * 8, 64);
    std::memcpy(q, to, sizeof to);
}

void clear_walls(Scratch& s)
{
    std::fill_n(s.walls, 512, std::numeric_limits<float>::quiet_NaN());
    s.wall = s.walls;
}

void set_wall(const Layout& layout, size_t slot, float radiance, Scratch& s)
{
    const int x = int(slot / 64), y = int(slot / 8 % 8), z = int(slot % 8);
    s.walls[x * layout.row_stride[0] + y * layout.row_stride[1] + z * layout.row_stride[2]] = radiance;
}

VDBCLOUD_CLONES void find_lit(const Traversal& traversal, const BlockMask& mask, Scratch& s)
{
    if (std::all_of(mask.begin(), mask.end(), [](uint64_t word) { return !~word; })) return s.lit.fill(255);
    // Bit r + 1 of active[p + 1]: row r of plane p, with the apron's value at its upstream end.
    uint32_t active[10] = {};
    for (int n = 0; n < 512; n += 8) {
        const int x = n / 64, y = n / 8 % 8;
        const uint64_t row = mask[size_t(x)] >> (8 * y) & 255;
        if (!row) continue;
        if (traversal.axis[0] == 0)
            active[x + 1] |= 2u << y;
        else if (traversal.axis[0] == 1)
            active[y + 1] |= 2u << x;
        else
            for (int z = 0; z < 8; ++z) active[z + 1] |= uint32_t(row >> z & 1) << (x + 1);
    }
    const int p = traversal.before[0] + 1, r = traversal.before[1] + 1;
    const auto& apron = s.sigma_before.region;
    for (int n = 0; n < 8; ++n) {
        active[p] |= uint32_t(any(load(apron[0] + n * 8)) || apron[4][n] != 0) << (n + 1);
        active[n + 1] |= uint32_t(any(load(apron[1] + n * 8)) || apron[5][n] != 0) << r;
        const Lanes beside = load(apron[2] + n * 8);
        for (int i = 0; i < 8 && any(beside); ++i) active[n + 1] |= uint32_t(beside[i] != 0) << (i + 1);
    }
    active[p] |= uint32_t(any(load(apron[3])) || apron[6][0] != 0) << r;
    for (int n = 0; n < 8; ++n) {
        const uint32_t up = active[n + 1 - traversal.sign[0]];
        const uint32_t aside = traversal.sign[1] > 0 ? up << 1 : up >> 1;
        s.lit[size_t(n)] = uint8_t((active[n + 1] | up | aside) >> 1);
    }
}

namespace {

VDBCLOUD_INLINE void set_apron(const Traversal& traversal, int region, const float* values, int pitch, float* padded)
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
        for (int i = 0; i < 8; ++i) padded[traversal.at(i, r, c)] = values[i * pitch];
        break;
    default: padded[traversal.at(p, r, c)] = values[0];
    }
}

}  // namespace

const float* region_of(const Traversal& traversal, int region, const FaceValues& from)
{
    const int w = traversal.last[0], u = traversal.last[1], v = traversal.last[2];
    switch (region_axes[region]) {
    case 1: return from[0].data();
    case 2: return from[1].data();
    case 4: return from[2].data();
    case 3: return from[0].data() + u * 8;
    case 5: return from[2].data() + w * 8;
    case 6: return from[1].data() + v;
    default: return from[0].data() + u * 8 + v;
    }
}

void share_medium(const Scratch& of, Scratch& to)
{
    to.sigma = of.sigma;
    to.sigma_before = of.sigma_before;
    to.lit = of.lit;
}

VDBCLOUD_CLONES void pad(const Traversal& traversal, Scratch& s)
{
    for (int i = 0; i < 64; ++i) store(s.padded + row_at(i), load(s.radiance + i * 8));
    for (int region = 0; region < regions; ++region)
        set_apron(traversal, region, s.radiance_before.region[size_t(region)], s.radiance_before.pitch, s.padded);
}

void leave_face(const Traversal& traversal, int face, int d, const Scratch& s, const std::array<float, 64>& radiance,
                float* to)
{
    alignas(32) float sigma[64], q[64];
    const int first = face == 0 ? 1 : 0, second = face == 2 ? 1 : 2;  // the coordinates that run
    const int begin = traversal.last[size_t(face)] * traversal.row_stride[size_t(face)];
    for (int i = 0; i < 8; ++i)
        for (int j = 0; j < 8; ++j) {
            const int at = begin + i * traversal.row_stride[size_t(first)] + j * traversal.row_stride[size_t(second)];
            sigma[i * 8 + j] = s.sigma[at];
            q[i * 8 + j] = s.q[d][at];
        }
    leave(64, radiance.data(), sigma, q, traversal.half_exit[size_t(face)], to);
}

namespace {

/// Several terms at once, so that radiance is loaded once for them. `weight`: of each term `batch`.
template<int groups, bool first, int terms>
VDBCLOUD_INLINE void accumulate_terms(const Rows& rows, float* const* to, const float* weight, const Scratch& s)
{
    constexpr int directions = groups * group;
    Lanes w[terms][directions];
    for (int k = 0; k < terms; ++k)
        for (int d = 0; d < directions; ++d) w[k][d] = all(weight[k * batch + d]);
    for (int r = 0; r < rows.count; ++r) {
        const int i = rows.row[r] * 8;
        Lanes out[directions];
        for (int d = 0; d < directions; ++d) out[d] = load(s.out[d] + i);
        for (int k = 0; k < terms; ++k) {
            const auto sum = [&](int g) {
                return (w[k][g] * out[g] + w[k][g + 1] * out[g + 1]) +
                       (w[k][g + 2] * out[g + 2] + w[k][g + 3] * out[g + 3]);
            };
            Lanes total = sum(0);
            if (groups == 2) total += sum(group * (groups - 1));
            store(to[k] + i, first ? total : load(to[k] + i) + total);
        }
    }
}

template<int groups, bool first>
VDBCLOUD_INLINE void accumulate_all(const Rows& rows, int terms, float* const* to, const float* weight,
                                    const Scratch& s)
{
    constexpr int at_once = groups == 1 ? 3 : 1;  // as many as fit into the registers
    int k = 0;
    for (; k + at_once <= terms; k += at_once)
        accumulate_terms<groups, first, at_once>(rows, to + k, weight + k * batch, s);
    for (; k < terms; ++k) accumulate_terms<groups, first, 1>(rows, to + k, weight + k * batch, s);
}

}  // namespace

VDBCLOUD_CLONES void accumulate(const Rows& rows, int n, int terms, bool first, float* const* moments,
                                const float* weight, const Scratch& s)
{
    static_assert(group == 4 && batch == 2 * group);
    for (int k = 0; k < terms && first && rows.count < 64; ++k) std::memset(moments[k], 0, 512 * sizeof(float));
    if (n > group)
        first ? accumulate_all<2, true>(rows, terms, moments, weight, s)
              : accumulate_all<2, false>(rows, terms, moments, weight, s);
    else
        first ? accumulate_all<1, true>(rows, terms, moments, weight, s)
              : accumulate_all<1, false>(rows, terms, moments, weight, s);
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
