#pragma once
// Small density grids for tests that do not include OpenVDB's headers.
#include "vdbcloud/core/fwd.h"

#include <functional>
#include <utility>
#include <vector>

namespace vdbcloud::test {

/// Voxels 0 .. n - 1 with edges h [world unit], active where f > 0.
FloatGridPtr voxel_field(const Vec3i& n, const Vec3d& h, const std::function<double(const Vec3i&)>& f);

/// As above, with a given transform: x, y, z are the world vectors of one voxel step along each index axis. Voxel 0's
/// centre is the world's origin.
FloatGridPtr voxel_field(const Vec3i& n, const Vec3d& x, const Vec3d& y, const Vec3d& z,
                         const std::function<double(const Vec3i&)>& f);

/// Boxes of voxels (first, last) of one value.
FloatGridPtr voxel_clouds(const std::vector<std::pair<Vec3i, Vec3i>>& boxes, const Vec3d& h, double value);

}  // namespace vdbcloud::test
