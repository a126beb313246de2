#pragma once
// The ground beneath a medium: an infinite, opaque plane that scatters light back as Lambert's law says.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/scene/light.h"

#include <vector>

namespace vdbcloud {

/// With E the irradiance of the plane, direct and diffuse, the radiance of the plane is albedo x E / pi in all
/// directions upwards. Its lower side is black.
struct Ground {
    double albedo = 0;     ///< 0 to 1
    Vec3d point{0, 0, 0};  ///< of the plane [world]
    Vec3d up{0, 1, 0};     ///< unit

    /// Distance above the plane [world unit]; below 0 under it.
    double height(const Vec3d& x) const { return (x - point).dot(up); }
    /// Where a ray that goes down meets the plane [world unit], 0 for one that starts on or beneath it; infinity for
    /// other rays.
    double distance(const WorldRay&) const;
};

/// The rule of all programs: the ground lies where the medium ends, one voxel beneath the centres of the lowest voxels
/// above 0 of all densities. The trilinear interpolant falls to 0 there. `up` is unit. Without matter the plane holds
/// the origin. Throws InputError for an albedo outside 0 .. 1.
Ground ground_beneath(const std::vector<const FloatGrid*>&, const Vec3d& up, double albedo);

/// Throws InputError unless the albedo is 0 to 1.
void check_ground_albedo(double albedo);

/// Throws InputError for a light that is not above the ground: light from below does not pass the ground.
void require_light_above(const Light&, const Ground&);

}  // namespace vdbcloud
