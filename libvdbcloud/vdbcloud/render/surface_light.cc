#include "vdbcloud/render/surface_light.h"

#include "vdbcloud/optics/optical_depth.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double nowhere = 1e30;  // as RayResult::to_ground has it

Vec3d through(const Vec3d& tau) { return {std::exp(-tau[0]), std::exp(-tau[1]), std::exp(-tau[2])}; }

/// The fractional parts of n times the powers of the plastic number's inverse fill the square evenly (Roberts 2018,
/// R2).
double even(double start, int n, double step)
{
    const double x = start + n * step;
    return x - std::floor(x);
}

}  // namespace

SurfaceScene::SurfaceScene(const Scene& scene, const PreparedScene& prepared, const IntegratorOptions& o)
    : media(prepared), options(o), ground(scene), sky(scene.sky)
{
}

SurfaceLight::SurfaceLight(const SurfaceScene& scene)
    : scene_(scene), integrate_(make_integrator(scene.media, scene.options))
{
}

void SurfaceLight::operator()(const WorldRay& ray, PathRandom random, RayResult& result)
{
    march(ray, random, {}, result);
}

void SurfaceLight::march(const WorldRay& ray, PathRandom& random, const Chain& chain, RayResult& result)
{
    (*integrate_)(ray, result);
    scene_.ground.add(ray, result);
    if (!result.hit || result.to_ground <= result.hit->t) return;
    result.ground = Vec3d(0);
    result.to_ground = result.hit->t;
    result.solid = through(result.tau);
    if (std::max({result.solid[0], result.solid[1], result.solid[2]}) > 0)
        result.solid *= shade(ray, *result.hit, random, chain);
}

/// The radiance of a solid against the ray that meets it.
Vec3d SurfaceLight::shade(const WorldRay& ray, const SolidHit& hit, PathRandom& random, const Chain& chain)
{
    const Material& material = scene_.media.solids->material(hit.solid);
    Vec3d colour = material.reflectance(hit.outside);
    const double most = std::max({colour[0], colour[1], colour[2]});
    if (!(most > 0)) return Vec3d(0.0);
    const Reflection reflection(material, hit.normal, -ray.direction);
    const Vec3d direct = reflection.mirror() ? Vec3d(0.0) : lit(reflection, hit.outside);
    const double goes_on = chain.all < certain ? 1 : std::min(1.0, most);
    if (chain.all >= longest || (goes_on < 1 && !(random.next() < goes_on))) return colour * direct;

    const int rays = chain.spread == 0 && !reflection.mirror() ? scene_.options.solid_rays : 1;
    const double u = random.next(), v = random.next();
    const Chain next{chain.all + 1, chain.spread + !reflection.mirror()};
    Vec3d indirect(0);
    for (int n = 0; n < rays; ++n) {
        const Vec3d way = reflection.sample(even(u, n, 0.7548776662466927), even(v, n, 0.5698402909980532));
        if (!(way.dot(hit.normal) > 0)) continue;
        const double weight = reflection.mirror() ? 1 : reflection.value(way) / reflection.density(way);
        indirect += weight * radiance({hit.outside, way}, random, next);
    }
    return colour * (direct + indirect / (rays * goes_on));
}

/// Light from suns and lamps, without the colour.
Vec3d SurfaceLight::lit(const Reflection& reflection, const Vec3d& x) const
{
    Vec3d sum(0);
    for (const auto& points : scene_.media.points)
        for (const Light& light : points) {
            const Sight sight = light->towards(x);
            const double value = sight.distance > 0 ? reflection.value(sight.direction) : 0;
            if (!(value > 0) || scene_.media.solids->blocked({x, sight.direction}, sight.distance)) continue;
            sum +=
                value * light->irradiance(x) * light.strength() * transmittance({x, sight.direction}, sight.distance);
        }
    return sum;
}

Vec3d SurfaceLight::transmittance(const WorldRay& ray, double distance) const
{
    Vec3d tau(0);
    for (const PreparedVolume& volume : scene_.media.volumes)
        if (volume.is_medium()) tau += volume.sigma_t * density_depth(volume.density, ray, 0, distance);
    return through(tau);
}

/// All that arrives along a ray, the sky included.
Vec3d SurfaceLight::radiance(const WorldRay& ray, PathRandom& random, const Chain& chain)
{
    while (results_.size() <= chain.all) results_.emplace_back();
    RayResult& result = results_[chain.all];
    march(ray, random, chain, result);
    Vec3d sum = result.multiple + result.emission + result.ground + result.solid;
    for (const Vec3d& direct : result.direct) sum += direct;
    if (!(result.to_ground < nowhere)) sum += through(result.tau) * scene_.sky.radiance(ray.direction);
    return sum;
}

}  // namespace vdbcloud
