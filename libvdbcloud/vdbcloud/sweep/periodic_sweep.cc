#include "vdbcloud/sweep/periodic_sweep.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sweep/ground_sums.h"
#include "vdbcloud/sweep/plane_kernel.h"
#include "vdbcloud/sweep/void_pieces.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace vdbcloud {

using plane_kernel::batch;
using plane_kernel::Job;
using plane_kernel::Offset;

namespace {

constexpr int slot_stride[3] = {64, 8, 1};

int wrapped(int k, int size)
{
    k %= size;
    return k < 0 ? k + size : k;
}

/// Calls f(0) ... f(count - 1), in parallel where there is work for it.
template<typename F>
void each(int count, bool large, const F& f)
{
    if (large)
        tbb::parallel_for(0, count, f);
    else
        for (int n = 0; n < count; ++n) f(n);
}

/// A direction of a batch.
struct Way {
    Vec3d step;  // voxels per world unit
    size_t number;
    float sky;
};

}  // namespace

struct PeriodicSweep::Impl {
    Impl(const VoxelIndex&, const std::vector<SweepFace>&);

    // Layers of blocks, planes of voxels. A tile is a block's part of a plane.
    int32_t block_at(int layer, int bu, int bv) const
    {
        return layer < 0 || layer >= layers ? -1 : tiles[size_t((layer * tu + bu) * tv + bv)];
    }
    int layer_of(int p) const { return (p >> 3) - first_layer; }
    size_t cell(int row, int column) const { return size_t(row) * plane_kernel::pitch_of(nv) + size_t(column); }

    void start(const SweepSet&, const SweepFields&, SweepResult&, PlaneLight*, SweepGround*);
    void sweep(int sign, const std::vector<Way>&);
    void enter(int p, const std::vector<Way>&);
    void cross_plane(int p, const std::vector<Way>&, Job&);
    void find_pieces(int sign, int d, const Way&);
    void fill_voids(int p, int d, const Way&);
    /// The part of a tile that others look at; empty at first.
    struct Part {
        int lo_u = 8, hi_u = -1, lo_v = 8, hi_v = -1;

        void widen(int u0, int u1, int v0, int v1)
        {
            lo_u = std::min(lo_u, u0);
            hi_u = std::max(hi_u, u1);
            lo_v = std::min(lo_v, v0);
            hi_v = std::max(hi_v, v1);
        }
    };
    void find_needed(int here, int next, const Offset&, std::vector<Part>&) const;
    /// Repeats the first columns of rows at their ends.
    void close_rows(float* plane, int first, int count) const
    {
        for (int row = first; row < first + count; ++row) std::copy_n(plane + cell(row, 0), 8, plane + cell(row, nv));
    }
    void keep_exits(int p, int bu, int bv, int d, const Way&);
    void tally(int p, int sign, const std::vector<Way>&);
    void leave(int p, int sign, const std::vector<Way>&, bool of_blocks);
    void finish(const SweepSet&, SweepResult&, PlaneLight*);

    float at(int d, bool before, const Vec3i& voxel) const
    {
        return radiance[before ? 1 - now : now][size_t(d)][cell(wrapped(voxel[u], nu), wrapped(voxel[v], nv))];
    }
    double on_face(int d, const Way&, int p, const Vec3i& voxel, int face) const;
    std::optional<double> through_void(int d, const Way&, const Vec3d& point) const;
    double outside(const Way& way, const Vec3d& point) const
    {
        return upward && ground ? ground->radiance(point, way.step) : double(way.sky);
    }
    double light_of(int d, const Way&, const VoidRays::Hit&) const;

    void fill_from_outside(const VoidPiece&, int p, int tile, const Way&, float* to) const;
    void fill_from_block(const VoidPiece&, int in_block, int d, const Way&, float* to) const;

    const VoxelIndex& index;
    const Blocks& blocks;
    const VoidRays rays;
    const ActiveBox box;
    int w, u, v;  // across the planes; along them
    int nu, nv, tu, tv;
    int first_layer = 0, layers = 0;
    std::vector<int32_t> tiles;  // blocks by layer, u, v; -1: missing
    std::vector<char> whole;     // layers without missing tiles
    bool has_voids = false, large = false;
    struct Face {
        uint32_t number;
        Vec3i voxel;
        uint8_t face;
    };
    std::vector<std::vector<Face>> faces;  // by plane
    size_t face_count;

    // Of the run:
    const SweepSet* set = nullptr;
    const SweepFields* fields = nullptr;
    SweepResult* result = nullptr;
    std::optional<GroundSums> ground;
    bool upward = false;  // directions begin on the ground
    std::vector<std::array<double, 3>> sums;
    std::vector<double> from_medium[2], from_sky[2];  // lower, upper plane
    bool with_planes = false;
    // Of the batch: the plane before and the one now, by `now`.
    int now = 0;
    std::vector<float> radiance[2][batch], source[2][batch], sigma[2];
    std::vector<Offset> offsets;
    struct Pieces {
        std::vector<VoidPiece> list;
        std::vector<uint32_t> begin;  // of each tile of each layer, and the end
    };
    std::vector<Pieces> pieces;  // by direction
    std::vector<Vec3d> known;    // directions that the pieces are of
    std::vector<float> exits;    // by block, direction, axis: radiance on the 8 x 8 centres before a downstream face
};

bool PeriodicSweep::takes(const Vec3i& period) { return (period[0] > 0) + (period[1] > 0) + (period[2] > 0) == 2; }

PeriodicSweep::Impl::Impl(const VoxelIndex& of, const std::vector<SweepFace>& list)
    : index(of), blocks(of.blocks()), rays(blocks), box(blocks), face_count(list.size())
{
    w = blocks.period()[0] == 0 ? 0 : blocks.period()[1] == 0 ? 1 : 2;
    u = ActiveBox::axes(w)[0];
    v = ActiveBox::axes(w)[1];
    tu = blocks.period()[u];
    tv = blocks.period()[v];
    nu = 8 * tu;
    nv = 8 * tv;
    if (blocks.count() == 0) return;
    int last = blocks.at(0)[w];
    first_layer = last;
    for (size_t b = 0; b < blocks.count(); ++b) {
        first_layer = std::min(first_layer, blocks.at(b)[w]);
        last = std::max(last, blocks.at(b)[w]);
    }
    layers = last - first_layer + 1;
    tiles.assign(size_t(layers) * size_t(tu * tv), -1);
    for (size_t b = 0; b < blocks.count(); ++b) {
        const Vec3i& at = blocks.at(b);
        tiles[size_t(((at[w] - first_layer) * tu + at[u]) * tv + at[v])] = int32_t(b);
    }
    for (int layer = 0; layer < layers; ++layer) {
        const auto begin = tiles.begin() + layer * tu * tv;
        whole.push_back(std::find(begin, begin + tu * tv, -1) == begin + tu * tv);
        has_voids = has_voids || !whole.back();
    }
    large = nu * nv >= 4096;
    faces.resize(size_t(8 * layers));
    for (size_t n = 0; n < list.size(); ++n) {
        const Vec3i voxel = blocks.voxel(list[n].slot);
        faces[size_t(voxel[w] - 8 * first_layer)].push_back({uint32_t(n), voxel, list[n].face});
    }
}

void PeriodicSweep::Impl::start(const SweepSet& with, const SweepFields& of, SweepResult& to, PlaneLight* planes,
                                SweepGround* on_ground)
{
    set = &with;
    fields = &of;
    result = &to;
    with_planes = planes;
    ground.reset();
    if (on_ground) ground.emplace(blocks, *on_ground);
    to.moments.resize(size_t(with.moment_terms));
    for (auto& moment : to.moments) moment.assign(blocks.slots(), 0.0f);
    sums.assign(face_count, {0, 0, 0});
    for (int side = 0; side < 2; ++side) {
        from_medium[side].assign(with_planes ? box.cells(2 * w + side) : 0, 0.0);
        from_sky[side] = from_medium[side];
    }
    const size_t size = cell(nu, 0);
    for (int k = 0; k < 2; ++k) {
        sigma[k].assign(size, 0.0f);
        for (int d = 0; d < batch; ++d) {
            radiance[k][d].assign(size, 0.0f);
            source[k][d].assign(size, 0.0f);
        }
    }
    if (known != with.direction) {
        known = with.direction;
        pieces.assign(with.count(), {});
    }
    if (has_voids) exits.assign(blocks.count() * batch * 192, 0.0f);
}

void PeriodicSweep::Impl::sweep(int sign, const std::vector<Way>& ways)
{
    offsets.clear();
    for (const Way& way : ways) offsets.emplace_back(way.step, w, u, v, nu, nv);
    const int first = 8 * first_layer, last = first + 8 * layers - 1;
    const int begin = sign > 0 ? first : last, exit = sign > 0 ? box.last[w] : box.first[w];
    std::vector<float> basis(size_t(set->source_terms) * batch, 0.0f), weight(size_t(set->moment_terms) * batch, 0.0f);
    for (size_t d = 0; d < ways.size(); ++d) {
        const size_t m = ways[d].number;
        for (int k = 0; k < set->source_terms; ++k)
            basis[size_t(k * batch) + d] = set->source_basis[m * size_t(set->source_terms) + size_t(k)];
        for (int k = 0; k < set->moment_terms; ++k)
            weight[size_t(k * batch) + d] =
                set->weight[m] * set->moment_basis[m * size_t(set->moment_terms) + size_t(k)];
    }
    Job job;
    job.directions = int(ways.size());
    job.offsets = offsets.data();
    job.sigma = fields->sigma_t->data();
    for (const auto& term : *fields->source) job.source.push_back(term.data());
    for (auto& moment : result->moments) job.moments.push_back(moment.data());
    job.basis = basis.data();
    job.weight = weight.data();
    job.rows = nu;
    job.columns = nv;
    job.contiguous = slot_stride[v] == 1;
    enter(begin - sign, ways);
    if (has_voids) each(int(ways.size()), true, [&](int d) { find_pieces(sign, d, ways[size_t(d)]); });
    for (int p = begin; p >= first && p <= last; p += sign) {
        now = 1 - now;
        cross_plane(p, ways, job);
        if (has_voids)
            each(int(ways.size()), true, [&](int d) {
                for (int n = 0; n < tu * tv; ++n) keep_exits(p, n / tv, n % tv, d, ways[size_t(d)]);
                if (!whole[size_t(layer_of(p))]) fill_voids(p, d, ways[size_t(d)]);
            });
        tally(p, sign, ways);
        if (p == exit) leave(p, sign, ways, true);
    }
    leave(exit, sign, ways, false);
}

/// The plane before the first: all of it lies outside the blocks.
void PeriodicSweep::Impl::enter(int p, const std::vector<Way>& ways)
{
    std::fill(sigma[now].begin(), sigma[now].end(), 0.0f);
    for (size_t d = 0; d < ways.size(); ++d) {
        std::fill(source[now][d].begin(), source[now][d].end(), 0.0f);
        if (!(upward && ground)) {
            std::fill(radiance[now][d].begin(), radiance[now][d].end(), ways[d].sky);
            continue;
        }
        Vec3d point;
        point[w] = p;
        for (int row = 0; row < nu; ++row)
            for (int column = 0; column < nv; ++column) {
                point[u] = row;
                point[v] = column;
                radiance[now][d][cell(row, column)] = float(outside(ways[d], point));
            }
        close_rows(radiance[now][d].data(), 0, nu);
    }
}

/// The voxels of existing blocks, and their part of the moments.
void PeriodicSweep::Impl::cross_plane(int p, const std::vector<Way>& ways, Job& job)
{
    const int layer = layer_of(p);
    for (size_t d = 0; d < ways.size(); ++d) {
        job.before[d] = {radiance[1 - now][d].data(), source[1 - now][d].data()};
        job.here[d] = {radiance[now][d].data(), source[now][d].data()};
    }
    job.sigma_before = sigma[1 - now].data();
    job.sigma_here = sigma[now].data();
    each(nu, large, [&](int row) {
        const size_t in_block = size_t((p & 7) * slot_stride[w] + (row & 7) * slot_stride[u]);
        plane_kernel::sweep_row(job, row, &tiles[size_t((layer * tu + (row >> 3)) * tv)], tv, in_block);
    });
}

/// Widens the parts of tiles in layer `here` that the next plane, in layer `next`, or faces look at.
void PeriodicSweep::Impl::find_needed(int here, int next, const Offset& offset, std::vector<Part>& needed) const
{
    // Voxels u0 .. u1 and v0 .. v1 of the plane, over the seam.
    const auto mark = [&](int u0, int u1, int v0, int v1) {
        for (int a = u0 >> 3; a <= u1 >> 3; ++a)
            for (int b = v0 >> 3; b <= v1 >> 3; ++b)
                needed[size_t(wrapped(a, tu) * tv + wrapped(b, tv))].widen(
                    std::max(u0 - 8 * a, 0), std::min(u1 - 8 * a, 7), std::max(v0 - 8 * b, 0), std::min(v1 - 8 * b, 7));
    };
    for (int bu = 0; bu < tu; ++bu)
        for (int bv = 0; bv < tv; ++bv) {
            const int first_u = 8 * bu, first_v = 8 * bv;
            const bool in_next = block_at(next, bu, bv) >= 0;
            if (in_next) mark(first_u + offset.u, first_u + offset.u + 8, first_v + offset.v, first_v + offset.v + 8);
            if (in_next || block_at(here, bu, bv) >= 0) mark(first_u - 1, first_u + 8, first_v - 1, first_v + 8);
        }
}

/// Where the rays of missing blocks end, for one direction: once, as long as the directions stay the same.
void PeriodicSweep::Impl::find_pieces(int sign, int d, const Way& way)
{
    Pieces& to = pieces[way.number];
    if (!to.begin.empty()) return;
    VoidPieces finder(rays);
    for (int layer = 0; layer < layers; ++layer) {
        std::vector<Part> needed(size_t(tu * tv));
        for (const int next : {layer, layer + sign}) find_needed(layer, next, offsets[size_t(d)], needed);
        for (int n = 0; n < tu * tv; ++n) {
            to.begin.push_back(uint32_t(to.list.size()));
            const Part& part = needed[size_t(n)];
            if (part.hi_u < 0 || block_at(layer, n / tv, n % tv) >= 0) continue;
            Vec3i at;
            at[w] = first_layer + layer;
            at[u] = n / tv;
            at[v] = n % tv;
            std::array<int, 3> lo{0, 0, 0}, hi{7, 7, 7};
            lo[size_t(u)] = part.lo_u;
            hi[size_t(u)] = part.hi_u;
            lo[size_t(v)] = part.lo_v;
            hi[size_t(v)] = part.hi_v;
            finder.find(at, lo, hi, way.step, to.list);
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
                point[u] = 8 * (n / tv) + i;
                point[v] = 8 * (n % tv) + j;
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
    const auto along_w = void_slope(piece, way.step, w), along_u = void_slope(piece, way.step, u),
               along_v = void_slope(piece, way.step, v);
    float start[2], by_u[2], by_v[2];
    for (size_t k = 0; k < 2; ++k) {
        const size_t a = size_t(other[k]);
        start[k] = float(piece.at[a] + along_w[a] * (in_block - piece.lo[size_t(w)]) -
                         0.5 * way.step[int(a)] / std::abs(way.step[int(axis)]));
        by_u[k] = float(along_u[a]);
        by_v[k] = float(along_v[a]);
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

/// L on a face of a voxel of plane p in an existing block, as the reference has it.
double PeriodicSweep::Impl::on_face(int d, const Way& way, int p, const Vec3i& voxel, int face) const
{
    const int axis = face / 2, outward = face % 2 ? 1 : -1, sides[2] = {(axis + 1) % 3, (axis + 2) % 3};
    const double across = way.step[axis];
    if (across == 0) return at(d, false, voxel);
    const bool leaves = across * outward > 0;
    double aside[2], light = 0;
    for (int k = 0; k < 2; ++k) aside[k] = std::min(0.5 * std::abs(way.step[sides[k]] / across), 1.0);
    for (int n = 0; n < 4; ++n) {
        const double weight = (n & 1 ? aside[0] : 1 - aside[0]) * (n & 2 ? aside[1] : 1 - aside[1]);
        if (!(weight > 0)) continue;
        Vec3i from = voxel;
        if (!leaves) from[axis] += outward;
        for (int k = 0; k < 2; ++k)
            if (n >> k & 1) from[sides[k]] -= way.step[sides[k]] > 0 ? 1 : -1;
        light += weight * at(d, from[w] != p, from);
    }
    if (!leaves) return light;
    const size_t own = cell(wrapped(voxel[u], nu), wrapped(voxel[v], nv));
    const float s = sigma[now][own];
    if (!(s > 0)) return light;
    const double e = std::exp(-0.5 * s / std::abs(across));
    return light * e + source[now][size_t(d)][own] / s * (1 - e);
}

void PeriodicSweep::Impl::tally(int p, int, const std::vector<Way>& ways)
{
    const auto& here = faces[size_t(p - 8 * first_layer)];
    each(int(here.size()), here.size() > 512, [&](int n) {
        const Face& face = here[size_t(n)];
        for (size_t d = 0; d < ways.size(); ++d) {
            const size_t m = ways[d].number;
            const double cosine = (face.face % 2 ? 1 : -1) * set->direction[m][face.face / 2];
            const double weighted = set->weight[m] * on_face(int(d), ways[d], p, face.voxel, face.face);
            sums[face.number][0] += cosine * weighted;
            sums[face.number][1] += weighted;
            sums[face.number][2] += (cosine * cosine - 1.0 / 3) * weighted;
        }
    });
}

/// The plane p through which light leaves the box: what planes and ground take from cells of existing blocks, or from
/// the other cells. These see blocks up to half a voxel beyond the plane, so they come after the last plane.
void PeriodicSweep::Impl::leave(int p, int sign, const std::vector<Way>& ways, bool of_blocks)
{
    const int face = 2 * w + (sign > 0), side = sign > 0;
    const bool to_ground = ground && ground->face() == face;
    if ((!with_planes && !to_ground) || (!of_blocks && whole[size_t(layer_of(p))])) return;
    for (size_t d = 0; to_ground && of_blocks && d < ways.size(); ++d)
        ground->gather_unit(set->weight[ways[d].number] * std::abs(set->direction[ways[d].number][w]));
    each(nu, large, [&](int row) {
        for (int column = 0; column < nv; ++column) {
            Vec3i voxel;
            voxel[w] = p;
            voxel[u] = row;
            voxel[v] = column;
            if ((block_at(layer_of(p), row >> 3, column >> 3) >= 0) != of_blocks) continue;
            const size_t n = box.cell(face, voxel);
            for (size_t d = 0; d < ways.size(); ++d) {
                const size_t m = ways[d].number;
                const double out = set->weight[m] * std::abs(set->direction[m][w]);
                std::optional<double> light;
                if (of_blocks)
                    light = on_face(int(d), ways[d], p, voxel, face);
                else {
                    Vec3d point(voxel[0], voxel[1], voxel[2]);
                    point[w] += sign * inside_plane;
                    light = through_void(int(d), ways[d], point);
                }
                if (with_planes) (light ? from_medium : from_sky)[side][n] += out * light.value_or(ways[d].sky);
                if (to_ground) ground->gather(n, out * light.value_or(ways[d].sky));
            }
        }
    });
}

std::optional<double> PeriodicSweep::Impl::through_void(int d, const Way& way, const Vec3d& point) const
{
    const VoidRays::Hit hit = rays.trace(point, way.step);
    if (hit.block >= 0) return light_of(d, way, hit);
    if (upward && ground) return outside(way, point);
    return std::nullopt;
}

void PeriodicSweep::Impl::finish(const SweepSet& with, SweepResult& to, PlaneLight* planes)
{
    each(int(blocks.count()), large, [&](int b) {
        for (size_t x = 0; x < 8; ++x) {
            const uint64_t mask = blocks.mask(size_t(b))[x];
            for (size_t n = 0; ~mask && n < 64; ++n)
                for (auto& moment : to.moments)
                    if (!(mask >> n & 1)) moment[size_t(b) * 512 + x * 64 + n] = 0;
        }
    });
    to.tally.resize(face_count);
    for (size_t n = 0; n < face_count; ++n) to.tally[n] = {float(sums[n][0]), float(sums[n][1]), float(sums[n][2])};
    if (ground) ground->reflect();
    if (!planes) return;
    set_half_ranges(with, *planes);
    for (size_t face = 0; face < 6; ++face) {
        planes->from_medium[face].clear();
        planes->from_sky[face].clear();
    }
    for (size_t side = 0; side < 2; ++side) {
        const size_t face = size_t(2 * w) + side;
        planes->from_medium[face].assign(from_medium[side].begin(), from_medium[side].end());
        planes->from_sky[face].assign(from_sky[side].begin(), from_sky[side].end());
    }
}

PeriodicSweep::PeriodicSweep(const VoxelIndex& index, const std::vector<SweepFace>& faces)
    : impl_(std::make_unique<Impl>(index, faces))
{
}
PeriodicSweep::~PeriodicSweep() = default;

void PeriodicSweep::run(const SweepSet& set, const SweepFields& fields, SweepResult& result, PlaneLight* planes,
                        SweepGround* ground)
{
    Impl& my = *impl_;
    my.start(set, fields, result, planes, ground);
    std::vector<Way> ways[2];  // down and up along the axis across the planes
    for (size_t m = 0; m < set.count(); ++m) {
        Way way{{}, m, set.inflow.empty() ? 0.0f : set.inflow[m]};
        for (int a = 0; a < 3; ++a) way.step[a] = set.direction[m][a] / my.index.spacing()[a];
        if (way.step[my.w] == 0)
            throw InputError("a direction along periodic axes only: expected one that leaves the medium");
        ways[way.step[my.w] > 0].push_back(way);
    }
    // Light that ends on a ground comes first. Over a black one the order is that without a ground.
    const bool upper_first = my.ground && !my.ground->black() && my.ground->face() % 2;
    for (const bool upwards : {upper_first, !upper_first}) {
        my.upward = my.ground && (my.ground->face() % 2 == 1) != upwards;
        if (my.upward && !my.ground->black()) my.ground->reflect();
        const std::vector<Way>& all = ways[upwards];
        for (size_t n = 0; n < all.size() && my.layers > 0; n += batch)
            my.sweep(upwards ? 1 : -1,
                     {all.begin() + std::ptrdiff_t(n), all.begin() + std::ptrdiff_t(std::min(n + batch, all.size()))});
    }
    my.finish(set, result, planes);
}

size_t PeriodicSweep::bytes() const
{
    size_t in_pieces = 0;
    for (const auto& of : impl_->pieces) in_pieces += of.list.size() * sizeof(VoidPiece) + 4 * of.begin.size();
    return in_pieces + 4 * impl_->exits.size() + 4 * impl_->cell(impl_->nu, 0) * (2 * (2 * batch + 1)) +
           impl_->face_count * 64;
}

}  // namespace vdbcloud
