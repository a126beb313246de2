#include "vdbcloud/render/path.h"

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

PathTracer::PathTracer(const PathScene& scene) : scene_(scene), media_(scene), aside_(scene) {}

void PathTracer::operator()(const WorldRay& ray, PathRandom random, RayResult& result)
{
    result.clear(scene_.lights.size());
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
    if (scene_.emits) result.emission = emitted_to_camera(collides ? hit.t : far, result.tau, random);
    if (!collides) return;

    Leg leg;
    leg.share = Vec3d(1 / path.start);
    for (size_t l = 0; l < scene_.lights.size(); ++l)
        if (scene_.is_lamp[l]) result.direct[l] = lamp_on(l, ray, leg, 1, random);
    for (;;) {
        const Vec3d x = media_.ray().at(hit.t), incoming = media_.ray().direction;
        const PreparedVolume& volume = scene_.media.volumes[hit.volume];
        ++result.cells;
        collide(hit, leg, path, random, result);
        if (!survives(path, random)) return;
        for (size_t l = 0; l < scene_.lights.size(); ++l)
            if (scene_.is_lamp[l]) result.multiple += lamp_beyond(l, x, incoming, volume, path, random);

        const double u = random.next(), v = random.next();
        const Vec3d outgoing = volume.phase.sample(incoming, u, v);
        leg = {scene_.has_lamp ? volume.phase(std::clamp(incoming.dot(outgoing), -1.0, 1.0)) : 1, path.share, false};
        media_.set({x, outgoing});
        collides = media_.collide(path.hero, random, hit);
        if (scene_.emits) {
            double from = 0;
            Path at = path;
            result.multiple += emitted(collides ? hit.t : far, random, [&](double t) {
                if (t < from) {  // the next volume
                    from = 0;
                    at = path;
                }
                if (!scene_.media.grey) attenuate(at, attenuation(media_.optical_depth(from, t)));
                from = t;
                return at.worth();
            });
        }
        if (collides) continue;
        if (scene_.sky.dark()) return;
        if (!scene_.media.grey) attenuate(path, attenuation(media_.optical_depth(0, far)));
        result.multiple += path.worth() * scene_.sky.radiance(outgoing);
        return;
    }
}

/// Each channel's path density takes up a factor.
void PathTracer::attenuate(Path& path, const Vec3d& factor) const
{
    const Vec3d density = path.share * factor;
    const double all = sum(density);
    if (all > 0) path.share = density / all;
}

/// The path reaches a collision: its weight takes up the albedo, and the lights are added.
void PathTracer::collide(const Collision& hit, const Leg& leg, Path& path, PathRandom& random, RayResult& result)
{
    const PreparedVolume& volume = scene_.media.volumes[hit.volume];
    double path_density = 0;
    if (!scene_.media.grey || scene_.has_lamp) {
        const Vec3d tau = media_.optical_depth(0, hit.t);
        path_density = leg.density(volume.sigma_t * hit.density, attenuation(tau));
        if (!scene_.media.grey) {
            // Relative to the hero's, which can underflow no more than its own random number did.
            const Vec3d relative = attenuation(tau - Vec3d(tau[path.hero]));
            attenuate(path, volume.sigma_t * relative);
        }
    }
    path.weight *= media_.albedo(hit.volume, hit.t);
    for (size_t l = 0; l < scene_.lights.size(); ++l) {
        Vec3d light = path.worth() * light_at(l, volume, media_.ray(), hit.t, random);
        if (scene_.is_lamp[l]) light *= path_density / (path_density + density_of_lamp_sampling(l, leg, hit.t));
        (leg.camera ? result.direct[l] : result.multiple) += light;
    }
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

/// Radiance that a volume scatters towards the ray's origin at t from one light, over its albedo.
Vec3d PathTracer::light_at(size_t light, const PreparedVolume& volume, const WorldRay& ray, double t,
                           PathRandom& random)
{
    const Light& from = scene_.lights[light];
    const Vec3d x = ray.at(t);
    const double u = random.next(), v = random.next();
    const Sight sight = from->sample(x, u, v);
    if (!(sight.distance > 0)) return Vec3d(0.0);
    aside_.set({x, sight.direction});
    return volume.phase(std::clamp(sight.direction.dot(ray.direction), -1.0, 1.0)) * from->irradiance(x) *
           from.strength() * aside_.transmittance(sight.distance, random);
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

/// The same for the ray beyond a collision at x, in a direction that prefers the lamp.
Vec3d PathTracer::lamp_beyond(size_t light, const Vec3d& x, const Vec3d& incoming, const PreparedVolume& volume,
                              const Path& path, PathRandom& random)
{
    const Vec3d to_lamp = scene_.lights[light]->source()->position - x;
    const double u = random.next(), v = random.next(), distance = to_lamp.length();
    if (!(distance > 0)) return Vec3d(0.0);
    const Vec3d direction = direction_near_lamp(to_lamp / distance, u, v);
    const double phase = volume.phase(std::clamp(incoming.dot(direction), -1.0, 1.0));
    const Leg leg{phase, path.share, false};
    return path.worth() * phase *
           lamp_on(light, {x, direction}, leg, density_near_lamp(to_lamp / distance, direction), random);
}

/// The emission of the ray's first `end`. `weight`: of a point of the ray, asked for in the order of each volume's
/// cells. Where extinction is grey the weight is constant and each cell is integrated in closed form; else one random
/// point of a cell stands for it.
template<typename Weight>
Vec3d PathTracer::emitted(double end, PathRandom& random, const Weight& weight)
{
    Vec3d all(0);
    for (size_t v = 0; v < scene_.media.volumes.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        if (!volume.emission) continue;
        const IndexRay& index = media_.index_ray(v);
        march_cells(volume.density, index, 0, end, [&](double t0, double t1, const float*, const Vec3i& cell) {
            const Vec3i at = volume.emission->period().home(cell);
            const float* corners = volume.emission->find(Vec3i(at[0] >> 3, at[1] >> 3, at[2] >> 3));
            if (!corners) return true;
            corners += (at[0] & 7) * BrickMap::sx + (at[1] & 7) * BrickMap::sy + (at[2] & 7);
            const Vec3d p = index.at(t0) - Vec3d(cell[0], cell[1], cell[2]), d = (t1 - t0) * index.direction;
            const double s = scene_.media.grey ? 0 : random.next();
            Vec3d emission;
            for (int c = 0; c < 3; ++c) {
                const Cubic j = along(corners + 729 * c, p, d);
                emission[c] = scene_.media.grey ? j.integral(1) : j.at(s);
            }
            all += (t1 - t0) * emission * weight(t0 + s * (t1 - t0));
            return true;
        });
    }
    return all;
}

/// Emission that reaches the camera unscattered. `end`: where the camera ray, forced to collide, does. A share T of the
/// whole ray's emission and a share 1 - T of that before the collision have the mean of emission times transmittance.
Vec3d PathTracer::emitted_to_camera(double end, const Vec3d& tau, PathRandom& random)
{
    const Vec3d through = attenuation(tau), opacities = opacity(tau);
    // A ray along a periodic medium ends only where the medium is opaque.
    const bool sees_all = !scene_.media.repeats || largest(through) > std::exp(-opaque);
    const Vec3d whole = sees_all ? emitted(far, random, [&](double) { return through; }) : Vec3d(0.0);
    if (!(sum(opacities) > 0)) return whole;
    double from = 0;
    Vec3d depth(0);
    return whole + emitted(end, random, [&](double t) {
               if (scene_.media.grey) return opacities;
               if (t < from) {
                   from = 0;
                   depth = Vec3d(0.0);
               }
               depth += media_.optical_depth(from, t);
               from = t;
               // Of channel c the part that collides beyond t, over the density with which any hero does.
               const Vec3d beyond = attenuation(depth) * opacity(tau - depth);
               const double all = sum(beyond);
               return all > 0 ? beyond * (sum(opacities) / all) : Vec3d(0.0);
           });
}

}  // namespace vdbcloud
