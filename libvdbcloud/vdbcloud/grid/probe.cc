#include "vdbcloud/grid/probe.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <openvdb/tools/Interpolation.h>

namespace vdbcloud {

namespace {

template<typename GridT>
bool any_active_about(const GridT& grid, const Vec3d& index)
{
    const openvdb::Coord low = openvdb::Coord::floor(index);
    for (int k = 0; k < 8; ++k)
        if (grid.tree().isValueOn(low.offsetBy(k & 1, k >> 1 & 1, k >> 2))) return true;
    return false;
}

template<typename GridT>
ProbedValue scalar_at(const GridT& grid, const Vec3d& index)
{
    return {{double(openvdb::tools::BoxSampler::sample(grid.tree(), index))}, any_active_about(grid, index)};
}

template<typename GridT>
ProbedValue vector_at(const GridT& grid, const Vec3d& index)
{
    const bool staggered = grid.getGridClass() == openvdb::GRID_STAGGERED;
    const auto v = staggered ? openvdb::tools::StaggeredBoxSampler::sample(grid.tree(), index)
                             : openvdb::tools::BoxSampler::sample(grid.tree(), index);
    return {{double(v[0]), double(v[1]), double(v[2])}, any_active_about(grid, index)};
}

}  // namespace

ProbedValue value_at(const GridBase& grid, const Vec3d& world)
{
    const Vec3d index = grid.transform().worldToIndex(world);
    if (grid.isType<FloatGrid>()) return scalar_at(static_cast<const FloatGrid&>(grid), index);
    if (grid.isType<openvdb::DoubleGrid>()) return scalar_at(static_cast<const openvdb::DoubleGrid&>(grid), index);
    if (grid.isType<Vec3SGrid>()) return vector_at(static_cast<const Vec3SGrid&>(grid), index);
    if (grid.isType<openvdb::Vec3DGrid>()) return vector_at(static_cast<const openvdb::Vec3DGrid&>(grid), index);
    throw InputError("grid '" + printable(grid.getName()) + "' holds " + grid.valueType() +
                     ": expected float, double, vec3s or vec3d");
}

}  // namespace vdbcloud
