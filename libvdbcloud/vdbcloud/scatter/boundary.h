#pragma once
// The edge of a cloud on voxels: which faces are exposed, and how much true surface each stands for.
#include "vdbcloud/voxels/voxel_index.h"

namespace vdbcloud {

/// An active voxel with at least one face to a voxel that is not active.
struct ExposedVoxel {
    uint32_t slot;
    uint8_t faces;    ///< bit f: face f (Blocks::Face) is exposed
    float weight[3];  ///< |n . e_axis| of its faces along each axis, n the direction of the density's gradient
};

/// All exposed voxels, by rising slot.
///
/// The faces of a voxelised body have up to 1.73 times its surface however fine the voxels (a sphere: 6 pi R^2 for
/// 4 pi R^2). A face weighted by |n.e| stands for its true share: over the faces that a flat piece of surface exposes,
/// the sum of |n_e| (faces per area) times |n_e| (weight) is n.n = 1. The gradient is taken from first moments under a
/// smooth window of 5^3 voxels, void counting as 0; where it vanishes (a single voxel, a thin sheet) the weight is 1.
/// Where density falls smoothly to 0 the direction converges; the edge of a body of constant density keeps a bias
/// that comes with any fixed window (3^3: area +2.5 %).
/// Source: none; measured against the closed form of a sphere in tests/scatter.
std::vector<ExposedVoxel> exposed_voxels(const VoxelIndex& index, const std::vector<float>& density);

}  // namespace vdbcloud
