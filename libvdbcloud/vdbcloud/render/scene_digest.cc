#include "vdbcloud/render/scene_digest.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/panorama.h"

namespace vdbcloud {

namespace {

void add(Digest& digest, const Vec3d& v)
{
    for (int c = 0; c < 3; ++c) digest.add_value(v[c]);
}

void add(Digest& digest, const Sky& sky)
{
    digest.add_text(sky.kind().word);
    add(digest, sky.up());
    for (const Vec3d& parameter : sky.parameters()) add(digest, parameter);
    if (sky.map()) digest.add_text(sky.map()->digest());
}

void add(Digest& digest, const Vec3SGridPtr& grid)
{
    digest.add_value(bool(grid));
    if (!grid) return;
    for (const Vec3d& corner : {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)})
        add(digest, grid->indexToWorld(corner));
    for (auto v = grid->cbeginValueOn(); v; ++v) {
        const openvdb::CoordBBox box = [&] {
            openvdb::CoordBBox covered;
            v.getBoundingBox(covered);
            return covered;
        }();
        digest.add_value(box.min());
        digest.add_value(box.max());
        digest.add_value(*v);
    }
}

void add(Digest& digest, const Volume& volume)
{
    digest.add_text(grid_digest(*volume.density));
    const Medium& medium = volume.medium;
    add(digest, medium.sigma_t_per_density);
    add(digest, medium.albedo);
    digest.add_text(medium.phase.name());
    for (const double parameter : medium.phase.parameters()) digest.add_value(parameter);
    add(digest, volume.colour);
    add(digest, volume.emission);
}

void add_grid(Digest& digest, const GridBasePtr& grid)
{
    if (const auto one = openvdb::gridPtrCast<FloatGrid>(grid))
        digest.add_text(grid_digest(*one));
    else
        add(digest, openvdb::gridPtrCast<Vec3SGrid>(grid));
}

/// The grids of light that the picture without noise shows.
void add_light(Digest& digest, const Volume& volume)
{
    for (const GridBasePtr& grid : volume.transmittance) add_grid(digest, grid);
    const CollidedLight& light = volume.collided;
    add_grid(digest, light.phi);
    for (size_t c = 0; c < 3; ++c) {
        add(digest, light.flux[c]);
        for (const FloatGridPtr& moment : light.moments[c]) add_grid(digest, moment);
    }
    add(digest, light.channel_scale);
    digest.add_value(light.flux_limit);
    digest.add_value(light.scaling.delta_f);
    for (const double moment : light.scaling.moments) digest.add_value(moment);
}

void add(Digest& digest, const Light& light)
{
    digest.add_text(light.name);
    digest.add_text(light.kind().word);
    add(digest, light.place());
    for (const Vec3d& parameter : light.parameters()) add(digest, parameter);
}

void add(Digest& digest, const CameraView& view)
{
    const ImageSize& size = view.size();
    digest.add_value(size.width);
    digest.add_value(size.height);
    digest.add_value(size.pixel_aspect);
    for (const double x : {0.0, double(size.width)})
        for (const double y : {0.0, double(size.height)}) {
            const WorldRay ray = view.ray(x, y);
            add(digest, ray.origin);
            add(digest, ray.direction);
        }
}

}  // namespace

std::string scene_digest(const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                         const IntegratorOptions& options)
{
    Digest digest;
    for (const Volume& volume : scene.volumes) add(digest, volume);
    // Parts of one picture from before media could repeat still merge.
    if (scene.periodic != std::array<bool, 3>{}) digest.add_text(periodic_text(scene.periodic));
    for (const Light& light : scene.lights) add(digest, light);
    if (scene.ground) {
        digest.add_value(scene.ground->albedo);
        add(digest, scene.ground->point);
        add(digest, scene.ground->up);
    }
    if (!scene.solids.empty()) digest.add_text(solids_digest(scene.solids, true));
    add(digest, scene.sky);
    add(digest, scene.background);
    add(digest, view);
    digest.add_text(name(sampling.filter));
    digest.add_value(sampling.filter_width);
    digest.add_value(options.passes.over_background);
    if (options.vertices > 0) {
        digest.add_value(options.vertices);
        for (const Volume& volume : scene.volumes) add_light(digest, volume);
        add(digest, scene.ground_radiance);
    }
    return digest.hex();
}

}  // namespace vdbcloud
