#include "vdbcloud/sweep/aprons.h"

#include "vdbcloud/core/release.h"
#include "vdbcloud/sweep/patch_light.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

using block_sweep::DownstreamFaces;
using block_sweep::region_size;
using block_sweep::regions;
using block_sweep::Scratch;
using block_sweep::Traversal;
using block_sweep::zeros;

namespace {

constexpr int near_walls = 12;  // block walls through which the beams of a direction are followed in advance

}  // namespace

SweepPath::SweepPath(const Vec3d& step, size_t of) : traversal(step), number(of)
{
    for (int region = 0; region < regions; ++region) beams.emplace_back(traversal, region, near_walls);
}

size_t SweepPath::bytes() const
{
    size_t total = sizeof *this;
    for (const VoidBeam& beam : beams)
        total += sizeof beam + beam.crossings.size() * sizeof(VoidBeam::Crossing) +
                 beam.entries.size() * sizeof(VoidBeam::Entry);
    return total;
}

Aprons::Aprons(const Blocks& blocks, const VoidRays& rays) : blocks_(blocks), rays_(rays) {}

void Aprons::clear_cache(size_t directions, int width)
{
    ray_ends_.assign(directions * blocks_.count(), 0);
    width_ = size_t(width);
}

void Aprons::set_channels(int channels, size_t places)
{
    channels_ = size_t(channels);
    downstream_.resize(places * width_ * channels_);
}

void Aprons::start(const std::array<int, 3>& sign, const std::vector<int32_t>& place,
                   const std::vector<const PatchLight*>& below)
{
    below_ = below;
    place_ = &place;
    outer_of_.resize(blocks_.count());
    const std::array<int, 3> back{-sign[0], -sign[1], -sign[2]};
    int32_t count = 0;
    for (size_t b = 0; b < blocks_.count(); ++b) {
        // A ray through an edge or a corner meets a face that may touch another block.
        const Upstream beyond = upstream(back, b);
        for (int a = 0; a < 3; ++a) {
            bool open = false;
            for (size_t axes = 1; axes < 8; ++axes) open = open || (axes >> a & 1 && beyond[axes] < 0);
            outer_of_[b][size_t(a)] = open ? count++ : -1;
        }
    }
    outer_.resize(size_t(count) * 64 * width_ * channels_);
}

void Aprons::release() { vdbcloud::release(downstream_, outer_); }

Aprons::Upstream Aprons::upstream(const std::array<int, 3>& sign, size_t block) const
{
    Upstream result;
    result[0] = int32_t(block);
    for (int axes = 1; axes < 8; ++axes) {
        Vec3i at = blocks_.at(block);
        for (int a = 0; a < 3; ++a)
            if (axes >> a & 1) at[a] -= sign[a];
        result[size_t(axes)] = rays_.find(at);
    }
    return result;
}

void Aprons::load_sigma(const Traversal& traversal, const float* sigma, const Upstream& upstream, Scratch& s) const
{
    for (int region = 0; region < regions; ++region) {
        const int32_t from = upstream[size_t(traversal.region[size_t(region)])];
        s.sigma_before.region[size_t(region)] = from < 0 ? zeros : s.sigma_apron[region];
        if (from >= 0) block_sweep::take_region(traversal, region, sigma + size_t(from) * 512, s.sigma_apron[region]);
    }
}

const float* Aprons::face(size_t block, int axis, int d, size_t channel) const
{
    const int32_t outer = outer_of_[block][size_t(axis)];
    return outer < 0 ? zeros : &outer_[(at(size_t(outer), d) + channel) * 64];
}

namespace {

float value(const VoidBeam::Entry& entry, const float* face)
{
    const float* from = face + entry.cell;
    return (entry.weight[0] * from[0] + entry.weight[1] * from[1]) +
           (entry.weight[2] * from[8] + entry.weight[3] * from[9]);
}

}  // namespace

/// A region of the apron of a missing block, for one direction: voxels c with c[a] running along `along`.
struct Aprons::Patch {
    const SweepPath& path;
    int d;
    size_t first, channels;  // those that are filled
    const float* inflow;     // of each
    float* const* radiance;  // of each
    Vec3d corner;            // its first voxel, in block coordinates
    int along[2];            // axes; -1: none
    int stride[2];           // in `radiance` and `hit`
    int pitch = 1;           // from voxel to voxel
    uint64_t traced = 0;     // which of the hits have been traced
    VoidRays::Hit hit[64];

    Vec3d start(int i, int j) const
    {
        Vec3d from = corner;
        if (along[0] >= 0) from[along[0]] += i * pitch;
        if (along[1] >= 0) from[along[1]] += j * pitch;
        return from;
    }
    const VoidRays::Hit& trace(const VoidRays& rays, int i, int j)
    {
        const int k = i * stride[0] + j * stride[1];
        if (!(traced >> k & 1)) {
            hit[k] = rays.trace(start(i, j), path.traversal.step);
            traced |= uint64_t(1) << k;
        }
        return hit[k];
    }
};

/// Radiance of a ray that meets no block.
void Aprons::put_sky(const Patch& patch, int i, int j) const
{
    const int to = i * patch.stride[0] + j * patch.stride[1];
    for (size_t n = 0; n < patch.channels; ++n) {
        patch.radiance[n][to] = patch.inflow[n];
        if (!below_.empty())
            patch.radiance[n][to] +=
                float(below_[patch.first + n]->change(patch.start(i, j), patch.path.traversal.step));
    }
}

/// Radiance at the end of a ray: on a block's face, or the sky's.
void Aprons::put_light(const Patch& patch, const VoidRays::Hit& hit, int i, int j) const
{
    if (hit.block < 0) return put_sky(patch, i, j);
    const Traversal& traversal = patch.path.traversal;
    const int to = i * patch.stride[0] + j * patch.stride[1];
    for (size_t n = 0; n < patch.channels; ++n) patch.radiance[n][to] = 0;
    for (int k = 0; k < 3; ++k) {
        const int axis = traversal.axis[size_t(k)];
        if (!(hit.axes >> axis & 1)) continue;
        const auto entry = face_entry(traversal, k, hit.at, 1.0 / __builtin_popcount(unsigned(hit.axes)));
        for (size_t n = 0; n < patch.channels; ++n)
            patch.radiance[n][to] += value(entry, face(size_t(hit.block), axis, patch.d, patch.first + n));
    }
}

/// Fills the voxels lo..hi of a patch; true if all of it is sky.
///
/// Rays are parallel and a block is wider than any patch, so a block that stops one ray also stops a ray at a corner.
/// Where the corners' rays end on one face, or all in the sky, so do all rays between them.
bool Aprons::fill_patch(Patch& patch, const int* lo, const int* hi) const
{
    const Vec3d& step = patch.path.traversal.step;
    VoidRays::Hit first;
    bool one = true;
    for (int c = 0; c < 4 && one; ++c) {
        if ((c & 1 && lo[0] == hi[0]) || (c & 2 && lo[1] == hi[1])) continue;
        const VoidRays::Hit& hit = patch.trace(rays_, c & 1 ? hi[0] : lo[0], c & 2 ? hi[1] : lo[1]);
        if (c == 0) first = hit;
        one = hit.block == first.block && hit.axes == first.axes;
    }
    const bool on_edge = first.axes & (first.axes - 1);
    if (on_edge) one = lo[0] == hi[0] && lo[1] == hi[1];
    if (!one) {
        const int k = hi[0] - lo[0] >= hi[1] - lo[1] ? 0 : 1, middle = (lo[k] + hi[k]) / 2;
        int upper_lo[2] = {lo[0], lo[1]}, lower_hi[2] = {hi[0], hi[1]};
        lower_hi[k] = middle;
        upper_lo[k] = middle + 1;
        const bool lower_sky = fill_patch(patch, lo, lower_hi);
        return fill_patch(patch, upper_lo, hi) && lower_sky;
    }
    double slope[2][3] = {{0, 0, 0}, {0, 0, 0}};  // how the end moves with the start
    for (int k = 0; k < 2 && first.block >= 0 && !on_edge; ++k) {
        const int axis = first.axes >> 1;  // 1, 2, 4: 0, 1, 2
        for (int a = 0; a < 3 && patch.along[k] >= 0; ++a)
            if (a != axis)
                slope[k][a] = a == patch.along[k] ? 1.0 : patch.along[k] == axis ? -step[a] / step[axis] : 0.0;
    }
    for (int i = lo[0]; i <= hi[0]; ++i)
        for (int j = lo[1]; j <= hi[1]; ++j) {
            VoidRays::Hit hit = first;
            for (int a = 0; a < 3; ++a) hit.at[a] += slope[0][a] * (i - lo[0]) + slope[1][a] * (j - lo[1]);
            put_light(patch, hit, i, j);
        }
    return first.block < 0;
}

uint64_t Aprons::fill_tile(const SweepPath& path, int d, size_t first, size_t channels, const Vec3d& corner,
                           const std::array<int, 2>& along, float* const* radiance, int pitch) const
{
    constexpr float sky = std::numeric_limits<float>::infinity();  // no radiance: a mark
    const float marks[block_sweep::most_channels] = {sky, sky, sky};
    Patch patch{path, d, first, channels, marks, radiance, corner, {along[0], along[1]}, {8, 1}, pitch, 0, {}};
    const int lo[2] = {0, 0}, hi[2] = {7, 7};
    if (pitch == 1)
        fill_patch(patch, lo, hi);
    else
        for (int k = 0; k < 64; ++k) put_light(patch, patch.trace(rays_, k / 8, k % 8), k / 8, k % 8);
    uint64_t ends = 0;
    for (int k = 0; k < 64; ++k) ends |= uint64_t(radiance[0][k] == sky) << k;
    return ends;
}

uint64_t Aprons::fill_tile(const SweepPath& path, int d, size_t first, size_t channels, const Vec3d& corner,
                           const std::array<int, 2>& along, float* const* radiance, const int32_t* blocks,
                           size_t count) const
{
    Patch patch{path, d, first, channels, nullptr, radiance, corner, {along[0], along[1]}, {8, 1}, 1, 0, {}};
    uint64_t ends = 0;
    for (int k = 0; k < 64; ++k) {
        const auto hit = rays_.trace(patch.start(k / 8, k % 8), path.traversal.step, blocks, count);
        ends |= uint64_t(hit.block < 0) << k;
        for (size_t n = 0; n < channels; ++n) radiance[n][k] = 0;
        if (hit.block >= 0) put_light(patch, hit, k / 8, k % 8);
    }
    return ends;
}

/// Adds to `radiance` what reaches a region's rays from blocks near it; returns the rays that meet none, as bits.
uint64_t Aprons::from_near_blocks(const SweepPath& path, int d, int region, size_t block, float* const* radiance) const
{
    uint64_t unmet = ~uint64_t(0) >> (64 - region_size(region));
    const VoidBeam& beam = path.beams[size_t(region)];
    for (const VoidBeam::Crossing& crossing : beam.crossings) {
        const uint64_t meet = crossing.rays & unmet;
        if (!meet) continue;
        const int32_t found = rays_.find(blocks_.at(block) + crossing.offset);
        if (found < 0) continue;
        for (size_t c = 0; c < channels_; ++c) {
            const float* faces[3];
            for (int k = 0; k < 3; ++k) faces[k] = face(size_t(found), path.traversal.axis[size_t(k)], d, c);
            const VoidBeam::Entry* entry = &beam.entries[crossing.first_entry];
            for (uint32_t n = 0; n < crossing.entries; ++n, ++entry)
                if (unmet >> entry->ray & 1) radiance[c][entry->ray] += value(*entry, faces[entry->face]);
        }
        unmet &= ~meet;
        if (!unmet) break;
    }
    return unmet;
}

namespace {

/// Calls f(lo, hi) for rectangles that the rays of a region, as bits, fall into. `line`: they lie in one row.
template<typename F>
void for_rectangles(bool line, uint64_t rays, const F& f)
{
    while (rays) {
        const int first = __builtin_ctzll(rays), row = first / 8, column = first % 8;
        uint64_t across = 0;  // the run of the first ray, in the lowest row
        int last = column;
        for (; last < 8 && rays >> (row * 8 + last) & 1; ++last) across |= uint64_t(1) << last;
        int end = row;
        for (; end < 8 && (rays >> (end * 8) & across) == across; ++end) rays &= ~(across << (end * 8));
        const int lo[2] = {line ? column : row, line ? 0 : column};
        const int hi[2] = {line ? last - 1 : end - 1, line ? 0 : last - 1};
        f(lo, hi);
    }
}

}  // namespace

/// Radiance that reaches a region of the apron where its block is missing.
///
/// Blocks near the region come first (VoidBeam); rays that meet none of them are traced through the void. Cached in
/// ray_ends_: bit `region`: every ray that meets no near block ends in the sky; bit `region` + 8: no ray meets a near
/// block.
void Aprons::through_void(const SweepPath& path, int d, int region, size_t block, const float* inflow,
                          float* const* radiance)
{
    const int count = region_size(region);
    uint16_t& ends = ray_ends_[path.number * blocks_.count() + block];
    const uint16_t sky_beyond = uint16_t(1 << region), none_near = uint16_t(1 << (region + 8));
    const uint64_t all = ~uint64_t(0) >> (64 - count);
    uint64_t unmet = all;
    if (!(ends & none_near)) {
        for (size_t c = 0; c < channels_; ++c) std::fill_n(radiance[c], count, 0.0f);
        unmet = from_near_blocks(path, d, region, block, radiance);
        if (!unmet) return;
        if (unmet == all) ends = uint16_t(ends | none_near);
    }
    if (ends & sky_beyond && below_.empty()) {
        for (size_t c = 0; c < channels_; ++c)
            for (int n = 0; n < count; ++n)
                if (unmet >> n & 1) radiance[c][n] = inflow[c];
        return;
    }
    const std::array<int, 2> runs = region_runs(path.traversal, region);
    const Vec3d corner = region_corner(path.traversal, region, blocks_.at(block));
    Patch patch{path, d, 0, channels_, inflow, radiance, corner, {runs[0], runs[1]}, {runs[1] < 0 ? 1 : 8, 1},
                1,    0, {}};
    if (ends & sky_beyond) {
        for (int n = 0; n < count; ++n)
            if (unmet >> n & 1) put_sky(patch, runs[1] < 0 ? n : n / 8, runs[1] < 0 ? 0 : n % 8);
        return;
    }
    bool sky = true;
    for_rectangles(runs[1] < 0, unmet, [&](const int* lo, const int* hi) {
        if (!fill_patch(patch, lo, hi)) sky = false;
    });
    if (sky) ends = uint16_t(ends | sky_beyond);
}

void Aprons::load(const SweepPath& path, int d, size_t block, const Upstream& upstream, const float* inflow, Scratch* s)
{
    const Traversal& traversal = path.traversal;
    for (size_t region = 0; region < regions; ++region) {
        const int32_t from = upstream[size_t(traversal.region[region])];
        const bool along_w = block_sweep::region_axes[region] == 6;
        const DownstreamFaces* there = from < 0 ? nullptr : faces(size_t(from), d);
        float* in_void[block_sweep::most_channels];
        for (size_t c = 0; c < channels_; ++c) {
            Scratch& to = s[c];
            in_void[c] = to.from_void[region];
            if (along_w) to.radiance_before.pitch = to.source_before.pitch = there ? block_sweep::pitch_of_faces : 1;
            to.radiance_before.region[region] =
                there ? block_sweep::region_of(traversal, int(region), there[c].radiance) : in_void[c];
            to.source_before.region[region] =
                there ? block_sweep::region_of(traversal, int(region), there[c].source) : zeros;
        }
        if (!there) through_void(path, d, int(region), block, inflow, in_void);
    }
}

void Aprons::leave(const SweepPath& path, int d, size_t block, const Scratch* s)
{
    for (size_t k = 0; k < 3; ++k) {
        const int axis = path.traversal.axis[k], side = 2 * axis + (path.traversal.sign[k] > 0);
        const int32_t outer = outer_of_[block][size_t(axis)];
        const bool into_void = size_t(blocks_.neighbours(block)[size_t(side)]) == blocks_.count();
        for (size_t c = 0; c < channels_ && outer >= 0; ++c) {
            const std::array<float, 64>& radiance = faces(block, d)[c].radiance[k];
            float* to = &outer_[(at(size_t(outer), d) + c) * 64];
            if (into_void)
                block_sweep::leave_face(path.traversal, int(k), d, s[c], radiance, to);
            else
                std::copy(radiance.begin(), radiance.end(), to);
        }
    }
}

size_t Aprons::bytes() const
{
    return downstream_.size() * sizeof(DownstreamFaces) + outer_of_.size() * sizeof outer_of_[0] +
           outer_.size() * sizeof(float) + ray_ends_.size() * sizeof ray_ends_[0];
}

}  // namespace vdbcloud
