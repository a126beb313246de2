#include "vdbcloud/render/media.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/render/cell_rule.h"
#include "vdbcloud/render/free_path.h"
#include "vdbcloud/render/plain_cells.h"
#include "vdbcloud/voxels/extend.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

constexpr size_t maps_before_lights = 7;

float depth_of(float transmittance)
{
    // A stored 0 is an underflow of float: depth 103 or more.
    return transmittance > 0 ? -std::log(transmittance) : 104.0f;
}

/// One period of a volume's medium, for each of the volume's grids.
struct Repeat {
    Period period;
    const Transform& of;

    Period in(const GridBase& grid) const { return period_in(period, of, grid); }
};

BrickMap light_depth_map(const GridBasePtr& grid, const Repeat& repeat)
{
    if (const auto grey = openvdb::gridPtrCast<openvdb::FloatGrid>(grid))
        return BrickMap(*grey, 0, depth_of, repeat.in(*grey));
    if (const auto coloured = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid))
        return BrickMap(*coloured, 0, depth_of, repeat.in(*coloured));
    throw InputError("grid '" + printable(grid->getName()) + "': a transmittance of type " + grid->valueType() +
                     ": expected float or vec3s");
}

std::unique_ptr<BrickMap> map_of(const Vec3SGridPtr& grid, float outside, const Repeat& repeat)
{
    return grid ? std::make_unique<BrickMap>(*grid, outside, BrickMap::Map(), repeat.in(*grid)) : nullptr;
}

/// Extends collided light, stored in active voxels, over the trilinear fringe: the medium extends up to one voxel
/// beyond its active voxels.
template<typename GridPtr>
std::unique_ptr<BrickMap> fringe_map(const GridPtr& grid, const Repeat& repeat)
{
    if (!grid) return nullptr;
    const Period period = repeat.in(*grid);
    return std::make_unique<BrickMap>(*with_fringe(*grid, period), 0.0f, BrickMap::Map(), period);
}

/// The largest channel of a grid; rays visit only the cells in which it is nonzero.
/// Throws InputError for emission that reaches beyond the period of the density.
BrickMap extent_of(const Vec3SGrid& grid, const Repeat& repeat)
{
    const Period period = repeat.in(grid);
    auto largest = openvdb::FloatGrid::create(0.0f);
    largest->setTransform(grid.transform().copy());
    for (auto v = grid.cbeginValueOn(); v; ++v) {
        const auto value = std::max({std::abs((*v)[0]), std::abs((*v)[1]), std::abs((*v)[2])});
        openvdb::CoordBBox box;
        v.getBoundingBox(box);
        largest->fill(box, value);
        for (int a = 0; a < 3 && value > 0; ++a) {
            const int first = period.first[a], last = first + period.length[a] - 1;
            if (period.length[a] > 0 && (box.min()[a] < first || box.max()[a] > last))
                throw InputError("grid '" + printable(grid.getName()) + "': emission beyond the period " +
                                 std::to_string(first) + " to " + std::to_string(last) + " of the density along " +
                                 "xyz"[a] + ": expected it within");
        }
    }
    return BrickMap(*largest, 0, {}, period);
}

/// Throws InputError unless the moments are whole degrees, the same for each channel, that the scaling covers.
int degree_of(const CollidedLight& light)
{
    const auto& [r, g, b] = light.moments;
    const int count = int(r.size());
    int degree = 1;
    while (harmonic_count(degree) - harmonic_count(1) < count) ++degree;
    if (degree > light.scaling.degree)
        throw InputError("moments of degree " + std::to_string(degree) + ": expected at most " +
                         std::to_string(light.scaling.degree) + ", that of the delta scaling");
    if (harmonic_count(degree) - harmonic_count(1) != count || g.size() != r.size() || b.size() != r.size())
        throw InputError(std::to_string(count) +
                         " moments of degree 2 and more: expected whole degrees, the same for each channel");
    return degree;
}

void add_scales(const CollidedLight& light, PreparedVolume& prepared)
{
    prepared.degree = degree_of(light);
    prepared.channel_scale = light.channel_scale;
    prepared.flux_limit = light.flux_limit;
}

void add_collided(const CollidedLight& light, const Repeat& repeat, PreparedVolume& prepared)
{
    const auto one = openvdb::gridPtrCast<openvdb::FloatGrid>(light.phi);
    prepared.phi =
        one ? fringe_map(one, repeat) : fringe_map(openvdb::gridPtrCast<openvdb::Vec3SGrid>(light.phi), repeat);
    for (size_t c = 0; c < (one ? 1u : 3u); ++c) {
        if (light.scaling.mean_cosine() != 0) prepared.flux[c] = fringe_map(light.flux[c], repeat);
        for (const auto& moment : light.moments[c]) prepared.moments[c].push_back(fringe_map(moment, repeat));
    }
}

bool same_channels(const Vec3d& v) { return v[0] == v[1] && v[1] == v[2]; }

/// Whether all channels attenuate alike: the scaled medium's extinction depends on the albedo.
bool extinction_is_grey(const Volume& volume)
{
    if (!volume.medium.grey()) return false;
    return volume.collided.scaling.delta_f == 0 || (same_channels(volume.medium.albedo) && !volume.colour);
}

/// The distance from a lamp within which depth comes from rays: 8 voxels of the coarsest medium. 0 where the extinction
/// differs from place to place by more than density, which rays do not know.
double near_of(const Scene& scene)
{
    double edge = 0;
    for (const Volume& volume : scene.volumes) {
        if (volume.colour && volume.collided.scaling.delta_f > 0) return 0;
        for (int a = 0; a < 3; ++a) {
            const Affine world = world_from_index(volume.density->transform(), volume.density->getName());
            edge = std::max(edge, world.vector(Vec3d(a == 0, a == 1, a == 2)).length());
        }
    }
    return 8 * edge;
}

/// The factor that brings a flux down to flux_limit x phi; 1 for a shorter one.
double shortening(const PreparedVolume& volume, double phi, const Vec3d& flux)
{
    if (volume.flux_limit == 0) return 1;
    const double longest = volume.flux_limit * std::max(phi, 0.0), length = flux.length();
    return length > longest ? longest / length : 1;
}

/// Throws InputError for a scene that cannot repeat: no axis that ends, a light within the medium or along its axes, or
/// volumes whose periods differ.
void check_periodic(const Scene& scene)
{
    if (scene.periodic == std::array<bool, 3>{}) return;
    if (scene.periodic == std::array<bool, 3>{true, true, true})
        throw InputError("a medium that is periodic along x, y and z: expected an axis along which it ends");
    std::optional<std::array<Vec3d, 3>> expected;
    for (const Volume& volume : scene.volumes) {
        const FloatGrid& density = *volume.density;
        const Transform& transform = density.transform();
        for (const Light& light : scene.lights)
            require_light_that_leaves(light, index_from_world(transform, density.getName()), scene.periodic);
        const Period period = period_of(density, scene.periodic);
        if (!period.any()) {
            if (!volume.emission) continue;
            throw InputError("a volume of emission without density: in a periodic scene the density gives the period");
        }
        std::array<Vec3d, 3> steps;
        for (int a = 0; a < 3; ++a)
            steps[size_t(a)] = world_from_index(transform, density.getName())
                                   .vector(Vec3d(a == 0, a == 1, a == 2) * double(period.length[a]));
        if (!expected) expected = steps;
        for (size_t a = 0; a < 3; ++a)
            if ((steps[a] - (*expected)[a]).length() > 1e-6 * steps[a].length())
                throw InputError("volumes that repeat after " + std::to_string((*expected)[a].length()) + " and " +
                                 std::to_string(steps[a].length()) + " along " + "xyz"[a] +
                                 ": expected equal periods in one direction");
    }
}

}  // namespace

PreparedScene::PreparedScene(const Scene& scene, const IntegratorOptions& options)
    : repeats(scene.periodic != std::array<bool, 3>{}), lights(scene.lights), shadow_rays(options.shadow_rays)
{
    check_periodic(scene);
    for (const Light& light : lights) {
        points.push_back(light.points(disc_directions));
        const auto source = light->source();
        lamp.push_back(source ? std::optional(source->position) : std::nullopt);
    }
    near = near_of(scene);
    for (const auto& volume : scene.volumes) {
        const Repeat repeat{period_of(*volume.density, scene.periodic), volume.density->transform()};
        auto& prepared = volumes.emplace_back(BrickMap(*volume.density, 0, {}, repeat.period));
        prepared.sigma_t = volume.medium.sigma_t_per_density;
        prepared.albedo = volume.medium.albedo;
        prepared.phase = volume.medium.phase;
        prepared.scaling = volume.collided.scaling;
        scaled = scaled || volume.collided.scaling.delta_f != 0;
        prepared.colour = map_of(volume.colour, 1, repeat);
        if (volume.collided.phi) add_scales(volume.collided, prepared);
        if (volume.collided.phi && volume.collided.scaling.delta_f > 0)
            prepared.peak = std::make_unique<ForwardPeak>(volume.medium.phase, volume.collided.scaling);
        grey = grey && extinction_is_grey(volume);
        if (!shadow_rays && volume.transmittance.size() != lights.size())
            throw InputError("a volume has " + std::to_string(volume.transmittance.size()) +
                             " transmittance grids: expected one for each of " + std::to_string(lights.size()) +
                             " lights");
        if (is_plain(scene, options) && add_plain_fields(volume, depth_of, prepared)) continue;
        if (volume.collided.phi) add_collided(volume.collided, repeat, prepared);
        if (!shadow_rays)
            for (const auto& t : volume.transmittance) {
                prepared.light_depth.push_back(std::make_unique<BrickMap>(light_depth_map(t, repeat)));
                grey = grey && prepared.light_depth.back()->channels() == 1;
            }
        if (volume.emission)
            volumes.emplace_back(extent_of(*volume.emission, repeat)).emission = map_of(volume.emission, 0, repeat);
    }
}

Vec3d albedo_at(const PreparedVolume& volume, const Vec3d& colour_index)
{
    if (!volume.colour) return volume.albedo;
    Vec3d a = volume.albedo * volume.colour->sample3(colour_index);
    for (int c = 0; c < 3; ++c) a[c] = std::clamp(a[c], 0.0, 1.0);
    return a;
}

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
        const auto& map = scene_.volumes[n].density;
        double in = 0, out = std::numeric_limits<double>::infinity();
        if (!clip(index_ray(n), map, in, out)) continue;
        t0 = std::min(t0, in);
        t1 = std::max(t1, out);
    }
    if (scene_.repeats) t1 = std::min(t1, end());
    return t0 < t1;
}

double RayMedia::end() const
{
    double t = std::numeric_limits<double>::infinity();
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
    for (size_t k = 0; k < points.size(); ++k)
        for (size_t n = 0; n < scene_.volumes.size(); ++n) {
            const auto& v = scene_.volumes[n];
            depth[k] += extinction(n, v.albedo) * depth_to_light(v.density, *points[k], ray_.at(t));
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

Vec3d RayMedia::peak(size_t light, size_t volume, double t, const Vec3d& albedo, const Vec3d& y) const
{
    const auto& v = scene_.volumes[volume];
    if (!v.peak) return Vec3d(1);
    const double c = cosine(scene_.lights[light], t);
    Vec3d ratio;
    for (int k = 0; k < 3; ++k) {
        const bool known = k > 0 && albedo[k] == albedo[0] && y[k] == y[0];
        ratio[k] = known ? ratio[0] : (*v.peak)(c, albedo[k] * y[k] / v.scaling.extinction(albedo[k]));
    }
    return ratio;
}

void RayResult::clear(size_t lights)
{
    direct.assign(lights, Vec3d(0));
    multiple = emission = ground = tau = true_tau = Vec3d(0);
    half_way = to_ground = 1e30;
    cells = lit = 0;
    converged = true;
}

}  // namespace vdbcloud
