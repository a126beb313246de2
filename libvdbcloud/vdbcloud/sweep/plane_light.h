#pragma once
// Light that leaves a medium through the planes of the box about its voxels.
#include "vdbcloud/voxels/active_box.h"

#include <cstdint>

namespace vdbcloud {

struct SweepSet;

/// Results of a sweep on the planes of the ActiveBox. L is the radiance at the middle of a cell of a plane, n the
/// plane's outward normal, and "power" is weight x s.n x L of a direction with s.n > 0. [radiance]
///
/// Light comes from a block of voxels (from_medium, medium_along), or straight from the sky or a patch of ground.
struct PlaneLight {
    /// Request: fill from_medium and from_sky. Their time and memory are in proportion to the area of the box, those of
    /// all else to the blocks, however far apart they lie.
    bool by_cell = true;
    /// The sum of power over the directions, one value for each cell of a plane. Empty unless by_cell.
    std::array<std::vector<float>, 6> from_medium, from_sky;
    /// The sum of power over the cells of a plane, one value for each direction of the set.
    std::array<std::vector<double>, 6> medium_along, sky_along;
    /// The directions of the set.
    std::vector<Vec3d> direction;
    /// The sky's power into the box per area: the sum over the directions with s.n < 0 of weight x |s.n| x inflow.
    std::array<double, 6> sky_in{};
    /// With a patch of ground (SweepGround): the same of the ground's light, summed over the cells; sky_in is without.
    std::array<double, 6> ground_in{};
    /// The sum over the directions with s.n > 0 of weight x s.n: pi, but for the error of the quadrature, which is 4 %
    /// across the azimuths of 32 directions. Whoever wants power divides by this and multiplies by pi.
    std::array<double, 6> of_unit_radiance{};
    /// Tiles of 8 x 8 rays that were traced from planes, each for one direction.
    uint64_t traced = 0;
    /// Pairs of such a ray and a block that may stop it, where few blocks may. Other rays walk from block to block.
    uint64_t tests = 0;

    /// Adds light of the same medium and the same directions.
    void add(const PlaneLight&);
};

/// Fills sky_in and of_unit_radiance, and sets the sums to 0.
void set_half_ranges(const SweepSet&, PlaneLight&);

/// A ray to a plane starts this far from the centre of the voxel behind the cell [voxels]: just inside the plane, so
/// that it starts in that voxel's block.
inline constexpr double inside_plane = 0.5 - 1e-6;

}  // namespace vdbcloud
