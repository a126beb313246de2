#pragma once
// A medium on voxels of twice the edge.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// A density with its albedo's tint and its emission, all on the voxels of `density`.
struct CoarserMedium {
    FloatGridPtr density;
    Vec3SGridPtr tint, emission;  ///< null where there is none
};

/// Each voxel holds the means of 2 x 2 x 2 voxels: of density; of tint, weighted by density; of emission within the
/// density. Mass is kept. Voxels begin at the first active voxel along each axis, so that a period of an even number of
/// voxels has half of it. `tint` and `emission` may be null. Voxels are active where their density is above 0. Time and
/// memory are those of the active voxels.
CoarserMedium coarser(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission);

}  // namespace vdbcloud
