#pragma once
// Optical depth of ray segments through a sparse grid, exactly for its trilinear interpolant.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/voxels/brick_map.h"

namespace vdbcloud {

/// The density along a ray, integrated:
///
///     depth(t0, t1) = \int_{t0}^{t1} rho(o + t w) dt        tau = sigma_t_per_density * depth
///
/// rho is the trilinear interpolant between voxel centres [density], t a distance [world unit]. Along a ray inside
/// one cell rho is a cubic in t and its integral is taken in closed form, so the only error is rounding (1e-12).
/// There is no step size and no upper limit. The cost is proportional to the number of nonempty cells on the ray, where
/// a brick of one value counts once.
///
/// Threads: no state; may be called from any number of threads.
/// Source: Kajiya & Von Herzen 1984, section 3.1: the exponent of the brightness integral.
double density_depth(const BrickMap& density, const WorldRay& ray, double t0, double t1);

/// Density depth from x to a light [density x world unit], by density_depth(); 0 if the light is at x. x: world space.
double depth_to_light(const BrickMap& density, const LightModel& light, const Vec3d& x);

}  // namespace vdbcloud
