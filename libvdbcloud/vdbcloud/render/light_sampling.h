#pragma once
// Points on rays in proportion to the inverse square of the distance from a lamp, and directions close to a lamp.
// Private to render/.
#include "vdbcloud/core/affine.h"

namespace vdbcloud {

/// Points on a ray with a density proportional to 1 / r^2, r the distance from a lamp: equal angles as seen from the
/// lamp. Source: Kulla & Fajardo 2012, "Importance Sampling Techniques for Path Tracing in Participating Media".
class EquiangularSampler {
public:
    /// The part t0 <= t <= t1 of the ray, both finite. A ray through the lamp itself counts as passing it at
    /// 1e-9 of its distance from the ray's start.
    EquiangularSampler(const WorldRay&, const Vec3d& lamp, double t0, double t1);

    double sample(double u) const;   ///< t [world unit] for u uniform in [0, 1)
    double density(double t) const;  ///< probability density of sample() [1/world unit]; 0 outside t0..t1

private:
    double t0_, t1_, foot_, distance_, first_angle_, angle_;
};

/// A direction from x, at an angle to the direction towards `lamp` that is uniform in [0, pi]: the density
/// 1 / (2 pi^2 sin angle) per solid angle is that of the radiance which a lamp in a medium sends along rays that pass
/// it. With points of EquiangularSampler on the ray, the density per volume near the lamp is proportional to 1 / r^2.
/// Source: Georgiev et al. 2013, "Joint Importance Sampling of Low-Order Anisotropic Scattering", section 4.
Vec3d direction_near_lamp(const Vec3d& to_lamp, double u, double v);     ///< unit vectors
double density_near_lamp(const Vec3d& to_lamp, const Vec3d& direction);  ///< [1/sr]

}  // namespace vdbcloud
