#include "vdbcloud/grid/statistics.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

double magnitude(float x) { return double(x); }
double magnitude(double x) { return x; }
double magnitude(const Vec3f& x) { return Vec3d(x).length(); }

/// Minimum, maximum and weighted sum of values, summed in the order of the calls.
struct Tally {
    double min = std::numeric_limits<double>::infinity(), max = -min, sum = 0;
    uint64_t count = 0, not_finite = 0;

    void add(double x, uint64_t voxels)
    {
        if (!std::isfinite(x)) {
            not_finite += voxels;
            return;
        }
        min = std::min(min, x);
        max = std::max(max, x);
        sum += x * double(voxels);
        count += voxels;
    }
};

template<typename GridT>
bool measure(const GridBase& base, GridStatistics& result)
{
    const auto* grid = dynamic_cast<const GridT*>(&base);
    if (!grid) return false;
    Tally total;
    for_each_active_tile(*grid, [&](const auto& tile) { total.add(magnitude(*tile), tile.getVoxelCount()); });
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
        Tally part;  // partial sums per leaf, against rounding in large grids
        for (auto value = leaf->cbeginValueOn(); value; ++value) part.add(magnitude(*value), 1);
        total.min = std::min(total.min, part.min);
        total.max = std::max(total.max, part.max);
        total.sum += part.sum;
        total.count += part.count;
        total.not_finite += part.not_finite;
    }
    result.has_values = true;
    result.not_finite = total.not_finite;
    if (total.count > 0) {
        result.min = total.min;
        result.max = total.max;
        result.mean = total.sum / double(total.count);
    }
    return true;
}

}  // namespace

GridStatistics grid_statistics(const GridBase& grid)
{
    GridStatistics result;
    result.label = grid.getName();
    result.value_type = grid.valueType();
    result.grid_class = GridBase::gridClassToString(grid.getGridClass());
    result.active_voxels = grid.baseTree().activeVoxelCount();
    result.active_tiles = grid.baseTree().activeTileCount();
    result.memory_bytes = grid.memUsage();
    result.voxel_size = grid.transform().voxelSize();
    if (openvdb::CoordBBox box; grid.baseTree().evalActiveVoxelBoundingBox(box))
        for (size_t axis = 0; axis < 3; ++axis) {
            result.box_min[axis] = box.min()[axis];
            result.box_max[axis] = box.max()[axis];
        }
    measure<FloatGrid>(grid, result) || measure<Vec3SGrid>(grid, result) || measure<openvdb::DoubleGrid>(grid, result);
    return result;
}

std::vector<GridStatistics> file_statistics(const GridFile& file)
{
    std::vector<GridStatistics> all;
    const auto labels = grid_labels(file);
    for (const auto& grid : file.grids) {
        if (!grid) continue;
        all.push_back(grid_statistics(*grid));
        all.back().label = labels[all.size() - 1];
    }
    return all;
}

}  // namespace vdbcloud
