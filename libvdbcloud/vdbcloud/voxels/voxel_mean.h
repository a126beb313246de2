#pragma once
// Values of a vector grid at the voxels of another grid.
#include "vdbcloud/core/fwd.h"

#include <memory>

namespace vdbcloud {

/// Reads Cd or emission, which may have a transform of its own, at the voxels of a density.
///
/// Equal transforms: the voxel's own value, bit for bit. Else the trilinear interpolant in world space, at the voxel's
/// centre; where the grid is finer than the voxel, the mean over n points along each edge, n the number of its voxels
/// that the edge spans (at most 8), so that small sources are not missed.
///
/// Holds a cache: use one object per thread, not longer than the grid.
class VoxelMean {
public:
    VoxelMean(const Vec3SGrid& of, const Transform& voxels);
    ~VoxelMean();
    Vec3f operator()(const Vec3i& voxel) const;

private:
    struct Reader;
    std::unique_ptr<const Reader> reader_;
};

}  // namespace vdbcloud
