#include "vdbcloud/grid/extent.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>

namespace vdbcloud {

namespace {

float amount(float value) { return value; }
float amount(const Vec3f& value) { return std::max({value[0], value[1], value[2]}); }

template<typename GridT>
float greatest(const GridT& grid)
{
    float most = 0;
    for_each_active_tile(grid, [&](const auto& tile) { most = std::max(most, amount(*tile)); });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto value = leaf->cbeginValueOn(); value; ++value) most = std::max(most, amount(*value));
    return most;
}

void add_corners(const openvdb::CoordBBox& box, double reach, const Transform& transform, std::vector<Vec3d>& out)
{
    const Vec3d low = box.min().asVec3d() - Vec3d(reach), high = box.max().asVec3d() + Vec3d(reach);
    for (int corner = 0; corner < 8; ++corner)
        out.push_back(transform.indexToWorld(
            Vec3d(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2])));
}

/// Corners of boxes that reach `reach` voxels beyond the centres of voxels above `least`.
template<typename GridT>
std::vector<Vec3d> corners_above(const GridT& grid, float least, double reach)
{
    std::vector<Vec3d> out;
    for_each_active_tile(grid, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        if (amount(*tile) > least) add_corners(box, reach, grid.transform(), out);
    });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        openvdb::CoordBBox box;
        for (auto value = leaf->cbeginValueOn(); value; ++value)
            if (amount(*value) > least) box.expand(value.getCoord());
        if (!box.empty()) add_corners(box, reach, grid.transform(), out);
    }
    return out;
}

template<typename GridT>
std::vector<Vec3d> corners_above_fraction(const GridT& grid, double fraction)
{
    return corners_above(grid, std::max(0.0f, float(fraction * greatest(grid))), 0.5);
}

}  // namespace

std::vector<Vec3d> occupied_corners(const FloatGrid& grid, double fraction)
{
    return corners_above_fraction(grid, fraction);
}

std::vector<Vec3d> occupied_corners(const Vec3SGrid& grid, double fraction)
{
    return corners_above_fraction(grid, fraction);
}

std::vector<Vec3d> interpolant_corners(const FloatGrid& grid) { return corners_above(grid, 0, 1); }

std::vector<Vec3d> interpolant_corners(const Vec3SGrid& grid) { return corners_above(grid, 0, 1); }

}  // namespace vdbcloud
