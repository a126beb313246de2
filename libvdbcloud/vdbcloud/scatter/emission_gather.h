#pragma once
// Sums light from a tree of emitting voxels at voxels and on the planes of the box about them. Private to scatter/.
#include "vdbcloud/scatter/emission_parts.h"
#include "vdbcloud/scatter/emission_tree.h"
#include "vdbcloud/scatter/near_emission.h"
#include "vdbcloud/scatter/planes.h"
#include "vdbcloud/scatter/segment_depth.h"
#include "vdbcloud/voxels/active_box.h"

namespace vdbcloud {

/// Radiance of emission that has not collided, by rays with exact optical depth between nodes of the tree and groups of
/// receivers. Seen from a receiver at the distance r along s, a node of power P = sum j V, mean position c, variance
/// v = s.C.s and transverse variance w gives, with u^2 = 3 v sigma^2 and r' the distance less the shift of the mean
/// position by the node's own extinction,
///
///     phi = P e^-tau(c) sinh(u) / u  (1 + (3 v - w) / r'^2) / r'^2
///
/// exact to second order in size / distance and sigma size. Of a node that is optically thick and gives a twentieth of
/// the light or more, e^-tau sinh(u) / u is taken by parts (emission_parts.h). A node stands for its voxels where
///
///     size / distance <= opening   or   share (size / distance)^2 <= 0.1,
///
/// share its part of the receivers' light, with 0.03 for nodes taken by parts, and where the depths from its children
/// change that light by less than a tenth. Against sums over points the error is 1 to 2 % in voxels of 1/4 mean free
/// path (tests/scatter/emitted_light_test.cc).
///
/// The depth is traced for each receiver where extinction jumps among them, else for every second, fourth or eighth and
/// interpolated, by the node's size and share. Emission within one voxel of the receiver is integrated along rays
/// (near_emission.h).
///
/// Cost: time in proportion to receivers x log(emitting voxels); rays end at a depth of 30.
class EmissionGather {
public:
    /// Keeps references to all arguments. `sigma`: sigma_t' of each slot. `depth`: of the same medium. `emission`: what
    /// the tree was made of.
    EmissionGather(const VoxelIndex&, const EmissionTree&, const std::vector<const std::vector<float>*>& emission,
                   const SegmentDepth& depth, const std::vector<float>& sigma, int degree, double opening = 0.5);

    /// Values of one voxel and channel: moments about the index axes by harmonic, then the voxel's mean fluence.
    size_t values() const { return size_t(terms_) + 1; }
    /// Fills `out` with values() of each channel of each voxel of a block, channel by channel, voxel after voxel.
    /// Voxels that are not in `wanted` get 0.
    ///
    /// Moments are as sweeps take them, linear from centre to centre (beam_fluence() in beam.h): the light at the
    /// centre divided by 1 + x^2 / 12 in thin voxels, x their optical thickness along the light, the mean over the
    /// voxel in thick ones. The mean fluence is for the balance.
    void block(size_t block, const BlockMask& wanted, std::vector<double>& out) const;
    /// Power per area out through each cell of a plane, channel by channel, cell after cell. The depth is taken half a
    /// voxel further out, as that of exposed faces is (beam.h). Sets `ahead` to the sum over the cells of what of this
    /// goes into the hemisphere, channel by channel.
    std::vector<double> plane(int face, const Hemisphere&, std::vector<double>& ahead) const;

private:
    struct Tile;
    struct Look;
    class TileDepths;
    struct Voxels;
    struct Plane;
    template<typename Sink>
    void descend(const Tile&, const std::vector<int32_t>& nodes, Sink&) const;
    bool apart(const EmissionNode&, const Vec3d& low, const Vec3d& high) const;
    double distance(const EmissionNode&, const Vec3d& low, const Vec3d& high) const;
    Vec3d metric(const Vec3d& voxel) const;  ///< [world unit], along the index axes
    Vec3d voxels(const Vec3d& metric) const;
    /// Fluence of a node at a receiver, roughly: as of a point, and not above that of a node half its size away.
    /// Sets `tau` to the depth between them.
    double fluence(const EmissionNode&, const Vec3d& receiver, double& tau) const;
    /// Fluence of all nodes at the darkest of five points of a tile, roughly.
    double least_fluence(const Tile&) const;
    /// `scale`: least_fluence() of the tile or a tile about it.
    Look look(const EmissionNode&, const Tile&, double scale) const;
    /// Whether the node's children must stand for it: it is optically thick, or the depths from its children differ.
    bool coarse(const EmissionNode&, const Tile&, const Look&) const;
    /// Where the way from a receiver [voxels] to the node ends [world]: at the reach of a node that is taken by parts,
    /// else at its mean position.
    Vec3d way_out(const EmissionNode&, const Vec3d& receiver, bool by_parts) const;

    const VoxelIndex& index_;
    const EmissionTree& tree_;
    const std::vector<const std::vector<float>*>& emission_;
    const SegmentDepth& depth_;
    const std::vector<float>& sigma_;
    int degree_, terms_, channels_;
    double opening_;
    NearEmission near_;
    EmissionParts parts_;
    ActiveBox box_;
};

}  // namespace vdbcloud
