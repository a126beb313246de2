#pragma once
// Extent of a grid in world space: of its visible part, for framing a picture, and of all that rays see.
#include "vdbcloud/core/fwd.h"

#include <vector>

namespace vdbcloud {

/// Corners [world] of boxes around all active voxels whose value is above `fraction` times the greatest value.
///
/// Their convex hull is that of all such voxels, wherever leaf blocks cut the body; a voxel extends half its edge to
/// each side of its centre. Each voxel that is a corner of the hull of its plane x = const gives 8 corners, and so does
/// each tile. Empty if no value is above 0. Any transform. Time: leaves and tiles; memory: the planes and their hulls.
/// The threshold excludes fog too thin to see: a wide, thin veil would make the cloud small in the picture.
std::vector<Vec3d> occupied_corners(const FloatGrid&, double fraction = 0.004);
/// As above; the value of a vector is its greatest component.
std::vector<Vec3d> occupied_corners(const Vec3SGrid&, double fraction = 0.004);

/// Corners [world] of boxes outside which the trilinear interpolant is 0. The boxes reach one voxel beyond the centres
/// of all active voxels whose value is above 0.
std::vector<Vec3d> interpolant_corners(const FloatGrid&);
std::vector<Vec3d> interpolant_corners(const Vec3SGrid&);

}  // namespace vdbcloud
