#include "vdbcloud/render/surface_light.h"

#include "vdbcloud/core/constants.h"
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
    : media(prepared), options(o), ground(scene), emission(prepared), sky(scene.sky)
{
}

SurfaceLight::SurfaceLight(const SurfaceScene& scene)
    : scene_(scene), integrate_(make_integrator(scene.media, scene.options))
{
    const auto& volumes = scene.media.volumes;
    const bool scatters = std::any_of(volumes.begin(), volumes.end(), [](const PreparedVolume& volume) {
        return volume.is_medium() && !volume.density.empty() && volume.phase.mean_cosine() > 0;
    });
    for (const Light& light : scene.media.lights)
        if (const auto sun = light->common_direction(); sun && scatters) suns_.push_back(*sun);
}

void SurfaceLight::operator()(const WorldRay& ray, PathRandom random, RayResult& result)
{
    further_ = cells_ = lit_ = 0;
    march(ray, random, {}, result);
    result.further = further_;
    result.cells += cells_;
    result.lit += lit_;
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

    const Chain next{chain.all + 1, chain.spread + !reflection.mirror()};
    if (reflection.mirror())
        return colour * (direct + radiance({hit.outside, reflection.image()}, random, next) / goes_on);
    const int rays = chain.spread == 0 ? scene_.options.solid_rays : 1;
    return colour * (direct + gathered(reflection, hit, rays, random, next) / goes_on);
}

/// Light from all directions above a point of a surface, without the colour. Rays are drawn in equal numbers as the
/// surface reflects; about the suns, if there are any: there a thin medium is bright, which scatters forward; and
/// towards points that emit, where rays would seldom meet them by chance. The balance heuristic joins them.
Vec3d SurfaceLight::gathered(const Reflection& reflection, const SolidHit& hit, int rays, PathRandom& random,
                             const Chain& next)
{
    const bool fire = !scene_.emission.dark() && scene_.emission.sampled(hit.outside);
    double about_suns = 0, to_fire = 0;  // rays, in the mean
    const double share = double(rays) / (1 + int(!suns_.empty()) + int(fire));
    if (!suns_.empty()) about_suns = rays > 1 ? std::floor(share) : share;
    if (fire) to_fire = rays > 1 ? std::floor(share) : share;
    const double drawn = rays == 1 && share < 1 ? random.next() : 1;
    const double u = random.next(), v = random.next();
    Vec3d sum(0);
    for (int n = 0; n < rays; ++n) {
        const double x = even(u, n, 0.7548776662466927), y = even(v, n, 0.5698402909980532);
        const double place = rays > 1 ? n : drawn;
        Vec3d way;
        if (place < about_suns)
            way = about_sun(x, y);
        else if (place < about_suns + to_fire)
            way = towards_fire(hit.outside, x, y, random);
        else
            way = reflection.sample(x, y);
        if (!(way.dot(hit.normal) > 0)) continue;
        double density = (rays - about_suns - to_fire) * reflection.density(way);
        if (about_suns > 0) density += about_suns * density_about_suns(way);
        if (to_fire > 0) density += to_fire * scene_.emission.density({hit.outside, way});
        sum += reflection.value(way) / density * radiance({hit.outside, way}, random, next);
    }
    return sum;
}

/// The direction of a point that emits; 0 at the point itself.
Vec3d SurfaceLight::towards_fire(const Vec3d& x, double u, double v, PathRandom& random) const
{
    const double second = random.next(), third = random.next();
    const Vec3d way = scene_.emission.point(u, Vec3d(v, second, third)) - x;
    const double length = way.length();
    return length > 0 ? way / length : Vec3d(0.0);
}

Vec3d SurfaceLight::about_sun(double u, double v) const
{
    const double place = u * double(suns_.size());
    const size_t sun = std::min(suns_.size() - 1, size_t(place));
    return direction_about(suns_[sun], std::pow(1 - (place - double(sun)), 1 / (aureole + 1)), 2 * pi * v);
}

double SurfaceLight::density_about_suns(const Vec3d& way) const
{
    double sum = 0;
    for (const Vec3d& sun : suns_)
        sum += (aureole + 1) / (2 * pi) * std::pow(std::max(0.0, sun.dot(way)), aureole) / double(suns_.size());
    return sum;
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
    ++further_;
    cells_ += result.cells;
    lit_ += result.lit;
    Vec3d sum = result.multiple + result.emission + result.ground + result.solid;
    for (const Vec3d& direct : result.direct) sum += direct;
    if (!(result.to_ground < nowhere)) sum += through(result.tau) * scene_.sky.radiance(ray.direction);
    return sum;
}

}  // namespace vdbcloud
