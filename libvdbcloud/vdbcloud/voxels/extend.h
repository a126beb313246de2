#pragma once
// The fringe of a grid: one more layer of voxels, for fields that are known only inside a medium and are interpolated
// at its edge.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// A copy of `grid` (name, transform, background) in which every inactive voxel among the 26 neighbours of an active
/// voxel is active as well. Its value is the mean of its active neighbours, summed in double: a constant field keeps
/// its constant exactly, so trilinear samples in the medium's outermost cells do not fall towards the background.
/// Active tiles become voxels.
Vec3SGridPtr with_fringe(const Vec3SGrid& grid);
FloatGridPtr with_fringe(const FloatGrid& grid);

}  // namespace vdbcloud
