#include "vdbcloud/sweep/plane_tallies.h"

#include "vdbcloud/sweep/patch_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace vdbcloud {

using block_sweep::batch;

namespace {

constexpr size_t few = 2;     // blocks that shade a tile along a direction: its rays then ask each of them
constexpr double pad = 0.25;  // that a shadow is taken wider than it is [voxels]: rays start at middles of cells

Vec3d as_double(const Vec3i& v) { return Vec3d(v.x(), v.y(), v.z()); }

/// The part of t0..t1 in which low + slope t, high + slope t overlaps from..to; false if it is empty.
bool overlap(double low, double high, double slope, double from, double to, double& t0, double& t1)
{
    if (slope == 0) return high >= from && low <= to;
    const double p = (from - high) / slope, q = (to - low) / slope;
    t0 = std::max(t0, std::min(p, q));
    t1 = std::min(t1, std::max(p, q));
    return t0 <= t1;
}

}  // namespace

PlaneTallies::PlaneTallies(const Blocks& blocks, const SweepSet& set, const Vec3d& spacing, int channel, PlaneLight& to)
    : blocks_(blocks), set_(set), spacing_(spacing), channel_(channel), to_(to), box_(blocks), faces_(find_faces()),
      on_blocks_(blocks.count(), faces_, true), row_(blocks.count(), -1)
{
    set_half_ranges(set, to_);
    int32_t rows = 0;
    for (size_t b = 0; b < blocks.count(); ++b)
        if (on_blocks_.any(b)) row_[b] = rows++;
    for (auto& sums : sums_) sums.assign(size_t(rows) * batch, {0, 0, 0});
    for (int face = 0; face < 6; ++face) void_cells_[size_t(face)] = box_.cells(face);
    for (const SweepFace& face : faces_) --void_cells_[face.face];
    if (!to_.by_cell) return;
    voids_ = all_voids();
    cells_.resize(voids_.size());
}

std::vector<SweepFace> PlaneTallies::find_faces()
{
    std::vector<SweepFace> faces;
    for (size_t b = 0; b < blocks_.count(); ++b)
        for (int face = 0; face < 6; ++face) {
            const int axis = face / 2, plane = (face % 2 ? box_.last : box_.first)[axis];
            if (!box_.cells(face) || blocks_.at(b)[axis] != plane >> 3) continue;
            const auto [u, v] = ActiveBox::axes(axis);
            for (int n = 0; n < 64; ++n) {
                Vec3i voxel = blocks_.at(b) * 8;
                voxel[axis] = plane;
                voxel[u] += n / 8;
                voxel[v] += n % 8;
                if (!box_.contains(voxel)) continue;
                faces.push_back({uint32_t(blocks_.slot(voxel)), uint8_t(face)});
                face_voxels_.push_back(voxel);
            }
        }
    return faces;
}

bool PlaneTallies::is_void(const Vec3i& corner) const
{
    return size_t(blocks_.find(Vec3i(corner[0] >> 3, corner[1] >> 3, corner[2] >> 3))) == blocks_.count();
}

std::vector<PlaneTallies::Tile> PlaneTallies::all_voids() const
{
    std::vector<Tile> tiles;
    for (int face = 0; face < 6; ++face) {
        if (!box_.cells(face)) continue;
        const int axis = face / 2;
        const auto [u, v] = ActiveBox::axes(axis);
        Vec3i corner;
        corner[axis] = (face % 2 ? box_.last : box_.first)[axis];
        for (corner[u] = box_.first[u] & ~7; corner[u] <= box_.last[u]; corner[u] += 8)
            for (corner[v] = box_.first[v] & ~7; corner[v] <= box_.last[v]; corner[v] += 8)
                if (is_void(corner)) tiles.push_back({face, corner, 0, tiles.size()});
    }
    return tiles;
}

/// Adds the tiles of a plane on which the shadow of a block along a direction may fall.
void PlaneTallies::add_shadow(int face, uint8_t way, const Vec3d& step, size_t block, std::vector<Tile>& to) const
{
    const int axis = face / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    Vec3d low = as_double(blocks_.at(block)) * 8.0 - Vec3d(0.5 + pad), high = low + Vec3d(8 + 2 * pad);
    const double plane = face % 2 ? box_.last[axis] + 0.5 : box_.first[axis] - 0.5;
    const double p = (plane - low[axis]) / step[axis], q = (plane - high[axis]) / step[axis];
    double t0 = std::max(std::min(p, q), 0.0), t1 = std::max(p, q);
    if (!overlap(low[u], high[u], step[u], box_.first[u], box_.last[u], t0, t1) ||
        !overlap(low[v], high[v], step[v], box_.first[v], box_.last[v], t0, t1))
        return;
    const auto tiles = [](double from, double until, int first, int last) {
        return std::pair(int(std::clamp(std::floor(from + 0.5), double(first), double(last))) >> 3,
                         int(std::clamp(std::floor(until + 0.5), double(first), double(last))) >> 3);
    };
    const auto [u0, u1] = tiles(low[u] + std::min(step[u] * t0, step[u] * t1),
                                high[u] + std::max(step[u] * t0, step[u] * t1), box_.first[u], box_.last[u]);
    for (int tu = u0; tu <= u1; ++tu) {
        double from = t0, until = t1;
        if (!overlap(low[u], high[u], step[u], 8.0 * tu - 0.5, 8.0 * tu + 7.5, from, until)) continue;
        const auto [v0, v1] = tiles(low[v] + std::min(step[v] * from, step[v] * until),
                                    high[v] + std::max(step[v] * from, step[v] * until), box_.first[v], box_.last[v]);
        Tile tile{face, {}, way, 0, block, 1};
        tile.corner[axis] = (face % 2 ? box_.last : box_.first)[axis];
        tile.corner[u] = 8 * tu;
        for (int tv = v0; tv <= v1; ++tv) {
            tile.corner[v] = 8 * tv;
            to.push_back(tile);
        }
    }
}

/// The tiles without a block on which the shadow of a block falls, and the directions of a batch along which it does. A
/// ray against the light meets a block's downstream side first, so blocks whose downstream sides all touch blocks cast
/// no shadow of their own.
std::vector<PlaneTallies::Tile> PlaneTallies::shaded(const std::vector<SweepPath>& paths)
{
    std::vector<std::vector<Tile>> found(blocks_.count());
    tbb::parallel_for(size_t(0), blocks_.count(), [&](size_t b) {
        for (size_t d = 0; d < paths.size(); ++d) {
            const Vec3d& step = paths[d].traversal.step;
            bool outer = false;
            for (int a = 0; a < 3; ++a)
                outer =
                    outer || (step[a] != 0 && size_t(blocks_.neighbours(b)[2 * a + (step[a] > 0)]) == blocks_.count());
            for (int a = 0; a < 3 && outer; ++a)
                if (const int face = 2 * a + (step[a] > 0); step[a] != 0 && box_.cells(face) > 0)
                    add_shadow(face, uint8_t(1 << d), step, b, found[b]);
        }
    });
    std::vector<Tile> all;
    for (const auto& of_block : found) all.insert(all.end(), of_block.begin(), of_block.end());
    // Until here `first` is the block.
    const auto key = [](const Tile& t) { return std::make_tuple(t.face, t.corner[0], t.corner[1], t.corner[2]); };
    std::sort(all.begin(), all.end(), [&](const Tile& p, const Tile& q) {
        return std::make_tuple(key(p), p.first, p.ways) < std::make_tuple(key(q), q.first, q.ways);
    });
    shadows_.clear();
    std::vector<Tile> tiles;
    for (size_t n = 0, next = 0; n < all.size(); n = next) {
        for (next = n + 1; next < all.size() && key(all[next]) == key(all[n]);) ++next;
        if (!is_void(all[n].corner)) continue;
        Tile tile = all[n];
        tile.first = shadows_.size();
        tile.shadows = next - n;
        for (size_t k = n; k < next; ++k) {
            tile.ways |= all[k].ways;
            shadows_.push_back({int32_t(all[k].first), all[k].ways});
        }
        tiles.push_back(tile);
    }
    return tiles;
}

void PlaneTallies::add(const block_sweep::Traversal& traversal, int of_pass, int d, size_t block,
                       const Vec3d& direction, float weight, const block_sweep::Scratch& s)
{
    if (row_[block] >= 0)
        on_blocks_.add(traversal, d, block, direction, weight, s,
                       &sums_[size_t(of_pass)][size_t(row_[block]) * batch + size_t(d)]);
}

void PlaneTallies::take(const Tile& tile, const SweepPath& path, size_t d, uint64_t sky, const float* radiance,
                        const PatchLight* below, TileSums& sums)
{
    if (!to_.by_cell && !~sky) return;
    const int axis = tile.face / 2;
    const auto [u, v] = ActiveBox::axes(axis);
    const double weight = power(tile.face, path.number);
    Vec3d at;
    at[axis] = tile.corner[axis] + (tile.face % 2 ? inside_plane : -inside_plane);
    for (size_t k = 0; k < 64; ++k) {
        Vec3i voxel = tile.corner;
        voxel[u] += int(k / 8);
        voxel[v] += int(k % 8);
        if (!box_.contains(voxel)) continue;
        at[u] = voxel[u];
        at[v] = voxel[v];
        const bool from_sky = sky >> k & 1;
        double straight = 0;  // that would come if there were no block
        if (!from_sky || to_.by_cell)
            straight = weight * (inflow(path.number) + (below ? below->change(at, path.traversal.step) : 0));
        if (!from_sky) {
            sums.medium[d] += weight * double(radiance[k]);
            sums.hidden[d] += straight;
        }
        if (!to_.by_cell) continue;
        Cells& cells = cells_[tile.cells];
        if (from_sky)
            cells.from_sky[k] += float(straight);
        else
            cells.from_medium[k] += float(weight) * radiance[k];
    }
}

/// Adds what would come straight from the sky and the patch through the cells without a block, were they all open.
void PlaneTallies::add_sky(size_t m, int face, const PatchLight* below)
{
    double sum = inflow(m) * double(void_cells_[size_t(face)]);
    if (below) {
        Vec3d step;
        for (int a = 0; a < 3; ++a) step[a] = set_.direction[m][a] / spacing_[a];
        sum += below->sum_on_plane(face, step);
        for (size_t n = 0; n < faces_.size(); ++n) {
            if (faces_[n].face != face) continue;
            Vec3d at = as_double(face_voxels_[n]);
            at[face / 2] += face % 2 ? inside_plane : -inside_plane;
            sum -= below->change(at, step);
        }
    }
    to_.sky_along[size_t(face)][m] += power(face, m) * sum;
}

void PlaneTallies::add_voids(const std::vector<PlaneTallies*>& channels, const std::vector<SweepPath>& paths,
                             int of_pass, const Aprons& aprons, const std::vector<const PatchLight*>& below)
{
    PlaneTallies& first = *channels[0];
    std::vector<Tile> tiles = first.by_cell() ? first.voids_ : first.shaded(paths);
    for (Tile& tile : tiles)
        for (size_t d = 0; first.by_cell() && d < paths.size(); ++d)
            if (first.power(tile.face, paths[d].number) > 0) tile.ways |= uint8_t(1 << d);
    const auto below_of = [&](const PlaneTallies& of) { return below.empty() ? nullptr : below[size_t(of.channel_)]; };
    std::vector<std::vector<TileSums>> sums(channels.size(), std::vector<TileSums>(tiles.size()));
    tbb::parallel_for(size_t(0), tiles.size(), [&](size_t n) {
        const Tile& tile = tiles[n];
        const int axis = tile.face / 2;
        const auto along = ActiveBox::axes(axis);
        Vec3d corner = as_double(tile.corner);
        corner[axis] += tile.face % 2 ? inside_plane : -inside_plane;
        for (size_t d = 0; d < paths.size(); ++d) {
            if (!(tile.ways >> d & 1)) continue;
            alignas(32) float radiance[block_sweep::most_channels][64];
            float* const to[] = {radiance[0], radiance[1], radiance[2]};
            int32_t blocks[few];
            size_t count = 0;
            for (size_t k = tile.first; k < tile.first + tile.shadows && count <= few; ++k) {
                if (!(first.shadows_[k].ways >> d & 1)) continue;
                if (count < few) blocks[count] = first.shadows_[k].block;
                ++count;
            }
            const bool direct = count > 0 && count <= few;
            const uint64_t sky =
                direct ? aprons.fill_tile(paths[d], int(d), 0, aprons.channels(), corner, along, to, blocks, count)
                       : aprons.fill_tile(paths[d], int(d), 0, aprons.channels(), corner, along, to);
            for (size_t c = 0; c < channels.size(); ++c) {
                PlaneTallies& of = *channels[c];
                if (direct) sums[c][n].tests += 64 * count;
                of.take(tile, paths[d], d, sky, to[of.channel_], below_of(of), sums[c][n]);
            }
        }
    });
    for (size_t c = 0; c < channels.size(); ++c)
        channels[c]->add_voids(paths, of_pass, tiles, sums[c], below_of(*channels[c]));
}

void PlaneTallies::add_voids(const std::vector<SweepPath>& paths, int of_pass, const std::vector<Tile>& tiles,
                             const std::vector<TileSums>& sums, const PatchLight* below)
{
    std::vector<std::array<double, 3>>& on_blocks = sums_[size_t(of_pass)];
    for (const TileSums& of : sums) to_.tests += of.tests;
    for (size_t d = 0; d < paths.size(); ++d) {
        const size_t m = paths[d].number;
        for (int face = 0; face < 6; ++face)
            if (power(face, m) > 0 && box_.cells(face) > 0) add_sky(m, face, below);
        for (size_t n = 0; n < tiles.size(); ++n) {
            if (!(tiles[n].ways >> d & 1)) continue;
            to_.medium_along[size_t(tiles[n].face)][m] += sums[n].medium[d];
            to_.sky_along[size_t(tiles[n].face)][m] -= sums[n].hidden[d];
            ++to_.traced;
        }
        for (size_t row = 0; row < on_blocks.size() / batch; ++row)
            for (int a = 0; a < 3; ++a)
                if (const int face = 2 * a + (set_.direction[m][a] > 0); power(face, m) > 0)
                    to_.medium_along[size_t(face)][m] += on_blocks[row * batch + d][size_t(a)];
    }
    std::fill(on_blocks.begin(), on_blocks.end(), std::array<double, 3>{0, 0, 0});
}

void PlaneTallies::write() const
{
    for (int face = 0; face < 6; ++face) {
        const size_t cells = to_.by_cell ? box_.cells(face) : 0;
        to_.from_medium[size_t(face)].assign(cells, 0.0f);
        to_.from_sky[size_t(face)].assign(cells, 0.0f);
    }
    if (!to_.by_cell) return;
    std::vector<FaceTally> tally;
    on_blocks_.write(tally);
    for (size_t n = 0; n < faces_.size(); ++n)
        to_.from_medium[faces_[n].face][box_.cell(faces_[n].face, face_voxels_[n])] = tally[n].current;
    for (const Tile& tile : voids_) {
        const auto [u, v] = ActiveBox::axes(tile.face / 2);
        for (int n = 0; n < 64; ++n) {
            Vec3i voxel = tile.corner;
            voxel[u] += n / 8;
            voxel[v] += n % 8;
            if (!box_.contains(voxel)) continue;
            const size_t cell = box_.cell(tile.face, voxel);
            to_.from_medium[size_t(tile.face)][cell] = cells_[tile.cells].from_medium[size_t(n)];
            to_.from_sky[size_t(tile.face)][cell] = cells_[tile.cells].from_sky[size_t(n)];
        }
    }
}

}  // namespace vdbcloud
