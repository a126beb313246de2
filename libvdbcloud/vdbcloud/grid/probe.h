#pragma once
// The value of a grid at a point of the world.
#include "vdbcloud/core/fwd.h"

#include <vector>

namespace vdbcloud {

struct ProbedValue {
    std::vector<double> components;  ///< one number, or three of a vector
    bool inside = false;             ///< true if at least one voxel of the interpolation is active
};

/// The value at a point [world], trilinear between the voxel centres. Inactive voxels count with their value, as in
/// every later stage. Components of a staggered grid are interpolated between the faces at which they stand. Throws
/// InputError for a grid that holds neither numbers of floating point nor vectors of them.
ProbedValue value_at(const GridBase& grid, const Vec3d& world);

}  // namespace vdbcloud
