#pragma once
// Where in the world the substance of a grid is, as points to frame a picture by.
#include "vdbcloud/core/fwd.h"

#include <vector>

namespace vdbcloud {

/// Corners [world] of boxes around all voxels whose value is above `fraction` of the greatest: one box a leaf
/// or tile, tight around its voxels (a voxel reaching half its edge about its centre). Empty where no value
/// is above 0. Any transform. Fog too thin to be seen is left out, so that a wide veil does not make the
/// cloud small.
std::vector<Vec3d> occupied_corners(const FloatGrid&, double fraction = 0.004);

}  // namespace vdbcloud
