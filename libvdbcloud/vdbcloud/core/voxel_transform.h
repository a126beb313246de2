#pragma once
// Transforms of voxels whose edges lie along the axes of the world.
#include "vdbcloud/core/fwd.h"

#include <memory>

namespace vdbcloud {

/// Index (0, 0, 0) is at the origin, and a voxel has these edges [world unit]. Edges that differ by rounding alone make
/// cubes: some tools accept nothing else. Throws InputError for voxels of less than 3.1e-15 (world unit)^3, which
/// OpenVDB takes for singular.
std::shared_ptr<Transform> voxel_transform(const Vec3d& edge);

}  // namespace vdbcloud
