#pragma once
// A shaped cloud as an OpenVDB grid.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/fractal/cloud_shape.h"

namespace vdbcloud {

/// The density grid of `blocks`: fog volume, named by the schema, background 0, voxels above 0 active, and
/// blocks of 1 as active tiles. Index (0, 0, 0) is the centre of the first voxel of the domain, half a voxel
/// inside its low corner. Threads: all of TBB's; the grid does not depend on them.
FloatGridPtr cloud_grid(const CloudBlocks& blocks);

/// The transform of a domain cut into size voxels: index to world, voxel centres at integers.
std::shared_ptr<Transform> voxel_centre_transform(const Box& domain, const Vec3i& size);

}  // namespace vdbcloud
