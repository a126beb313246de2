#pragma once
// Light that leaves a medium through the planes of the box about its voxels.
#include "vdbcloud/voxels/active_box.h"

namespace vdbcloud {

struct SweepSet;

/// Results of a sweep on the planes of the ActiveBox, one value for each cell of a plane: the sum over the directions
/// with s.n > 0, n the plane's outward normal, of weight x s.n x L at the middle of the cell. [radiance]
struct PlaneLight {
    /// L of rays that come from a block of voxels; and of rays that come straight from the sky or a patch of ground.
    std::array<std::vector<float>, 6> from_medium, from_sky;
    /// The sky's power into the box per area: the sum over the directions with s.n < 0 of weight x |s.n| x inflow.
    std::array<double, 6> sky_in{};
    /// With a patch of ground (SweepGround): the same of the ground's light, summed over the cells; sky_in is without.
    std::array<double, 6> ground_in{};
    /// The sum over the directions with s.n > 0 of weight x s.n: pi, but for the error of the quadrature, which is 4 %
    /// across the azimuths of 32 directions. Whoever wants power divides by this and multiplies by pi.
    std::array<double, 6> of_unit_radiance{};
};

/// Fills sky_in and of_unit_radiance.
void set_half_ranges(const SweepSet&, PlaneLight&);

/// A ray to a plane starts this far from the centre of the voxel behind the cell [voxels]: just inside the plane, so
/// that it starts in that voxel's block.
inline constexpr double inside_plane = 0.5 - 1e-6;

}  // namespace vdbcloud
