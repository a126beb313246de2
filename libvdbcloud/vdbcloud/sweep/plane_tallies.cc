#include "vdbcloud/sweep/plane_tallies.h"

#include "vdbcloud/sweep/patch_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace vdbcloud {

namespace {

/// n.s of a plane's outward normal n.
double outward(int face, const Vec3d& s) { return face % 2 ? s[face / 2] : -s[face / 2]; }

}  // namespace

PlaneTallies::PlaneTallies(const Blocks& blocks)
    : box_(blocks), faces_(find_tiles(blocks)), on_blocks_(blocks.count(), faces_, true)
{
}

std::vector<SweepFace> PlaneTallies::find_tiles(const Blocks& blocks)
{
    std::vector<SweepFace> faces;
    for (int face = 0; face < 6; ++face) {
        if (!box_.cells(face)) continue;
        const int axis = face / 2;
        const auto [u, v] = ActiveBox::axes(axis);
        Vec3i at;  // of a block
        at[axis] = (face % 2 ? box_.last : box_.first)[axis] >> 3;
        for (at[u] = box_.first[u] >> 3; at[u] <= box_.last[u] >> 3; ++at[u])
            for (at[v] = box_.first[v] >> 3; at[v] <= box_.last[v] >> 3; ++at[v]) {
                Vec3i voxel = at * 8;
                voxel[axis] = (face % 2 ? box_.last : box_.first)[axis];
                if (size_t(blocks.find(at)) == blocks.count()) {
                    voids_.push_back({face, voxel});
                    continue;
                }
                const Vec3i corner = voxel;
                for (int n = 0; n < 64; ++n) {
                    voxel[u] = corner[u] + n / 8;
                    voxel[v] = corner[v] + n % 8;
                    if (!box_.contains(voxel)) continue;
                    faces.push_back({uint32_t(blocks.slot(voxel)), uint8_t(face)});
                    cells_.push_back(box_.cell(face, voxel));
                }
            }
    }
    return faces;
}

void PlaneTallies::add_voids(const std::vector<SweepPath>& batch, const Aprons& aprons, const SweepSet& set,
                             const PatchLight* below)
{
    tbb::parallel_for(size_t(0), voids_.size(), [&](size_t n) {
        Tile& tile = voids_[n];
        const int axis = tile.face / 2;
        Vec3d corner(tile.corner.x(), tile.corner.y(), tile.corner.z());
        corner[axis] += tile.face % 2 ? inside_plane : -inside_plane;
        for (size_t d = 0; d < batch.size(); ++d) {
            const size_t m = batch[d].number;
            const double cosine = outward(tile.face, set.direction[m]);
            if (!(cosine > 0)) continue;
            alignas(32) float radiance[64];
            const uint64_t sky = aprons.fill_tile(batch[d], int(d), corner, ActiveBox::axes(axis), radiance);
            const float weight = float(cosine * set.weight[m]);
            const float inflow = set.inflow.empty() ? 0.0f : set.inflow[m];
            const auto [u, v] = ActiveBox::axes(axis);
            for (size_t k = 0; k < 64; ++k)
                if (sky >> k & 1) {
                    Vec3d at = corner;
                    at[u] += double(k / 8);
                    at[v] += double(k % 8);
                    const double change = below ? below->change(at, batch[d].traversal.step) : 0;
                    tile.from_sky[k] += weight * (inflow + float(change));
                } else
                    tile.from_medium[k] += weight * radiance[k];
        }
    });
}

void PlaneTallies::write(const SweepSet& set, PlaneLight& to) const
{
    set_half_ranges(set, to);
    for (int face = 0; face < 6; ++face) {
        to.from_medium[size_t(face)].assign(box_.cells(face), 0.0f);
        to.from_sky[size_t(face)].assign(box_.cells(face), 0.0f);
    }
    std::vector<FaceTally> tally;
    on_blocks_.write(tally);
    for (size_t n = 0; n < faces_.size(); ++n) to.from_medium[faces_[n].face][cells_[n]] = tally[n].current;
    for (const Tile& tile : voids_) {
        const auto [u, v] = ActiveBox::axes(tile.face / 2);
        for (int n = 0; n < 64; ++n) {
            Vec3i voxel = tile.corner;
            voxel[u] += n / 8;
            voxel[v] += n % 8;
            if (!box_.contains(voxel)) continue;
            const size_t cell = box_.cell(tile.face, voxel);
            to.from_medium[size_t(tile.face)][cell] = tile.from_medium[size_t(n)];
            to.from_sky[size_t(tile.face)][cell] = tile.from_sky[size_t(n)];
        }
    }
}

}  // namespace vdbcloud
