// Voxels of missing blocks, which rays reach from blocks far away.
#include "vdbcloud/sweep/periodic_planes.h"

#include <cmath>

namespace vdbcloud {

using periodic::wrapped;
using plane_kernel::batch;
using plane_kernel::Offset;

namespace {

/// Bits 8 u + v of the rectangle u0 .. u1, v0 .. v1.
uint64_t rectangle(int u0, int u1, int v0, int v1)
{
    uint64_t bits = 0;
    for (int a = u0; a <= u1; ++a) bits |= (uint64_t(0xff) >> (7 - v1 + v0)) << (8 * a + v0);
    return bits;
}

/// Calls f(u0, u1, v0, v1) for rectangles that together are `bits`.
template<typename F>
void for_rectangles(uint64_t bits, const F& f)
{
    while (bits) {
        const int first = __builtin_ctzll(bits), u0 = first / 8, v0 = first % 8;
        int v1 = v0, u1 = u0;
        while (v1 < 7 && bits >> (8 * u0 + v1 + 1) & 1) ++v1;
        const auto row = [&](int a) { return rectangle(a, a, v0, v1); };
        while (u1 < 7 && (bits & row(u1 + 1)) == row(u1 + 1)) ++u1;
        f(u0, u1, v0, v1);
        bits &= ~rectangle(u0, u1, v0, v1);
    }
}

}  // namespace

/// Finds what blocks of layer `here` look at in all its planes, and those of the layer `next` after it in its last.
void PeriodicSweep::Impl::find_needed(int here, int next, const Offset& offset, std::vector<Part>& needed) const
{
    // Voxels u0 .. u1 and v0 .. v1 of the plane, over the seam.
    const auto mark = [&](uint64_t Part::*mask, int u0, int u1, int v0, int v1) {
        for (int a = u0 >> 3; a <= u1 >> 3; ++a)
            for (int b = v0 >> 3; b <= v1 >> 3; ++b)
                needed[size_t(wrapped(a, tu) * tv + wrapped(b, tv))].*mask |= rectangle(
                    std::max(u0 - 8 * a, 0), std::min(u1 - 8 * a, 7), std::max(v0 - 8 * b, 0), std::min(v1 - 8 * b, 7));
    };
    for (int bu = 0; bu < tu; ++bu)
        for (int bv = 0; bv < tv; ++bv)
            for (const int layer : {here, next}) {
                if (block_at(layer, bu, bv) < 0) continue;
                const auto mask = layer == here ? &Part::all : &Part::last;
                const int at_u = 8 * bu, at_v = 8 * bv;
                mark(mask, at_u + offset.u, at_u + offset.u + 8, at_v + offset.v, at_v + offset.v + 8);
                mark(mask, at_u - 1, at_u + 8, at_v - 1, at_v + 8);
            }
}

/// Where the rays of missing blocks end, for one direction: once, as long as the directions stay the same.
void PeriodicSweep::Impl::find_pieces(int sign, int d, const Way& way)
{
    Pieces& to = pieces[way.number];
    if (!to.begin.empty()) return;
    VoidPieces finder(rays);
    const int last = sign > 0 ? 7 : 0;
    for (int layer = 0; layer < layers; ++layer) {
        std::vector<Part> needed(size_t(tu * tv));
        find_needed(layer, layer + sign, offsets[size_t(d)], needed);
        for (int n = 0; n < tu * tv; ++n) {
            to.begin.push_back(uint32_t(to.list.size()));
            const Part& part = needed[size_t(n)];
            if (block_at(layer, n / tv, n % tv) >= 0) continue;
            Vec3i at;
            at[w] = first_layer + layer;
            at[u] = first_u + n / tv;
            at[v] = first_v + n % tv;
            std::array<int, 3> lo{0, 0, 0}, hi{7, 7, 7};
            const auto find = [&](int u0, int u1, int v0, int v1) {
                lo[size_t(u)] = u0;
                hi[size_t(u)] = u1;
                lo[size_t(v)] = v0;
                hi[size_t(v)] = v1;
                finder.find(at, lo, hi, way.step, to.list);
            };
            for_rectangles(part.all, find);
            lo[size_t(w)] = hi[size_t(w)] = last;
            for_rectangles(part.last & ~part.all, find);
        }
    }
    to.begin.push_back(uint32_t(to.list.size()));
}

/// The voxels of missing blocks in plane p that others look at.
void PeriodicSweep::Impl::fill_voids(int p, int d, const Way& way)
{
    const Pieces& of = pieces[way.number];
    const int layer = layer_of(p), in_block = p & 7;
    for (int n = 0; n < tu * tv; ++n) {
        const size_t tile = size_t(layer * tu * tv + n);
        float* to = &radiance[now][size_t(d)][cell(8 * (n / tv), 8 * (n % tv))];
        for (uint32_t k = of.begin[tile]; k < of.begin[tile + 1]; ++k) {
            const VoidPiece& piece = of.list[k];
            if (in_block < piece.lo[size_t(w)] || in_block > piece.hi[size_t(w)]) continue;
            if (piece.block < 0)
                fill_from_outside(piece, p, n, way, to);
            else
                fill_from_block(piece, in_block, d, way, to);
        }
        if (n % tv == 0) close_rows(radiance[now][size_t(d)].data(), 8 * (n / tv), 8);
    }
}

void PeriodicSweep::Impl::fill_from_outside(const VoidPiece& piece, int p, int n, const Way& way, float* to) const
{
    for (int i = piece.lo[size_t(u)]; i <= piece.hi[size_t(u)]; ++i)
        for (int j = piece.lo[size_t(v)]; j <= piece.hi[size_t(v)]; ++j) {
            float light = way.sky;
            if (upward && ground) {
                Vec3d point;
                point[w] = p;
                point[u] = 8 * (first_u + n / tv) + i;
                point[v] = 8 * (first_v + n % tv) + j;
                light = float(outside(way, point));
            }
            to[cell(i, j)] = light;
        }
}

void PeriodicSweep::Impl::fill_from_block(const VoidPiece& piece, int in_block, int d, const Way& way, float* to) const
{
    VoidRays::Hit hit;
    hit.block = piece.block;
    hit.axes = piece.axes;
    if (piece.axes & (piece.axes - 1)) {  // a single voxel
        std::copy(piece.at.begin(), piece.at.end(), hit.at);
        float* one = to + cell(piece.lo[size_t(u)], piece.lo[size_t(v)]);
        *one = float(light_of(d, way, hit));
        return;
    }
    const size_t axis = size_t(piece.axes >> 1);
    const auto other = ActiveBox::axes(int(axis));
    float start[2], by_u[2], by_v[2];
    for (size_t k = 0; k < 2; ++k) {
        const size_t a = size_t(other[k]);
        const auto slope = [&](int along) { return void_slope(way.step, int(axis), int(a), along); };
        start[k] = float(piece.at[a] + slope(w) * (in_block - piece.lo[size_t(w)]) -
                         0.5 * way.step[int(a)] / std::abs(way.step[int(axis)]));
        by_u[k] = float(slope(u));
        by_v[k] = float(slope(v));
    }
    const float* face = &exits[(size_t(piece.block) * batch + size_t(d)) * 192 + 64 * axis];
    const int lo_u = piece.lo[size_t(u)], lo_v = piece.lo[size_t(v)];
    for (int i = lo_u; i <= piece.hi[size_t(u)]; ++i)
        for (int j = lo_v; j <= piece.hi[size_t(v)]; ++j) {
            int at[2];
            float f[2];
            for (size_t k = 0; k < 2; ++k) {
                const float place =
                    std::clamp(start[k] + by_u[k] * float(i - lo_u) + by_v[k] * float(j - lo_v), 0.0f, 7.0f);
                at[k] = std::min(int(place), 6);
                f[k] = place - float(at[k]);
            }
            const float* from = face + at[0] * 8 + at[1];
            const float light =
                (1 - f[0]) * ((1 - f[1]) * from[0] + f[1] * from[1]) + f[0] * ((1 - f[1]) * from[8] + f[1] * from[9]);
            to[cell(i, j)] = light;
        }
}

/// Keeps what leaves a tile of plane p through downstream faces of its block: after the half voxel beyond a centre
/// where the void begins there.
void PeriodicSweep::Impl::keep_exits(int p, int bu, int bv, int d, const Way& way)
{
    const int32_t block = block_at(layer_of(p), bu, bv);
    if (block < 0) return;
    const auto& neighbours = blocks.neighbours(size_t(block));
    for (int axis = 0; axis < 3; ++axis) {
        const double step = way.step[axis];
        const int side = step > 0 ? 7 : 0;
        if (step == 0 || (axis == w && (p & 7) != side)) continue;
        const bool open = size_t(neighbours[size_t(2 * axis + (step > 0))]) == blocks.count();
        const auto [first, second] = ActiveBox::axes(axis);
        float* to = &exits[(size_t(block) * batch + size_t(d)) * 192 + size_t(64 * axis)];
        for (int n = 0; n < (axis == w ? 64 : 8); ++n) {
            Vec3i in;  // in the block
            in[w] = p & 7;
            in[u] = axis == u ? side : axis == w ? n / 8 : n;
            in[v] = axis == v ? side : axis == w ? n % 8 : n;
            const size_t from = cell(8 * bu + in[u], 8 * bv + in[v]);
            float light = radiance[now][size_t(d)][from];
            if (const float s = sigma[now][from]; open && s > 0) {
                const float e = std::exp(float(-0.5 / std::abs(step)) * s);
                light = light * e + source[now][size_t(d)][from] / s * (1 - e);
            }
            to[in[first] * 8 + in[second]] = light;
        }
    }
}

/// Radiance where a ray meets a block's downstream face, from the centres' plane half a step before.
double PeriodicSweep::Impl::light_of(int d, const Way& way, const VoidRays::Hit& hit) const
{
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(hit.axes >> axis & 1)) continue;
        const auto other = ActiveBox::axes(axis);
        int at[2];
        double f[2];
        for (int k = 0; k < 2; ++k) {
            const double place = std::clamp(
                hit.at[other[size_t(k)]] - 0.5 * way.step[other[size_t(k)]] / std::abs(way.step[axis]), 0.0, 7.0);
            at[k] = std::min(int(place), 6);
            f[k] = place - at[k];
        }
        const float* from = &exits[(size_t(hit.block) * batch + size_t(d)) * 192 + size_t(64 * axis)];
        double light = 0;
        for (int n = 0; n < 4; ++n)
            light +=
                (n & 1 ? f[0] : 1 - f[0]) * (n & 2 ? f[1] : 1 - f[1]) * from[(at[0] + (n & 1)) * 8 + at[1] + (n >> 1)];
        sum += light / __builtin_popcount(unsigned(hit.axes));
    }
    return sum;
}

}  // namespace vdbcloud
