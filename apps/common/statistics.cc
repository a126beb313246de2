// What the report says of grids.
#include "shared.h"

#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

double scalar(float v) { return v; }
double scalar(const Vec3f& v) { return v.length(); }

/// Over active values, tiles by their volume.
struct Moments {
    double least = HUGE_VAL, greatest = -HUGE_VAL, sum = 0, count = 0, not_finite = 0;

    void add(double x, double times)
    {
        if (!std::isfinite(x)) {
            not_finite += times;
            return;
        }
        least = std::min(least, x);
        greatest = std::max(greatest, x);
        sum += x * times;
        count += times;
    }
};

template<typename GridT>
nlohmann::json statistics(const GridT& grid)
{
    Moments m;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto it = leaf->cbeginValueOn(); it; ++it) m.add(scalar(*it), 1);
    auto tile = grid.tree().cbeginValueOn();
    tile.setMaxDepth(GridT::TreeType::ValueOnCIter::LEAF_DEPTH - 1);
    for (; tile; ++tile) m.add(scalar(*tile), double(tile.getVoxelCount()));
    nlohmann::json out = {{"not_finite", m.not_finite}};
    if (m.count > 0) {
        out["min"] = m.least;
        out["max"] = m.greatest;
        out["mean"] = m.sum / m.count;
    }
    return out;
}

nlohmann::json list(const openvdb::Vec3d& v) { return {v[0], v[1], v[2]}; }

nlohmann::json describe(const GridBase& grid)
{
    nlohmann::json out = {{"name", grid.getName()}, {"type", grid.valueType()},
                          {"class", GridBase::gridClassToString(grid.getGridClass())},
                          {"active_voxels", uint64_t(grid.activeVoxelCount())},
                          {"memory_bytes", uint64_t(grid.memUsage())},
                          {"voxel_size", list(grid.voxelSize())}};
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (!box.empty()) {
        out["index_min"] = {box.min().x(), box.min().y(), box.min().z()};
        out["index_max"] = {box.max().x(), box.max().y(), box.max().z()};
        const openvdb::BBoxd world = grid.transform().indexToWorld(
            openvdb::BBoxd(box.min().asVec3d() - openvdb::Vec3d(0.5), box.max().asVec3d() + openvdb::Vec3d(0.5)));
        out["world_min"] = list(world.min());
        out["world_max"] = list(world.max());
    }
    if (const auto* floats = dynamic_cast<const FloatGrid*>(&grid)) out.update(statistics(*floats));
    if (const auto* vectors = dynamic_cast<const Vec3SGrid*>(&grid)) out.update(statistics(*vectors));
    return out;
}

}  // namespace

nlohmann::json describe(const GridFile& file)
{
    nlohmann::json all = nlohmann::json::array();
    for (const GridBasePtr& grid : file.grids) all.push_back(describe(*grid));
    return all;
}

}  // namespace vdbcloud::app
