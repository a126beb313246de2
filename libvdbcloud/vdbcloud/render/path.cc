#include "vdbcloud/render/path.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/cell_rule.h"
#include "vdbcloud/render/light_sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double far = std::numeric_limits<double>::infinity();

/// Share of a path's first weight below which Russian roulette decides whether the path goes on.
constexpr double small = 0.25;

/// Paths that go on from the first collision. The camera ray, marched exactly through all cells, costs a third of a
/// path, and most of the noise is that of the light scattered later.
constexpr int branches = 4;

double largest(const Vec3d& v) { return std::max({v[0], v[1], v[2]}); }

double sum(const Vec3d& v) { return v[0] + v[1] + v[2]; }

Vec3d opacity(const Vec3d& tau)
{
    const double first = -std::expm1(-tau[0]);
    if (tau[1] == tau[0] && tau[2] == tau[0]) return Vec3d(first);
    return {first, -std::expm1(-tau[1]), -std::expm1(-tau[2])};
}

/// A channel, with probability in proportion to `weight`.
int chosen_channel(const Vec3d& weight, double u)
{
    u *= sum(weight);
    for (int c = 0; c < 2; ++c) {
        if (u < weight[c]) return c;
        u -= weight[c];
    }
    return weight[2] > 0 ? 2 : weight[1] > 0 ? 1 : 0;
}

}  // namespace

PathTracer::PathTracer(const PathScene& scene, const PathEndScene* end, int vertices)
    : scene_(scene), media_(scene), aside_(scene), emission_(scene), vertices_(vertices)
{
    if (end) end_.emplace(*end);
}

void PathTracer::operator()(const WorldRay& ray, PathRandom random, RayResult& result)
{
    result.clear(scene_.lights.size());
    if (scene_.ground && scene_.ground->height(ray.origin) < 0) {
        result.to_ground = 0;
        return;
    }
    media_.set(ray);
    media_.depths(depths_);
    for (size_t v = 0; v < depths_.size(); ++v) result.tau += scene_.media.volumes[v].sigma_t * depths_[v];
    result.true_tau = result.tau;

    const Vec3d opacities = opacity(result.tau);
    Path path;
    path.start = sum(opacities);
    path.weight = Vec3d(path.start);
    path.share = Vec3d(1.0 / 3);
    Collision hit;
    bool collides = false;
    if (path.start > 0) {
        path.hero = chosen_channel(opacities, random.next());
        collides = media_.collide_surely(path.hero, depths_, random, hit);
    }
    if (!scene_.emission.dark()) result.emission = emission_.exact(media_);
    if (collides) {
        Leg leg;
        leg.share = Vec3d(1 / path.start);
        for (size_t l = 0; l < scene_.lights.size(); ++l)
            if (scene_.is_lamp[l]) result.direct[l] = lamp_on(l, ray, leg, 1, random);
        if (scene_.emission.compact() && !nears_end(path)) {
            leg.near_emission = 1;
            result.multiple += emission_on(ray, leg, 1, random);
        }
        ++result.cells;
        const double seen = collide(hit, leg, path, random, result.multiple, result);
        path.weight /= branches;
        path.start /= branches;
        const Vec3d x = ray.at(hit.t);
        for (int n = 0; n < branches; ++n)
            follow(path, x, ray.direction, hit.volume, seen, random, result.multiple, result);
    }
    if (scene_.ground) see_ground(ray, random, result);
}

/// What the ground sends along the camera ray, where the ray meets it.
void PathTracer::see_ground(const WorldRay& ray, PathRandom& random, RayResult& result)
{
    const double to_ground = scene_.ground->distance(ray);
    if (!(to_ground < far)) return;
    result.to_ground = to_ground;
    const Vec3d through = attenuation(result.tau);
    Path path;
    path.start = sum(through);
    if (!(path.start > 0)) return;
    path.weight = Vec3d(path.start);
    path.share = through / path.start;
    path.hero = chosen_channel(through, random.next());
    Leg leg;
    Collision hit;
    if (!meet_ground(ray.at(to_ground), path, leg, random, result.ground) ||
        !travel_on(path, leg, hit, random, result.ground))
        return;
    ++result.cells;
    const double seen = collide(hit, leg, path, random, result.ground, result);
    follow(path, media_.ray().at(hit.t), media_.ray().direction, hit.volume, seen, random, result.ground, result);
}

/// The path beyond a collision at x, with volume `v`, to its end. `light` takes what is not scattered once, by a light,
/// towards the camera. `seen`: the part of the emission seen from x that counts, as collide() returns it.
void PathTracer::follow(Path path, Vec3d x, Vec3d incoming, size_t v, double seen, PathRandom& random, Vec3d& light,
                        RayResult& result)
{
    while (survives(path, random)) {
        if (end_ && path.collisions + 1 == vertices_) return gather(path, x, incoming, v, random, light, result);
        const PreparedVolume& volume = scene_.media.volumes[v];
        const auto phase = [&](const Vec3d& outgoing) {
            return volume.phase(std::clamp(incoming.dot(outgoing), -1.0, 1.0));
        };
        for (size_t l = 0; l < scene_.lights.size(); ++l)
            if (scene_.is_lamp[l]) light += lamp_beyond(l, x, phase, path, random);
        const bool towards_emission = scene_.emission.sampled(x);
        if (towards_emission) light += emission_beyond(x, phase, path, seen, random);

        const double u1 = random.next(), u2 = random.next();
        const Vec3d outgoing = volume.phase.sample(incoming, u1, u2);
        Leg leg{scene_.has_lamp || towards_emission ? phase(outgoing) : 1, path.share, false, towards_emission, seen};
        leg.near_emission = towards_emission && !nears_end(path) ? density_near_emission(x, outgoing) : 0;
        media_.set({x, outgoing});
        Collision hit;
        // A path may come to the ground any number of times.
        while (!travel_on(path, leg, hit, random, light)) {
            const double to_ground = scene_.ground ? scene_.ground->distance(media_.ray()) : far;
            if (!(to_ground < far) || !meet_ground(media_.ray().at(to_ground), path, leg, random, light)) return;
        }
        x = media_.ray().at(hit.t);
        incoming = media_.ray().direction;
        v = hit.volume;
        ++result.cells;
        seen = collide(hit, leg, path, random, light, result);
    }
}

/// Finds the next collision of media_'s ray. Without one false: the path's share is then that of the whole ray, and the
/// sky has been added where the ray meets it. Emission on the way is added.
bool PathTracer::travel_on(Path& path, const Leg& leg, Collision& hit, PathRandom& random, Vec3d& light)
{
    const bool collides = media_.collide(path.hero, random, hit);
    if (leg.towards_emission) {
        // The part of the ray's emission that emission_beyond() does not bring.
        const double share = leg.seen * leg.phase / (leg.phase + scene_.emission.density(media_.ray()));
        light += path.worth() * share * emission_.sampled(media_, dim_by_chance, random);
    } else if (!scene_.emission.dark()) {
        light += path.worth() * leg.seen *
                 (scene_.media.grey && scene_.emission.often_met(media_.ray().origin)
                      ? emission_.unattenuated(media_, collides ? hit.t : far)
                      : emission_.sampled(media_, dim_by_chance, random));
    }
    if (collides) return true;
    const bool to_sky = !scene_.ground || !(scene_.ground->distance(media_.ray()) < far);
    if (to_sky && scene_.sky.dark()) return false;
    if (!scene_.media.grey) attenuate(path, attenuation(media_.optical_depth(0, far)));
    if (to_sky) light += path.worth() * scene_.sky.radiance(media_.ray().direction);
    return false;
}

/// The path reaches the ground at x: its weight takes up the albedo, the lights are added, and media_ has the next ray,
/// whose directions have the density cosine / pi. False if the path ends.
bool PathTracer::meet_ground(const Vec3d& x, Path& path, Leg& leg, PathRandom& random, Vec3d& light)
{
    const Ground& ground = *scene_.ground;
    path.weight *= ground.albedo;
    if (!(ground.albedo > 0)) return false;
    const auto lambert = [&](const Vec3d& outgoing) { return std::max(outgoing.dot(ground.up), 0.0) / pi; };
    for (size_t l = 0; l < scene_.lights.size(); ++l) light += path.worth() * light_at(l, x, lambert, random);
    if (!survives(path, random)) return false;
    for (size_t l = 0; l < scene_.lights.size(); ++l)
        if (scene_.is_lamp[l]) light += lamp_beyond(l, x, lambert, path, random);
    const bool towards_emission = scene_.emission.sampled(x);
    if (towards_emission) light += emission_beyond(x, lambert, path, 1, random);
    const double u = random.next(), angle = 2 * pi * random.next();
    const Vec3d a = (std::abs(ground.up[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(ground.up).unit(),
                b = ground.up.cross(a);
    const Vec3d outgoing =
        (std::sqrt(1 - u) * ground.up + std::sqrt(u) * (std::cos(angle) * a + std::sin(angle) * b)).unit();
    leg = {lambert(outgoing), path.share, false, towards_emission};
    leg.near_emission = towards_emission && !nears_end(path) ? density_near_emission(x, outgoing) : 0;
    media_.set({x, outgoing});
    return true;
}

/// Each channel's path density takes up a factor.
void PathTracer::attenuate(Path& path, const Vec3d& factor) const
{
    const Vec3d density = path.share * factor;
    const double all = sum(density);
    if (all > 0) path.share = density / all;
}

/// The path reaches a collision: its weight takes up the albedo, and the lights are added. Returns the part of the
/// emission seen from there that counts: emission_on() brings the remainder.
double PathTracer::collide(const Collision& hit, const Leg& leg, Path& path, PathRandom& random, Vec3d& others,
                           RayResult& result)
{
    const PreparedVolume& volume = scene_.media.volumes[hit.volume];
    double path_density = 0;
    if (!scene_.media.grey || scene_.has_lamp || leg.near_emission > 0) {
        const Vec3d tau = media_.optical_depth(0, hit.t);
        path_density = leg.density(volume.sigma_t * hit.density, attenuation(tau));
        if (!scene_.media.grey) {
            // Relative to the hero's, which can underflow no more than its own random number did.
            const Vec3d relative = attenuation(tau - Vec3d(tau[path.hero]));
            attenuate(path, volume.sigma_t * relative);
        }
    }
    path.weight *= media_.albedo(hit.volume, hit.t);
    ++path.collisions;
    const Vec3d& incoming = media_.ray().direction;
    const auto phase = [&](const Vec3d& to_light) {
        return volume.phase(std::clamp(to_light.dot(incoming), -1.0, 1.0));
    };
    for (size_t l = 0; l < scene_.lights.size(); ++l) {
        Vec3d light = path.worth() * light_at(l, media_.ray().at(hit.t), phase, random);
        if (scene_.is_lamp[l]) light *= path_density / (path_density + density_of_lamp_sampling(l, leg, hit.t));
        (leg.camera ? result.direct[l] : others) += light;
    }
    double t0, t1;
    if (!(leg.near_emission > 0) || !media_.bounds(t0, t1)) return 1;
    const double other = leg.near_emission * scene_.emission.lit(media_.ray(), t0, t1).density(hit.t);
    return path_density / (path_density + other);
}

/// Russian roulette: a path of small worth ends, or goes on with the worth `small`, with the same mean.
bool PathTracer::survives(Path& path, PathRandom& random) const
{
    const double part = 3 * largest(path.worth()) / path.start;
    if (part >= small) return true;
    if (!(random.next() * small < part)) return false;
    path.weight *= small / part;
    return true;
}

/// Radiance that a point of a volume or of the ground sends along the path from one light, over its albedo. `scatter`:
/// probability density of the direction towards the light.
template<typename Scatter>
Vec3d PathTracer::light_at(size_t light, const Vec3d& x, const Scatter& scatter, PathRandom& random)
{
    const Light& from = scene_.lights[light];
    const double u = random.next(), v = random.next();
    const Sight sight = from->sample(x, u, v);
    if (!(sight.distance > 0)) return Vec3d(0.0);
    // The part of a sun's disc that is below the horizon.
    if (scene_.ground && !(sight.distance < far) && sight.direction.dot(scene_.ground->up) < 0) return Vec3d(0.0);
    aside_.set({x, sight.direction});
    return scatter(sight.direction) * from->irradiance(x) * from.strength() *
           aside_.transmittance(sight.distance, random);
}

/// Density with which lamp_on() or lamp_beyond() sample the point at t of the path's ray.
double PathTracer::density_of_lamp_sampling(size_t light, const Leg& leg, double t) const
{
    double t0, t1;
    if (!media_.bounds(t0, t1)) return 0;
    const WorldRay& ray = media_.ray();
    const Vec3d lamp = scene_.lights[light]->source()->position;
    const double direction = leg.camera ? 1 : density_near_lamp((lamp - ray.origin).unit(), ray.direction);
    return direction * EquiangularSampler(ray, lamp, t0, t1).density(t);
}

/// Light of a lamp that one point of a ray, sampled by equal angles, scatters towards the ray's origin, weighted
/// against the collisions of paths. `leg` and `direction_density`: densities of the ray for both.
Vec3d PathTracer::lamp_on(size_t light, const WorldRay& ray, const Leg& leg, double direction_density,
                          PathRandom& random)
{
    const Vec3d lamp = scene_.lights[light]->source()->position;
    aside_.set(ray);
    double t0, t1;
    const double u = random.next();
    if (!aside_.bounds(t0, t1)) return Vec3d(0.0);
    const EquiangularSampler points(ray, lamp, t0, t1);
    const double t = points.sample(u), density = direction_density * points.density(t);
    if (!(density > 0)) return Vec3d(0.0);
    const Vec3d transmittance = attenuation(aside_.optical_depth(0, t)), x = ray.at(t), to_lamp = lamp - x;
    const double distance = to_lamp.length();
    if (!(distance > 0)) return Vec3d(0.0);
    const double cosine = std::clamp(to_lamp.dot(ray.direction) / distance, -1.0, 1.0);
    Vec3d scattered(0);
    for (size_t v = 0; v < scene_.media.volumes.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        const Vec3d sigma_t = volume.sigma_t * aside_.density(v, t);
        if (sigma_t == Vec3d(0.0)) continue;
        scattered +=
            sigma_t * aside_.albedo(v, t) * volume.phase(cosine) / (density + leg.density(sigma_t, transmittance));
    }
    if (scattered == Vec3d(0.0)) return scattered;
    const Light& from = scene_.lights[light];
    aside_.set({x, to_lamp / distance});
    return transmittance * scattered * from->irradiance(x) * from.strength() * aside_.transmittance(distance, random);
}

/// The same for the ray beyond a collision or a point of the ground, x, in a direction that prefers the lamp.
template<typename Scatter>
Vec3d PathTracer::lamp_beyond(size_t light, const Vec3d& x, const Scatter& scatter, const Path& path,
                              PathRandom& random)
{
    const Vec3d to_lamp = scene_.lights[light]->source()->position - x;
    const double u = random.next(), v = random.next(), distance = to_lamp.length();
    if (!(distance > 0)) return Vec3d(0.0);
    const Vec3d direction = direction_near_lamp(to_lamp / distance, u, v);
    const double density = scatter(direction);
    const Leg leg{density, path.share, false};
    return path.worth() * density *
           lamp_on(light, {x, direction}, leg, density_near_lamp(to_lamp / distance, direction), random);
}

/// Emission that two rays beyond a collision or a point of the ground, x, bring to the path: that on a ray towards a
/// point that emits, of which the part `seen` counts, and that which a point of a ray close to a compact body of
/// emission scatters.
template<typename Scatter>
Vec3d PathTracer::emission_beyond(const Vec3d& x, const Scatter& scatter, const Path& path, double seen,
                                  PathRandom& random)
{
    const double u = random.next(), in_x = random.next(), in_y = random.next(), in_z = random.next();
    const Vec3d to = scene_.emission.point(u, Vec3d(in_x, in_y, in_z)) - x;
    const double distance = to.length();
    if (!(distance > 0)) return Vec3d(0.0);
    const WorldRay ray{x, to / distance};
    const double phase = scatter(ray.direction), density = scene_.emission.density(ray);
    aside_.set(ray);
    Vec3d all = (seen * phase / (phase + density)) * emission_.sampled(aside_, dim_on_purpose, random);
    if (scene_.emission.compact() && !nears_end(path)) {
        const double v = random.next(), w = random.next();
        const Vec3d aside = direction_near_lamp((scene_.emission.centre() - x).unit(), v, w);
        const double scattered = scatter(aside);
        const Leg leg{scattered, path.share, false};
        if (scattered > 0) all += scattered * emission_on({x, aside}, leg, density_near_emission(x, aside), random);
    }
    return path.worth() * all;
}

}  // namespace vdbcloud
