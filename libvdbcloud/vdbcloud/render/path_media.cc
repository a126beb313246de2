#include "vdbcloud/render/path_media.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/free_path.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/render/cell_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr double far = std::numeric_limits<double>::infinity();

/// Transmittance below which Russian roulette decides whether a march towards a light goes on.
constexpr double dim = 0.3;

/// Density depth at which each channel that a volume attenuates is opaque: to rounding all of its rays collide.
double opaque_depth(const PreparedVolume& volume)
{
    double least = far;
    for (int c = 0; c < 3; ++c)
        if (volume.sigma_t[c] > 0) least = std::min(least, volume.sigma_t[c]);
    return opaque / least;
}

/// Density, colour and emission alone: all else would change what PreparedScene makes of the extinction.
Scene true_medium(const Scene& scene)
{
    Scene out;
    out.periodic = scene.periodic;
    out.solids = scene.solids;
    for (const Volume& volume : scene.volumes) {
        Volume& plain = out.volumes.emplace_back();
        plain.density = volume.density;
        plain.medium = volume.medium;
        plain.colour = volume.colour;
        plain.emission = volume.emission;
    }
    return out;
}

}  // namespace

Vec3d attenuation(const Vec3d& tau)
{
    const double first = std::exp(-tau[0]);
    if (tau[1] == tau[0] && tau[2] == tau[0]) return Vec3d(first);
    return {first, std::exp(-tau[1]), std::exp(-tau[2])};
}

PathScene::PathScene(const Scene& scene)
    : media(true_medium(scene), IntegratorOptions()), lights(scene.lights), sky(scene.sky), ground(scene.ground),
      emission(media)
{
    for (const Light& light : lights) {
        for (const Volume& volume : scene.volumes)
            require_light_that_leaves(light, index_from_world(volume.density->transform(), volume.density->getName()),
                                      scene.periodic);
        if (ground) require_light_above(light, *ground);
        is_lamp.push_back(bool(light->source()));
        has_lamp = has_lamp || is_lamp.back();
    }
    if (ground) of_ground.colour = Vec3d(ground->albedo);
    for (const PreparedVolume& volume : media.volumes) collisions.emplace_back(volume.density);
}

PathMedia::PathMedia(const PathScene& scene)
    : scene_(scene), ray_{Vec3d(0), Vec3d(0, 0, 1)}, index_(scene.media.volumes.size(), IndexRay({}, ray_))
{
}

void PathMedia::set(const WorldRay& ray)
{
    ray_ = ray;
    if (scene_.media.solids) hit_ = scene_.media.solids->nearest(ray);
    for (size_t v = 0; v < index_.size(); ++v)
        index_[v] = IndexRay(scene_.media.volumes[v].density.index_from_world(), ray);
}

Vec3d PathMedia::optical_depth(double t0, double t1) const
{
    t1 = std::min(t1, stop());
    Vec3d tau(0);
    for (size_t v = 0; v < index_.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        if (volume.sigma_t != Vec3d(0.0))
            tau += volume.sigma_t * scene_.collisions[v].depth_up_to(index_[v], t0, t1, far);
    }
    return tau;
}

double PathMedia::end() const
{
    double t = stop();
    for (size_t v = 0; v < index_.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        const double least = std::min({volume.sigma_t[0], volume.sigma_t[1], volume.sigma_t[2]});
        if (least > 0) t = std::min(t, travel(volume.density, index_[v], 0, t, opaque / least).t);
    }
    return t;
}

bool PathMedia::bounds(double& t0, double& t1) const
{
    t0 = far;
    t1 = 0;
    for (size_t v = 0; v < index_.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        double in = 0, out = far;
        if (volume.sigma_t == Vec3d(0.0) || !clip(index_[v], volume.density, in, out)) continue;
        t0 = std::min(t0, in);
        t1 = std::max(t1, out);
    }
    t1 = std::min(t1, stop());
    return t0 < t1;
}

double PathMedia::density(size_t volume, double t) const
{
    return scene_.media.volumes[volume].density.sample(index_[volume].at(t));
}

Vec3d PathMedia::albedo(size_t volume, double t) const
{
    const PreparedVolume& v = scene_.media.volumes[volume];
    return v.colour ? albedo_at(v, v.colour->index_from_world().point(ray_.at(t))) : v.albedo;
}

bool PathMedia::meet(size_t v, double depth, double t1, Collision& collision) const
{
    const Travel way = travel(scene_.media.volumes[v].density, index_[v], 0, t1, depth);
    if (way.reached) collision = {way.t, v, way.density};
    return way.reached;
}

bool PathMedia::meet(size_t v, int channel, double t1, PathRandom& random, Collision& collision) const
{
    const double sigma_t = scene_.media.volumes[v].sigma_t[channel];
    NullCollisions::Hit hit;
    if (!(sigma_t > 0) || !scene_.collisions[v].collide(index_[v], 0, t1, sigma_t, random, hit)) return false;
    collision = {hit.t, v, hit.density};
    return true;
}

bool PathMedia::collide(int channel, PathRandom& random, Collision& collision) const
{
    double nearest = stop();
    bool met = false;
    for (size_t v = 0; v < index_.size(); ++v)
        if (meet(v, channel, nearest, random, collision)) {
            nearest = collision.t;
            met = true;
        }
    return met;
}

bool PathMedia::collide_surely(int channel, const std::vector<double>& depths, PathRandom& random,
                               Collision& collision) const
{
    // Which volume is the first in order that the ray collides with, given that there is one: those before it are
    // passed, the collision with it is certain, those after it are as in collide().
    const auto tau = [&](size_t v) { return scene_.media.volumes[v].sigma_t[channel] * depths[v]; };
    double all = 0;
    for (size_t v = 0; v < index_.size(); ++v) all += tau(v);
    double u = random.next() * -std::expm1(-all), passed = 1;
    size_t first = 0;
    for (; first + 1 < index_.size(); ++first) {
        const double part = passed * -std::expm1(-tau(first));
        if (u < part) break;
        u -= part;
        passed *= std::exp(-tau(first));
    }
    while (first > 0 && !(tau(first) > 0)) --first;  // rounding of u
    if (!(tau(first) > 0)) return false;
    double nearest = stop();
    bool any = false;
    for (size_t v = first; v < index_.size(); ++v) {
        const bool met =
            v == first
                ? meet(v, -std::log1p(random.next() * std::expm1(-tau(v))) / scene_.media.volumes[v].sigma_t[channel],
                       nearest, collision)
                : meet(v, channel, nearest, random, collision);
        if (met) nearest = collision.t;
        any = any || met;
    }
    return any;
}

void PathMedia::depths(std::vector<double>& out) const
{
    out.assign(index_.size(), 0.0);
    for (size_t v = 0; v < index_.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        if (volume.sigma_t != Vec3d(0.0))
            out[v] = scene_.collisions[v].depth_up_to(index_[v], 0, stop(),
                                                      scene_.media.repeats ? opaque_depth(volume) : far);
    }
}

Vec3d PathMedia::transmittance(double distance, PathRandom& random) const
{
    if (stop() < distance) return Vec3d(0.0);
    // Light below `dim` in every channel survives with probability (brightest channel) / dim, then as bright as dim.
    const double least = dim * (1 - random.next()), deepest = -std::log(least);
    Vec3d tau(0);
    for (size_t v = 0; v < index_.size(); ++v) {
        const PreparedVolume& volume = scene_.media.volumes[v];
        if (volume.sigma_t == Vec3d(0.0)) continue;
        double most = 0;
        for (int c = 0; c < 3; ++c)
            most = std::max(most, volume.sigma_t[c] > 0 ? (deepest - tau[c]) / volume.sigma_t[c] : far);
        tau += volume.sigma_t * scene_.collisions[v].depth_up_to(index_[v], 0, distance, most);
        if (std::min({tau[0], tau[1], tau[2]}) > deepest) return Vec3d(0.0);
    }
    const double thinnest = std::min({tau[0], tau[1], tau[2]});
    if (thinnest <= -std::log(dim)) return attenuation(tau);
    return dim * attenuation(tau - Vec3d(thinnest));
}

}  // namespace vdbcloud
