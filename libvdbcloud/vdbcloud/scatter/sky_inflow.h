#pragma once
// Radiance that enters a medium from a sky: on faces for P1, along directions for sweeps.
#include "vdbcloud/scene/sky.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// J / pi of one channel on faces of each orientation (Blocks::Face): Sky::mean_inflow along the outward normal.
std::array<double, 6> sky_on_faces(const VoxelIndex&, const Sky&, int channel);

/// Radiance of one channel that arrives along each direction of travel (unit vectors, components along
/// index.axis(0..2)).
std::vector<float> sky_along(const VoxelIndex&, const Sky&, int channel, const std::vector<Vec3d>& travel);

}  // namespace vdbcloud
