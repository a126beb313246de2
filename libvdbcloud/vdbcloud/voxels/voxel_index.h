#pragma once
// The voxels of a grid that an equation is solved on, numbered flat, and the way from trees to arrays and back.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/voxels/blocks.h"

#include <string>

namespace vdbcloud {

struct VoxelIndexOptions {
    std::array<bool, 3> periodic{false, false, false};  ///< axes [index space] on which the domain repeats
};

/// The active voxels of a density grid whose value is above 0 (tiles voxelised), as Blocks: block by block, a leaf of
/// the tree being a block, in a fixed order. With it go the geometry of one voxel, a box with edges along axis[0..2].
///
/// Every array over the voxels is flat, one value a slot (blocks.h), so nothing that loops touches OpenVDB.
/// A periodic axis repeats after the extent of the voxels along it, which must be a multiple of 8.
class VoxelIndex {
public:
    /// Throws InputError naming the grid if its transform is not affine or its axes are not at right angles, if a
    /// periodic extent does not fit, or if there are more than 2^31 voxels.
    explicit VoxelIndex(const FloatGrid&, const VoxelIndexOptions& = {});

    const Blocks& blocks() const { return blocks_; }
    /// World lengths of a voxel's edges, and their unit directions.
    const Vec3d& spacing() const { return spacing_; }
    const Vec3d& axis(int a) const { return axis_[a]; }
    /// Voxel coordinates of the tree = coordinates of the blocks + origin.
    const Vec3i& origin() const { return origin_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// World position of a point given by block coordinates (voxel centres are at integers).
    Vec3d world(const Vec3d& voxel) const;

    /// Values of another grid of the same transform at the active slots, 0 elsewhere.
    std::vector<float> gather(const FloatGrid&) const;
    /// One component of a vector grid.
    std::vector<float> gather(const Vec3SGrid&, int component) const;

    /// A vector grid of three fields over the voxels, each times its scale (any may be the same array), with the
    /// transform of the grid that was indexed, active at the voxels and at the one-voxel fringe about them that
    /// trilinear samples reach, where each value is the mean of the voxels beside it: a constant field stays constant
    /// up to its edge.
    Vec3SGridPtr to_grid(const std::array<const float*, 3>& field, const std::string& name,
                         const Vec3d& scale = Vec3d(1, 1, 1)) const;
    /// The same of one field.
    FloatGridPtr to_grid(const float* field, const std::string& name) const;

private:
    Blocks blocks_;
    Vec3d spacing_{1, 1, 1};
    std::array<Vec3d, 3> axis_{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
    Vec3i origin_{0, 0, 0};
    Affine world_from_index_;
    std::shared_ptr<const Transform> transform_;
};

}  // namespace vdbcloud
