#include "vdbcloud/grid/extent.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>

namespace vdbcloud {

namespace {

float greatest(const FloatGrid& grid)
{
    float most = 0;
    for_each_active_tile(grid, [&](const auto& tile) { most = std::max(most, *tile); });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto value = leaf->cbeginValueOn(); value; ++value) most = std::max(most, *value);
    return most;
}

void add_corners(const openvdb::CoordBBox& box, const Transform& transform, std::vector<Vec3d>& out)
{
    const Vec3d low = box.min().asVec3d() - Vec3d(0.5), high = box.max().asVec3d() + Vec3d(0.5);
    for (int corner = 0; corner < 8; ++corner)
        out.push_back(transform.indexToWorld(
            Vec3d(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2])));
}

}  // namespace

std::vector<Vec3d> occupied_corners(const FloatGrid& grid, double fraction)
{
    std::vector<Vec3d> out;
    const float least = std::max(0.0f, float(fraction * greatest(grid)));
    for_each_active_tile(grid, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        if (*tile > least) add_corners(box, grid.transform(), out);
    });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        openvdb::CoordBBox box;
        for (auto value = leaf->cbeginValueOn(); value; ++value)
            if (*value > least) box.expand(value.getCoord());
        if (!box.empty()) add_corners(box, grid.transform(), out);
    }
    return out;
}

}  // namespace vdbcloud
