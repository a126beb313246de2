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

/// How a collision scatters the light of a path: by the phase function, which is also the density of its sampler.
struct Scattering {
    const PhaseFunction& phase;
    const Vec3d& incoming;
    double value(const Vec3d& outgoing) const { return phase(std::clamp(incoming.dot(outgoing), -1.0, 1.0)); }
    double density(const Vec3d& outgoing) const { return value(outgoing); }
};

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
    const std::optional<Surface> seen_surface = surface();
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
    if (seen_surface) see_surface(*seen_surface, attenuation(result.tau), ray.direction, random, result);
}

/// The ground or the solid that ends media_'s ray.
std::optional<PathTracer::Surface> PathTracer::surface() const
{
    std::optional<Surface> out;
    if (const auto& hit = media_.hit())
        out = {hit->t, hit->outside, hit->normal, &scene_.media.solids->material(hit->solid), true};
    if (scene_.ground)
        if (const double t = scene_.ground->distance(media_.ray()); t < media_.stop())
            out = {t, media_.ray().at(t), scene_.ground->up, &scene_.of_ground, false};
    return out;
}

/// What a surface sends along the camera ray, where the ray meets it.
void PathTracer::see_surface(const Surface& surface, const Vec3d& through, const Vec3d& direction, PathRandom& random,
                             RayResult& result)
{
    result.to_ground = surface.t;
    Path path;
    path.start = sum(through);
    if (!(path.start > 0)) return;
    path.weight = Vec3d(path.start);
    path.share = through / path.start;
    path.hero = chosen_channel(through, random.next());
    Leg leg;
    Collision hit;
    Vec3d& light = surface.solid ? result.solid : result.ground;
    media_.set({surface.x, direction});
    if (!meet_surface(surface, path, leg, random, light) || !collide_again(path, leg, hit, random, light)) return;
    ++result.cells;
    const double seen = collide(hit, leg, path, random, light, result);
    follow(path, media_.ray().at(hit.t), media_.ray().direction, hit.volume, seen, random, light, result);
}

/// The next collision of media_'s ray or, where the path comes to surfaces, of those that it goes on with. False if the
/// path ends before.
bool PathTracer::collide_again(Path& path, Leg& leg, Collision& hit, PathRandom& random, Vec3d& light)
{
    while (!travel_on(path, leg, hit, random, light)) {
        const std::optional<Surface> next = surface();
        if (!next || !meet_surface(*next, path, leg, random, light)) return false;
    }
    return true;
}

/// The path beyond a collision at x, with volume `v`, to its end. `light` takes what is not scattered once, by a light,
/// towards the camera. `seen`: the part of the emission seen from x that counts, as collide() returns it.
void PathTracer::follow(Path path, Vec3d x, Vec3d incoming, size_t v, double seen, PathRandom& random, Vec3d& light,
                        RayResult& result)
{
    while (survives(path, random)) {
        if (end_ && path.collisions + 1 == vertices_) return gather(path, x, incoming, v, random, light, result);
        const PreparedVolume& volume = scene_.media.volumes[v];
        const Scattering phase{volume.phase, incoming};
        for (size_t l = 0; l < scene_.lights.size(); ++l)
            if (scene_.is_lamp[l]) light += lamp_beyond(l, x, phase, path, random);
        const bool towards_emission = scene_.emission.sampled(x);
        if (towards_emission) light += emission_beyond(x, phase, path, seen, random);

        const double u1 = random.next(), u2 = random.next();
        const Vec3d outgoing = volume.phase.sample(incoming, u1, u2);
        Leg leg;
        leg.phase = scene_.has_lamp || towards_emission ? phase.density(outgoing) : 1;
        leg.share = path.share;
        leg.camera = false;
        leg.towards_emission = towards_emission;
        leg.seen = seen;
        leg.near_emission = towards_emission && !nears_end(path) ? density_near_emission(x, outgoing) : 0;
        media_.set({x, outgoing});
        Collision hit;
        if (!collide_again(path, leg, hit, random, light)) return;
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
                      ? emission_.unattenuated(media_, collides ? hit.t : media_.stop())
                      : emission_.sampled(media_, dim_by_chance, random));
    }
    if (collides) return true;
    const bool to_sky = !surface();
    if (to_sky && scene_.sky.dark()) return false;
    if (!scene_.media.grey) attenuate(path, attenuation(media_.optical_depth(0, far)));
    if (to_sky) light += path.worth() * scene_.sky.radiance(media_.ray().direction);
    return false;
}

/// The path reaches a surface: its weight takes up the colour, the lights are added, and media_ has the next ray, whose
/// directions have the density of the reflection. False if the path ends.
bool PathTracer::meet_surface(const Surface& surface, Path& path, Leg& leg, PathRandom& random, Vec3d& light)
{
    path.weight *= surface.material->reflectance(surface.x);
    if (!(largest(path.weight) > 0)) return false;
    const Reflection reflection(*surface.material, surface.normal, -media_.ray().direction);
    if (reflection.mirror()) return see_image(surface, reflection.image(), path, leg, random, light);
    const Vec3d& x = surface.x;
    for (size_t l = 0; l < scene_.lights.size(); ++l) light += path.worth() * light_at(l, x, reflection, random);
    if (!survives(path, random)) return false;
    for (size_t l = 0; l < scene_.lights.size(); ++l)
        if (scene_.is_lamp[l]) light += lamp_beyond(l, x, reflection, path, random);
    const bool towards_emission = scene_.emission.sampled(x);
    if (towards_emission) light += emission_beyond(x, reflection, path, 1, random);
    const double u = random.next(), v = random.next();
    const Vec3d outgoing = reflection.sample(u, v);
    const double value = reflection.value(outgoing), density = reflection.density(outgoing);
    if (!(value > 0)) return false;
    path.weight *= value / density;
    leg = {density, path.share, false, false, towards_emission};
    leg.near_emission = towards_emission && !nears_end(path) ? density_near_emission(x, outgoing) : 0;
    media_.set({x, outgoing});
    return true;
}

/// The path reaches a mirror, and media_ has the ray to its image: lamps and compact emission light points of that ray
/// as they do on the camera ray. False if the path ends.
bool PathTracer::see_image(const Surface& mirror, const Vec3d& image, Path& path, Leg& leg, PathRandom& random,
                           Vec3d& light)
{
    if (!survives(path, random) || ++path.images > most_images) return false;
    const WorldRay ray{mirror.x, image};
    leg = {1, path.share, false, true};
    for (size_t l = 0; l < scene_.lights.size(); ++l)
        if (scene_.is_lamp[l]) light += path.worth() * lamp_on(l, ray, leg, 1, random);
    if (scene_.emission.compact() && !nears_end(path)) {
        leg.near_emission = 1;
        light += path.worth() * emission_on(ray, leg, 1, random);
    }
    media_.set(ray);
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
    const Scattering phase{volume.phase, incoming};
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

/// Radiance that a point of a volume or of a surface sends along the path from one light, over its albedo. `scatter`: a
/// Scattering or a Reflection.
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
    return scatter.value(sight.direction) * from->irradiance(x) * from.strength() *
           aside_.transmittance(sight.distance, random);
}

/// Density with which lamp_on() or lamp_beyond() sample the point at t of the path's ray.
double PathTracer::density_of_lamp_sampling(size_t light, const Leg& leg, double t) const
{
    double t0, t1;
    if (!media_.bounds(t0, t1)) return 0;
    const WorldRay& ray = media_.ray();
    const Vec3d lamp = scene_.lights[light]->source()->position;
    const double direction = leg.camera || leg.image ? 1 : density_near_lamp((lamp - ray.origin).unit(), ray.direction);
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

/// The same for the ray beyond a collision or a point of a surface, x, in a direction that prefers the lamp.
template<typename Scatter>
Vec3d PathTracer::lamp_beyond(size_t light, const Vec3d& x, const Scatter& scatter, const Path& path,
                              PathRandom& random)
{
    const Vec3d to_lamp = scene_.lights[light]->source()->position - x;
    const double u = random.next(), v = random.next(), distance = to_lamp.length();
    if (!(distance > 0)) return Vec3d(0.0);
    const Vec3d direction = direction_near_lamp(to_lamp / distance, u, v);
    const Leg leg{scatter.density(direction), path.share, false};
    return path.worth() * scatter.value(direction) *
           lamp_on(light, {x, direction}, leg, density_near_lamp(to_lamp / distance, direction), random);
}

/// Emission that two rays beyond a collision or a point of a surface, x, bring to the path: that on a ray towards a
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
    const double value = scatter.value(ray.direction);
    const double density = scatter.density(ray.direction) + scene_.emission.density(ray);
    aside_.set(ray);
    Vec3d all = (seen * value / density) * emission_.sampled(aside_, dim_on_purpose, random);
    if (scene_.emission.compact() && !nears_end(path)) {
        const double v = random.next(), w = random.next();
        const Vec3d aside = direction_near_lamp((scene_.emission.centre() - x).unit(), v, w);
        const double scattered = scatter.value(aside);
        const Leg leg{scatter.density(aside), path.share, false};
        if (scattered > 0) all += scattered * emission_on({x, aside}, leg, density_near_emission(x, aside), random);
    }
    return path.worth() * all;
}

}  // namespace vdbcloud
