#include "vdbcloud/render/media.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/channels.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/render/plain_cells.h"
#include "vdbcloud/voxels/extend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace vdbcloud {

namespace {

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

/// The same where the light is seen; 0 where it is hidden.
float depth_where_seen(float transmittance) { return transmittance > 0 ? -std::log(transmittance) : 0.0f; }

float seen(float transmittance) { return transmittance > 0 ? 1.0f : 0.0f; }

BrickMap mapped(const GridBasePtr& grid, float outside, const BrickMap::Map& map, const Repeat& repeat)
{
    if (const auto grey = openvdb::gridPtrCast<openvdb::FloatGrid>(grid))
        return BrickMap(*grey, outside, map, repeat.in(*grey));
    if (const auto coloured = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid))
        return BrickMap(*coloured, outside, map, repeat.in(*coloured));
    throw InputError("grid '" + printable(grid->getName()) + "': a transmittance of type " + grid->valueType() +
                     ": expected float or vec3s");
}

template<typename GridT>
bool any_zero(const GridT& grid)
{
    for (auto v = grid.cbeginValueOn(); v; ++v)
        if (*v == typename GridT::ValueType(0.0f)) return true;
    return false;
}

/// Whether a light is hidden from some voxel.
bool hides(const GridBasePtr& grid)
{
    if (const auto grey = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return any_zero(*grey);
    if (const auto coloured = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid)) return any_zero(*coloured);
    return false;
}

bool any_hidden(const Volume& volume)
{
    return std::any_of(volume.transmittance.begin(), volume.transmittance.end(), hides);
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

/// The cells that active voxels are corners of, along axes that do not repeat.
void add_box(const GridBase& grid, PreparedVolume& volume)
{
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) return;
    volume.first_cell = Vec3i(box.min().asVec3i()) - Vec3i(1);
    volume.last_cell = Vec3i(box.max().asVec3i());
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

/// Maps of grids that several volumes may have.
class SharedMaps {
public:
    /// make(), once for each grid; null for null.
    template<typename Make>
    std::shared_ptr<const BrickMap> of(const GridBase* grid, const Make& make)
    {
        if (!grid) return nullptr;
        std::shared_ptr<const BrickMap>& map = maps_[grid];
        if (!map) map = make();
        return map;
    }

private:
    std::map<const GridBase*, std::shared_ptr<const BrickMap>> maps_;
};

void add_collided(const CollidedLight& light, const Repeat& repeat, SharedMaps& maps, PreparedVolume& prepared)
{
    const auto one = openvdb::gridPtrCast<openvdb::FloatGrid>(light.phi);
    const auto fringe = [&](const auto& grid) { return maps.of(grid.get(), [&] { return fringe_map(grid, repeat); }); };
    prepared.phi = one ? fringe(one) : fringe(openvdb::gridPtrCast<openvdb::Vec3SGrid>(light.phi));
    for (size_t c = 0; c < (one ? 1u : 3u); ++c) {
        if (light.scaling.mean_cosine() != 0) prepared.flux[c] = fringe(light.flux[c]);
        for (const auto& moment : light.moments[c]) prepared.moments[c].push_back(fringe(moment));
    }
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
    if (!scene.solids.empty()) solids = std::make_shared<SolidRays>(scene.solids);
    SharedMaps maps;
    for (const auto& volume : scene.volumes) {
        const Repeat repeat{period_of(*volume.density, scene.periodic), volume.density->transform()};
        auto& prepared = volumes.emplace_back(BrickMap(*volume.density, 0, {}, repeat.period));
        add_box(*volume.density, prepared);
        prepared.sigma_t = volume.medium.sigma_t_per_density;
        prepared.albedo = volume.medium.albedo;
        prepared.phase = volume.medium.phase;
        prepared.scaling = volume.collided.scaling;
        scaled = scaled || volume.collided.scaling.delta_f != 0;
        prepared.colour = map_of(volume.colour, 1, repeat);
        if (volume.collided.phi) add_scales(volume.collided, prepared);
        if (volume.collided.phi && volume.collided.scaling.delta_f > 0)
            prepared.peak = std::make_unique<ForwardPeak>(volume.medium.phase, volume.collided.scaling);
        grey = grey && grey_extinction(volume.medium, bool(volume.colour), volume.collided.scaling.delta_f);
        if (!shadow_rays && volume.transmittance.size() != lights.size())
            throw InputError("a volume has " + std::to_string(volume.transmittance.size()) +
                             " transmittance grids: expected one for each of " + std::to_string(lights.size()) +
                             " lights");
        const bool shadows = solids && any_hidden(volume);
        if (is_plain(scene, options) && !shadows && add_plain_fields(volume, depth_of, prepared)) continue;
        if (volume.collided.phi) add_collided(volume.collided, repeat, maps, prepared);
        if (!shadow_rays)
            for (const auto& t : volume.transmittance) {
                const bool hidden = shadows && hides(t);
                prepared.light_depth.push_back(maps.of(t.get(), [&] {
                    return std::make_shared<const BrickMap>(mapped(t, 0, hidden ? depth_where_seen : depth_of, repeat));
                }));
                prepared.seen.push_back(hidden ? std::make_unique<BrickMap>(mapped(t, 1, seen, repeat)) : nullptr);
                grey = grey && prepared.light_depth.back()->channels() == 1;
            }
        if (volume.emission) {
            auto& emitting = volumes.emplace_back(extent_of(*volume.emission, repeat));
            emitting.emission = map_of(volume.emission, 0, repeat);
            add_box(*volume.emission, emitting);
        }
    }
}

Vec3d albedo_at(const PreparedVolume& volume, const Vec3d& colour_index)
{
    if (!volume.colour) return volume.albedo;
    Vec3d a = volume.albedo * volume.colour->sample3(colour_index);
    for (int c = 0; c < 3; ++c) a[c] = std::clamp(a[c], 0.0, 1.0);
    return a;
}

}  // namespace vdbcloud
