#pragma once
// The voxels on which an equation is solved, numbered as slots, and the conversion between trees and flat arrays.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/voxels/blocks.h"
#include "vdbcloud/voxels/period.h"

#include <string>

namespace vdbcloud {

struct VoxelIndexOptions {
    std::array<bool, 3> periodic{false, false, false};  ///< axes [index space] on which the domain repeats
    /// Blocks [voxel coordinates of the tree over 8] that are there without active voxels, too; not where the domain
    /// repeats.
    std::vector<Vec3i> besides{};
};

/// Throws InputError naming the grid where VoxelIndex cannot stand for it. Causes: the transform is not affine, the
/// axes are not at right angles, a periodic extent is not a multiple of 8, or the grid has more than 2^31 voxels. Plans
/// call it, so that a plan is refused where the run would be.
void check_voxels(const FloatGrid&, const VoxelIndexOptions& = {});

/// The active voxels of a density grid whose value is above 0 (tiles voxelised), as Blocks in a fixed order. Also the
/// geometry of one voxel: a box with edges along axis(0..2).
///
/// Every array over the voxels is flat, one value per slot (blocks.h), so loops do not access OpenVDB.
/// A periodic axis repeats by the rule of period_of(). The length of the period must be a multiple of 8.
class VoxelIndex {
public:
    /// Throws as check_voxels().
    explicit VoxelIndex(const FloatGrid&, const VoxelIndexOptions& = {});

    const Blocks& blocks() const { return blocks_; }
    /// Lengths of a voxel's edges [world unit], and their unit directions in world space.
    const Vec3d& spacing() const { return spacing_; }
    const Vec3d& axis(int a) const { return axis_[a]; }
    /// Voxel coordinates of the tree = coordinates of the blocks + origin.
    const Vec3i& origin() const { return origin_; }
    /// One period of the domain, in voxel coordinates of the tree.
    const Period& period() const { return period_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// World position of a point in voxel coordinates of the blocks (voxel centres are at integers).
    Vec3d world(const Vec3d& voxel) const;

    /// Values of another grid of the same transform at the active slots, 0 elsewhere.
    std::vector<float> gather(const FloatGrid&) const;
    /// One component (0, 1, 2) of a vector grid of any affine transform at the active slots (voxel_mean.h).
    std::vector<float> gather(const Vec3SGrid&, int component) const;

    /// A vector grid of three fields over the voxels, each times its scale. The three pointers may be equal. The grid
    /// has the transform of the indexed grid. Active are the voxels and their fringe (with_fringe() in
    /// voxels/extend.h), which repeats where the domain does, and keeps trilinear samples of a constant field constant
    /// up to the medium's edge.
    Vec3SGridPtr to_grid(const std::array<const float*, 3>& field, const std::string& name,
                         const Vec3d& scale = Vec3d(1, 1, 1)) const;
    /// As above, a float grid of one field.
    FloatGridPtr to_grid(const float* field, const std::string& name) const;

private:
    Blocks blocks_;
    Vec3d spacing_{1, 1, 1};
    std::array<Vec3d, 3> axis_{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
    Vec3i origin_{0, 0, 0};
    Period period_;
    Affine world_from_index_;
    std::shared_ptr<const Transform> transform_;
};

}  // namespace vdbcloud
