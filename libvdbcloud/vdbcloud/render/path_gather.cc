#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/light_sampling.h"
#include "vdbcloud/render/path.h"

#include <algorithm>

namespace vdbcloud {

namespace {

constexpr double nowhere = 1e30;  // as RayResult::to_ground has it

}  // namespace

const RayResult& PathTracer::end_along(const WorldRay& ray, PathRandom& random, RayResult& result)
{
    // Solids take numbers of a stream of their own: without them the path's stay as they are.
    const RayResult& met = end_->along(ray, scene_.media.solids ? random.branch() : random);
    ++result.ends;
    result.end_cells += met.cells;
    result.lit += met.lit;
    return met;
}

/// The end of a path at its last collision, at x in volume v: what arrives there as the picture shows it. Lamps and
/// emission, which one ray meets by chance alone, are also sought by rays towards them; the balance heuristic joins
/// both.
void PathTracer::gather(const Path& path, const Vec3d& x, const Vec3d& incoming, size_t v, PathRandom& random,
                        Vec3d& light, RayResult& result)
{
    const PhaseFunction& phase = scene_.media.volumes[v].phase;
    const auto scatter = [&](const Vec3d& outgoing) { return phase(std::clamp(incoming.dot(outgoing), -1.0, 1.0)); };
    const auto to_lamp = [&](size_t l) { return scene_.lights[l]->source()->position - x; };
    const auto sought = [&](size_t l) { return scene_.is_lamp[l] && to_lamp(l).lengthSqr() > 0; };
    const bool towards_emission = scene_.emission.sampled(x);

    double u1 = random.next(), u2 = random.next();
    WorldRay ray{x, phase.sample(incoming, u1, u2)};
    double density = scatter(ray.direction);
    const RayResult& met = end_along(ray, random, result);
    Vec3d sum = met.multiple + met.ground + met.solid;
    for (size_t l = 0; l < scene_.lights.size(); ++l) {
        const double other = sought(l) ? density_near_lamp(to_lamp(l).unit(), ray.direction) : 0;
        sum += density / (density + other) * met.direct[l];
    }
    sum += density / (density + (towards_emission ? scene_.emission.density(ray) : 0)) * met.emission;
    if (!(met.to_ground < nowhere) && !scene_.sky.dark())
        sum += attenuation(met.tau) * scene_.sky.radiance(ray.direction);

    for (size_t l = 0; l < scene_.lights.size(); ++l) {
        if (!sought(l)) continue;
        u1 = random.next(), u2 = random.next();
        ray.direction = direction_near_lamp(to_lamp(l).unit(), u1, u2);
        density = scatter(ray.direction);
        const double other = density_near_lamp(to_lamp(l).unit(), ray.direction);
        if (density > 0) sum += density / (density + other) * end_along(ray, random, result).direct[l];
    }
    if (towards_emission) {
        const double u = random.next(), in_x = random.next(), in_y = random.next(), in_z = random.next();
        const Vec3d to = scene_.emission.point(u, Vec3d(in_x, in_y, in_z)) - x;
        if (to.lengthSqr() > 0) {
            ray.direction = to.unit();
            density = scatter(ray.direction);
            if (density > 0)
                sum += density / (density + scene_.emission.density(ray)) * end_along(ray, random, result).emission;
        }
    }
    light += path.worth() * sum;
}

}  // namespace vdbcloud
