#pragma once
// Reference path tracer for a voxel cloud under one sun: slow and unbiased, without the library's transport code.
#include "vdbcloud/voxels/brick_map.h"

#include <cstdint>

namespace vdbcloud::test {

/// A grey medium with Henyey-Greenstein scattering. The density is the trilinear interpolant of the voxels.
struct McMedium {
    const BrickMap* density = nullptr;
    double sigma_t = 1;  ///< sigma_t at density 1 [1/world unit]
    double densest = 1;  ///< upper bound of the density
    double w0 = 1, g = 0;
    Vec3d to_sun{0, 1, 0};  ///< unit vector in world space; the sun's irradiance is 1
};

/// One sample of the collided radiance that arrives at the origin of a ray, which is outside the medium.
///
/// Method: Woodcock tracking, next-event estimation of the sun, Russian roulette. `length` [world unit] is an upper
/// bound of the distance over which a ray can meet the medium. `path`: index of the sample for the given seed.
double radiance_sample(const McMedium& medium, const WorldRay& ray, double length, uint64_t seed, uint64_t path);

/// An estimate and its standard error.
struct McPower {
    double power, error;
};

/// Power of collided light out through a parallelogram with edges u and v, outside the medium; `inward` is its unit
/// normal towards the medium. `paths` points and cosine-distributed directions, one radiance_sample() each.
McPower power_through(const McMedium& medium, const Vec3d& corner, const Vec3d& u, const Vec3d& v, const Vec3d& inward,
                      double length, uint64_t seed, uint64_t paths);

}  // namespace vdbcloud::test
