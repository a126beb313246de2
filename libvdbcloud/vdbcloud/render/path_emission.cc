// Points that a compact body of emission lights, along light paths.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/light_sampling.h"
#include "vdbcloud/render/path.h"

#include <algorithm>

namespace vdbcloud {

/// Density with which emission_beyond() samples directions close to a compact body of emission; 0: there is none.
double PathTracer::density_near_emission(const Vec3d& x, const Vec3d& direction) const
{
    if (!scene_.emission.compact()) return 0;
    return density_near_lamp((scene_.emission.centre() - x).unit(), direction);
}

/// Emission that one point of a ray, sampled by its distance from the emission, scatters towards the ray's origin,
/// weighted against the collisions of paths. `leg` and `direction_density`: densities of the ray for both.
Vec3d PathTracer::emission_on(const WorldRay& ray, const Leg& leg, double direction_density, PathRandom& random)
{
    aside_.set(ray);
    double t0, t1;
    const double u = random.next();
    if (!aside_.bounds(t0, t1)) return Vec3d(0.0);
    const EquiangularSampler points = scene_.emission.lit(ray, t0, t1);
    const double t = points.sample(u), density = direction_density * points.density(t);
    if (!(density > 0)) return Vec3d(0.0);
    const Vec3d transmittance = attenuation(aside_.optical_depth(0, t)), x = ray.at(t);
    scattered_.assign(scene_.media.volumes.size(), Vec3d(0.0));
    for (size_t v = 0; v < scattered_.size(); ++v) {
        const Vec3d sigma_t = scene_.media.volumes[v].sigma_t * aside_.density(v, t);
        if (sigma_t == Vec3d(0.0)) continue;
        scattered_[v] = sigma_t * aside_.albedo(v, t) / (density + leg.density(sigma_t, transmittance));
    }
    Vec3d all(0);
    for (size_t v = 0; v < scattered_.size(); ++v)
        if (scattered_[v] != Vec3d(0.0))
            all += scattered_[v] * emission_at(x, ray.direction, scene_.media.volumes[v], random);
    return transmittance * all;
}

/// Emission that a collision at x turns from all directions into the opposite of `incoming`.
Vec3d PathTracer::emission_at(const Vec3d& x, const Vec3d& incoming, const PreparedVolume& volume, PathRandom& random)
{
    const bool sampled = scene_.emission.sampled(x);
    Vec3d all(0);
    const auto add = [&](const Vec3d& direction) {
        const WorldRay ray{x, direction};
        const double phase = volume.phase(std::clamp(incoming.dot(direction), -1.0, 1.0)),
                     density = sampled ? scene_.emission.density(ray) : 0;
        aside_.set(ray);
        all += phase / (phase + density) * emission_.sampled(aside_, dim_on_purpose, random);
    };
    if (sampled) {
        const double u = random.next(), in_x = random.next(), in_y = random.next(), in_z = random.next();
        const Vec3d to = scene_.emission.point(u, Vec3d(in_x, in_y, in_z)) - x;
        if (to.length() > 0) add(to.unit());
    }
    const double u = random.next(), v = random.next();
    add(volume.phase.sample(incoming, u, v));
    return all;
}

}  // namespace vdbcloud
