#pragma once
// Emitting voxels in a tree of boxes, each of which can stand for its voxels from afar. Private to scatter/.
#include "vdbcloud/voxels/voxel_index.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// A box of emitting voxels. Lengths and positions are along the index axes from voxel 0 [world unit].
struct EmissionNode {
    Vec3i low, high;  ///< voxels, inclusive
    Vec3d centre;     ///< mean position, by power; double, as voxels may lie 2^30 edges from voxel 0
    /// Covariance of the position, by power, each voxel a box: xx, yy, zz, xy, xz, yz [world unit^2].
    std::array<float, 6> spread{};
    std::array<float, 3> power{};  ///< by channel: sum of emission times volume [radiance x world unit^2]
    std::array<Vec3f, 3> offset{Vec3f(0.0f), Vec3f(0.0f),
                                Vec3f(0.0f)};  ///< mean position of a channel's power, less `centre`
    float sigma = 0;                           ///< mean sigma_t' of the voxels, by power [1/world unit]
    float size = 0;                            ///< longest edge [world unit]
    int32_t first = -1;                        ///< number of the first child; the others follow
    int32_t count = 0;                         ///< of children, 2 to 8; 0: a single voxel
    bool single() const { return count == 0; }
    int edge() const  ///< longest edge [voxels]
    {
        return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}) + 1;
    }
};

/// Boxes are halved across each edge that is longer than half of their longest edge, down to single voxels. Every box
/// fits its voxels. The root is node 0.
class EmissionTree {
public:
    /// `emission`: one to three channels, a value for each slot [radiance / world unit], above 0 where the voxel emits.
    /// `sigma`: sigma_t' of each slot. Empty if nothing emits.
    EmissionTree(const VoxelIndex&, const std::vector<const std::vector<float>*>& emission,
                 const std::vector<float>& sigma);

    const std::vector<EmissionNode>& nodes() const { return nodes_; }
    int channels() const { return channels_; }
    size_t bytes() const { return nodes_.size() * sizeof(EmissionNode); }

private:
    void merge(EmissionNode& node) const;

    int channels_;
    std::vector<EmissionNode> nodes_;
};

}  // namespace vdbcloud
