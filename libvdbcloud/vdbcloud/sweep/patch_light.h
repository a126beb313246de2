#pragma once
// The light of a patch of ground while a sweep gathers it and sends it up. Private to sweep/.
#include "vdbcloud/sweep/aprons.h"
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

/// Sums of SweepGround over its patch. All values are changes against the endless ground that SweepSet::inflow holds.
///
/// Threads: add() to different blocks; add_voids() after the last block of a batch; change() after reflect().
class PatchLight {
public:
    /// Keeps references. Requires SweepGround::patch.
    PatchLight(const Blocks&, const SweepSet&, SweepGround&);

    bool black() const { return to_.albedo == 0; }
    /// Whether light along this direction, or with these signs of its components, ends on the ground; other light
    /// begins there.
    template<typename Direction>
    bool leaves(const Direction& s) const
    {
        return s[size_t(axis_)] * down_ > 0;
    }

    /// Light of direction d of a batch on the cells whose middles lie in a block.
    void add(const SweepPath&, int d, size_t block, const block_sweep::Scratch&);
    /// Light of a batch and a channel on all other cells.
    void add_voids(const std::vector<SweepPath>& batch, const Aprons&, int channel);
    /// The light on cell `cell` of one direction of the set, if it comes from the medium.
    void gather(size_t cell, size_t number, double radiance);
    /// Sets irradiance and radiance from what has been gathered.
    void reflect();

    /// Change of the radiance that a ray through `point` (voxel coordinates) along `step` left the ground with.
    double change(const Vec3d& point, const Vec3d& step) const;
    /// The sum of change() over the middles of the cells of a plane of the ActiveBox. Planes are sampled as finely as
    /// the patch is: one value stands for `edge` cells along an edge, and for more where a plane has more than 2048
    /// samples along an edge.
    double sum_on_plane(int face, const Vec3d& step) const;
    /// Takes the ground's light out of PlaneLight::sky_in, and fills ground_in.
    void write(const Vec3d& spacing, PlaneLight& to) const;

private:
    struct InBlock {
        uint32_t cell;
        uint16_t slot;  // in the block
    };
    struct Tile {
        int row, column;  // of its first cell; may be outside the patch, as may others
    };
    double inflow(size_t number) const { return set_.inflow.empty() ? 0.0 : double(set_.inflow[number]); }
    double outward(size_t number) const { return set_.direction[number][axis_] * down_ * set_.weight[number]; }

    const SweepSet& set_;
    SweepGround& to_;
    const GroundPatch& patch_;
    ActiveBox box_;
    int axis_, down_;
    double unit_ = 0;  // the sum of a radiance of 1
    std::vector<double> sum_;
    std::vector<float> radiance_;
    std::vector<char> in_void_;    // by cell
    std::vector<uint32_t> begin_;  // of each block in in_block_, and the end
    std::vector<InBlock> in_block_;
    std::vector<Tile> tiles_;
};

}  // namespace vdbcloud
