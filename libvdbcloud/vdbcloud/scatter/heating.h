#pragma once
// Power that a medium absorbs, voxel by voxel. Private to scatter/.
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud {

/// Absorbed power per volume at each slot, sigma_a (phi + uncollided fluence) [radiance x sr / world unit]. The sum
/// times the volume of a voxel is P1Budget::absorbed, but for the rounding to float. Requires P1Source::beam_absorbed
/// where the source has beams.
std::vector<float> heating_rate(const P1Operator&, const P1Source&, const std::vector<double>& phi);

/// A grid `heating` of three channels, `scale` times each field; active at the voxels alone, without a fringe, so that
/// their sum is the absorbed power. Floats where the three fields and scales are equal, else vectors. `density`: its
/// transform.
GridBasePtr heating_grid(const VoxelIndex&, const FloatGrid& density, const std::array<const std::vector<float>*, 3>&,
                         const Vec3d& scale);

}  // namespace vdbcloud
