#pragma once
// The boundary of a voxelised cloud: its exposed faces, and the share of true surface area of each face.
#include "vdbcloud/voxels/voxel_index.h"

namespace vdbcloud {

/// An active voxel with at least one face to an inactive voxel.
struct ExposedVoxel {
    uint32_t slot;
    uint8_t faces;         ///< bit f: face f (Blocks::Face) is exposed
    float weight[3];       ///< |n . e_axis| of the faces across each axis, n the direction of the density gradient
    uint8_t grounded = 0;  ///< bit f: face f lies on a ground (ground.h)
    /// Bit a: the density falls along +a. Bit 3: n is known, so that these signs and the weights are the surface's
    /// outward normal.
    uint8_t falling = 0;
};

/// All exposed voxels, in the order of their slots.
///
/// At any resolution the faces of a voxelised body have up to 1.73 times its true area (sphere: 6 pi R^2 for 4 pi R^2).
/// The weight |n.e| restores the true area: over the faces that a flat piece of surface exposes, the sum of |n_e|
/// (faces per area) times |n_e| (weight) is n.n = 1.
///
/// The gradient is estimated from first moments under a smooth window of 5^3 voxels, in which void counts as 0. Where
/// the gradient vanishes (a single voxel, a thin sheet) the weight is 1. Where a body is thinner than the longest edge
/// of a voxel, the window sees both sides at once and their gradients cancel. Where less than half of the gradient of a
/// half-space is left, n follows the area of the exposed faces in a window of 5^3 voxels: a plate leaks through its
/// plane. The direction n converges where density falls smoothly to 0. The edge of a body of constant density keeps the
/// bias of the fixed window (3^3: area +2.5 %). Source: none; measured against the closed form of a sphere in
/// tests/scatter.
std::vector<ExposedVoxel> exposed_voxels(const VoxelIndex& index, const std::vector<float>& density);

}  // namespace vdbcloud
