#pragma once
// Path tracing of a voxel cloud under one sun: slow, without bias, and without any of the library's transport.
#include "vdbcloud/voxels/brick_map.h"

#include <cstdint>

namespace vdbcloud::test {

/// A grey medium with Henyey-Greenstein scattering; density as its trilinear interpolant.
struct McMedium {
    const BrickMap* density = nullptr;
    double sigma_t = 1;  ///< sigma_t at density 1 [1/world unit]
    double densest = 1;  ///< no density is greater
    double w0 = 1, g = 0;
    Vec3d to_sun{0, 1, 0};  ///< unit; irradiance 1
};

/// One sample of the radiance that comes back along a ray that starts outside (collisions of the ray with the medium,
/// next-event estimation of the sun, Woodcock tracking, roulette). `length` bounds the part of the ray that can meet
/// the medium.
double radiance_sample(const McMedium& medium, const WorldRay& ray, double length, uint64_t seed, uint64_t path);

}  // namespace vdbcloud::test
