#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/free_path.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/render/cell_rule.h"
#include "vdbcloud/render/media.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr size_t maps_before_lights = 7;

/// An optical depth through which nothing comes.
constexpr double hidden = 750;

/// The factor that brings a flux down to flux_limit x phi; 1 for a shorter one.
double shortening(const PreparedVolume& volume, double phi, const Vec3d& flux)
{
    if (volume.flux_limit == 0) return 1;
    const double longest = volume.flux_limit * std::max(phi, 0.0), length = flux.length();
    return length > longest ? longest / length : 1;
}

/// -log T near the edge of a solid's shadow: T interpolated as the part of the light that is seen times the
/// transmittance where it is seen. The logarithm alone would move the edge by half a voxel.
Vec3d depth_where_seen(const BrickMap& depth, const BrickMap& seen, const Vec3d& p)
{
    const Vec3d part = seen.sample3(p), sum = depth.sample3(p);
    Vec3d out;
    for (int c = 0; c < 3; ++c) out[c] = part[c] > 0 ? sum[c] / part[c] - std::log(part[c]) : hidden;
    return out;
}

}  // namespace

RayMedia::RayMedia(const PreparedScene& scene) : scene_(scene)
{
    for (const auto& v : scene.volumes) {
        first_.push_back(rays_.size());
        weights_.emplace_back(v.moments[0].size());
        for (size_t n = 0; n < maps_before_lights + v.light_depth.size(); ++n)
            rays_.emplace_back(v.density.index_from_world(), WorldRay{Vec3d(0), Vec3d(0, 0, 1)});
    }
}

void RayMedia::set(const WorldRay& ray)
{
    ray_ = ray;
    if (scene_.solids) hit_ = scene_.solids->nearest(ray);
    for (size_t n = 0; n < scene_.volumes.size(); ++n) {
        const auto& v = scene_.volumes[n];
        IndexRay* to = &rays_[first_[n]];
        to[0] = IndexRay(v.density.index_from_world(), ray);
        const BrickMap* maps[] = {v.colour.get(),  v.emission.get(), v.phi.get(),
                                  v.flux[0].get(), v.flux[1].get(),  v.flux[2].get()};
        for (size_t m = 0; m < 6; ++m)
            if (maps[m]) to[m + 1] = IndexRay(maps[m]->index_from_world(), ray);
        if (!v.moments[0].empty()) {
            std::vector<double> y(size_t(harmonic_count(v.degree)));
            evaluate_harmonics(v.degree, -ray.direction, y.data());
            for (int l = 2; l <= v.degree; ++l)
                for (int k = l * l; k < (l + 1) * (l + 1); ++k)
                    weights_[n][size_t(k - 4)] = v.scaling.moments[size_t(l)] * y[size_t(k)];
        }
        for (size_t l = 0; l < v.light_depth.size(); ++l)
            to[maps_before_lights + l] = IndexRay(v.light_depth[l]->index_from_world(), ray);
    }
}

bool RayMedia::bounds(double& t0, double& t1) const
{
    t0 = std::numeric_limits<double>::infinity();
    t1 = 0;
    for (size_t n = 0; n < scene_.volumes.size(); ++n) {
        constexpr double far = std::numeric_limits<double>::infinity();
        const auto& v = scene_.volumes[n];
        double in = 0, out = far;
        if (!clip(index_ray(n), v.density, in, out)) continue;
        Vec3d low(v.first_cell), high = Vec3d(v.last_cell) + Vec3d(1);
        for (int a = 0; a < 3; ++a)
            if (v.density.period().length[a] > 0) low[a] = -far, high[a] = far;
        if (!clip(index_ray(n), low, high, in, out)) continue;
        t0 = std::min(t0, in);
        t1 = std::max(t1, out);
    }
    t1 = std::min(t1, end());
    return t0 < t1;
}

double RayMedia::end() const
{
    double t = stop();
    if (!scene_.repeats) return t;
    for (size_t n = 0; n < scene_.volumes.size(); ++n) {
        const auto& v = scene_.volumes[n];
        const double least = std::min({v.sigma_t[0], v.sigma_t[1], v.sigma_t[2]}) * (1 - v.scaling.delta_f);
        if (least > 0) t = std::min(t, travel(v.density, index_ray(n), 0, t, opaque / least).t);
    }
    return t;
}

double RayMedia::density(size_t volume, double t) const
{
    return scene_.volumes[volume].density.sample(ray_of(volume, 0).at(t));
}

Vec3d RayMedia::light_depth(size_t light, size_t volume, double t) const
{
    if (scene_.shadow_rays) return shadow_depth(light, t);
    if (const auto& lamp = scene_.lamp[light]; lamp && (ray_.at(t) - *lamp).lengthSqr() < scene_.near * scene_.near)
        return shadow_depth(light, t);
    const auto& map = *scene_.volumes[volume].light_depth[light];
    const Vec3d p = ray_of(volume, maps_before_lights + light).at(t);
    if (const auto& seen = scene_.volumes[volume].seen[light]) return depth_where_seen(map, *seen, p);
    return map.channels() == 1 ? Vec3d(map.sample(p)) : map.sample3(p);
}

void RayMedia::cuts_by_lamps(double t0, double t1, double longest, std::vector<double>& cuts) const
{
    cuts.clear();
    for (const auto& lamp : scene_.lamp) {
        if (!lamp) continue;
        // With s the nearest point of the ray, b its distance from the lamp and t = s + b sinh(u), du = dt / r.
        const Vec3d to_lamp = *lamp - ray_.origin;
        const double speed = ray_.direction.length(), s = to_lamp.dot(ray_.direction) / (speed * speed);
        const double b = std::max((to_lamp - s * ray_.direction).length() / speed, 1e-3 * (t1 - t0));
        const double first = std::asinh((t0 - s) / b), last = std::asinh((t1 - s) / b);
        const int parts = int(std::ceil((last - first) / longest));
        for (int k = 1; k < parts; ++k) cuts.push_back(s + b * std::sinh(first + (last - first) * k / parts));
    }
    if (scene_.lamp.size() > 1) std::sort(cuts.begin(), cuts.end());
}

Vec3d RayMedia::shadow_depth(size_t light, double t) const
{
    const auto& points = scene_.points[light];
    std::vector<Vec3d> depth(points.size(), Vec3d(0));
    for (size_t k = 0; k < points.size(); ++k) {
        if (scene_.solids) {
            const Sight sight = points[k]->towards(ray_.at(t));
            if (scene_.solids->blocked({ray_.at(t), sight.direction}, sight.distance)) {
                depth[k] = Vec3d(hidden);
                continue;
            }
        }
        for (size_t n = 0; n < scene_.volumes.size(); ++n) {
            const auto& v = scene_.volumes[n];
            depth[k] += extinction(n, v.albedo) * depth_to_light(v.density, *points[k], ray_.at(t));
        }
    }
    if (depth.size() == 1) return depth[0];
    Vec3d mean;  // -log of the mean of exp(-depth), by differences from the least depth, so that nothing underflows
    for (int c = 0; c < 3; ++c) {
        double least = depth[0][c], sum = 0;
        for (const Vec3d& d : depth) least = std::min(least, d[c]);
        for (const Vec3d& d : depth) sum += std::exp(least - d[c]);
        mean[c] = least - std::log(sum / double(depth.size()));
    }
    return mean;
}

Vec3d RayMedia::albedo(size_t volume, double t) const
{
    return albedo_at(scene_.volumes[volume], ray_of(volume, 1).at(t));
}

Vec3d RayMedia::emission(size_t volume, double t) const
{
    const auto& v = scene_.volumes[volume];
    return v.emission ? v.emission->sample3(ray_of(volume, 2).at(t)) : Vec3d(0);
}

Vec3d RayMedia::collided(size_t volume, double t) const
{
    const auto& v = scene_.volumes[volume];
    if (!v.phi) return Vec3d(0);
    const Vec3d p = ray_of(volume, 3).at(t), phi = v.phi->sample3(p);
    const auto& weights = weights_[volume];
    Vec3d sum;
    for (int c = 0; c < 3; ++c) {
        if (c > 0 && v.phi->channels() == 1) {
            sum[c] = sum[0];
            continue;
        }
        sum[c] = phi[c] / (4 * pi);
        if (v.flux[c]) {
            const Vec3d flux = v.flux[c]->sample3(ray_of(volume, size_t(4 + c)).at(t));
            sum[c] +=
                3 * v.scaling.mean_cosine() * shortening(v, phi[c], flux) * (-ray_.direction).dot(flux) / (4 * pi);
        }
        for (size_t k = 0; k < weights.size(); ++k)
            if (weights[k] != 0) sum[c] += weights[k] * v.moments[c][k]->sample(p);
    }
    return v.channel_scale * sum;
}

Vec3d RayMedia::extinction(size_t volume, const Vec3d& albedo) const
{
    const auto& v = scene_.volumes[volume];
    return v.scaling.delta_f == 0 ? v.sigma_t : v.sigma_t * (Vec3d(1) - v.scaling.delta_f * albedo);
}

double RayMedia::cosine(const Light& light, double t) const
{
    const Sight sight = light->towards(ray_.at(t));
    return sight.distance > 0 ? sight.direction.dot(ray_.direction) : 1;  // of -direction and -ray_.direction
}

Vec3d RayMedia::arriving(size_t light, size_t volume, double t0, double t1) const
{
    const Light& from = scene_.lights[light];
    const auto& points = scene_.points[light];
    double p = 0;
    for (const Light& point : points)
        p += scene_.volumes[volume].phase(std::clamp(cosine(point, (t0 + t1) / 2), -1.0, 1.0)) / double(points.size());
    return p * from.strength() * from->mean_irradiance(ray_, t0, t1);
}

Vec3d RayMedia::peak(size_t light, size_t volume, double t, const Vec3d& x) const
{
    const auto& v = scene_.volumes[volume];
    if (!v.peak) return Vec3d(1);
    const double c = cosine(scene_.lights[light], t);
    Vec3d ratio;
    for (int k = 0; k < 3; ++k) {
        const bool known = k > 0 && x[k] == x[0];
        ratio[k] = known ? ratio[0] : (*v.peak)(c, x[k]);
    }
    return ratio;
}

void RayResult::clear(size_t lights)
{
    direct.assign(lights, Vec3d(0));
    multiple = emission = ground = solid = tau = true_tau = Vec3d(0);
    hit.reset();
    half_way = to_ground = 1e30;
    cells = lit = ends = end_cells = further = 0;
    converged = true;
}

}  // namespace vdbcloud
