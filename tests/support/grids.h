#pragma once
// Small grids that tests write and read.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace vdbcloud::test {

/// A fog ball around `centre`: density 1 at the centre, falling linearly to 0 at a distance of `radius` voxels.
inline FloatGridPtr ball(const std::string& name, int radius = 9, openvdb::Coord centre = openvdb::Coord(0))
{
    auto grid = FloatGrid::create(0.0f);
    grid->setName(name);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto accessor = grid->getAccessor();
    for (int i = -radius; i <= radius; ++i)
        for (int j = -radius; j <= radius; ++j)
            for (int k = -radius; k <= radius; ++k)
                if (const double r = std::sqrt(double(i * i + j * j + k * k)); r < radius)
                    accessor.setValue(centre + openvdb::Coord(i, j, k), float(1 - r / radius));
    return grid;
}

/// An empty grid of a type that OpenVDB registers, with background 0. OpenVDB's own library constructs the grid, so the
/// test source compiles the members that it calls, not all virtual ones: seconds instead of tens of seconds.
template<typename GridT>
typename GridT::Ptr registered()
{
    openvdb::initialize();
    return openvdb::gridPtrCast<GridT>(openvdb::GridBase::createGrid(GridT::gridType()));
}

inline GridFile file_of(std::vector<GridBasePtr> grids)
{
    openvdb::initialize();
    return {"memory", std::move(grids), std::make_shared<MetaMap>()};
}

/// The message of the exception of type E that `work` throws; empty if `work` throws nothing.
template<typename E, typename Work>
std::string sentence(const Work& work)
{
    try {
        work();
    } catch (const E& e) {
        return e.what();
    }
    return {};
}

}  // namespace vdbcloud::test
