#pragma once
// A grid carried on by one voxel, for fields that are known only inside a medium and are sampled at its edge.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// A copy of `grid` with every inactive voxel among the 26 neighbours of an active one made active, its value the mean
/// of its active neighbours'. A constant field stays that constant, so trilinear samples inside the medium's outermost
/// cells do not fall towards the background. Active tiles are voxelised.
Vec3SGridPtr extended(const Vec3SGrid& grid);
FloatGridPtr extended(const FloatGrid& grid);

}  // namespace vdbcloud
