#pragma once
// The trilinear fringe of a grid: one more layer of active voxels, for interpolation of a medium's fields at its edge.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/voxels/period.h"

namespace vdbcloud {

/// A copy of `grid` (name, transform, background) with a fringe: the inactive voxels among the 26 neighbours of active
/// voxels become active. A fringe voxel has the mean of its active neighbours, summed in double, so a constant field
/// stays exactly constant. Trilinear samples in the outermost cells then do not fall towards the background. Active
/// tiles become voxels.
///
/// Along the axes of a period neighbours are those of the repeated field, and the fringe is its next voxels.
Vec3SGridPtr with_fringe(const Vec3SGrid& grid, const Period& = {});
FloatGridPtr with_fringe(const FloatGrid& grid, const Period& = {});

/// The active voxels of with_fringe() alone: values mean nothing.
FloatGridPtr voxels_with_fringe(const FloatGrid& grid, const Period& = {});

}  // namespace vdbcloud
