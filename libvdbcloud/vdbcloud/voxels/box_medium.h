#pragma once
// Media made of boxes of constant extinction and emission, as benchmarks of transport describe them.
#include "vdbcloud/core/fwd.h"

#include <vector>

namespace vdbcloud {

struct MediumBox {
    Vec3d low, high;        ///< corners [world]
    double extinction = 0;  ///< [1/world unit]
    double emission = 0;    ///< isotropic emission [radiance/world unit]
};

struct BoxMedium {
    FloatGridPtr extinction;
    Vec3SGridPtr emission;  ///< three equal channels; null if no box emits
};

/// Throws InputError for what box_medium() refuses.
void check(const std::vector<MediumBox>& boxes, const Vec3d& cell);

/// Voxels of `cell` [world unit] whose corners are multiples of `cell`. A voxel has the values of the last box that
/// holds its centre; a later box of extinction 0 is a hole. Active are the voxels above 0. Throws InputError for a box
/// without volume, a value below 0 or not finite, and boxes of more than 2^28 voxels together.
BoxMedium box_medium(const std::vector<MediumBox>& boxes, const Vec3d& cell);

}  // namespace vdbcloud
