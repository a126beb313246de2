#include "vdbcloud/render/render_plan.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/render/plain_cells.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double pilot_rays = 1024;
constexpr int pilot_samples = 4;  // of light paths

double pixels_of(const Film& film) { return double(film.window().width()) * film.window().height(); }

double leaves_of(const openvdb::GridBase& grid)
{
    const auto tree = grid.constBaseTreePtr();
    return double(tree->leafCount());
}

/// Channels of a grid's map for rays.
int channels_of(const GridBasePtr& grid) { return !grid ? 0 : grid->isType<Vec3SGrid>() ? 3 : 1; }

/// What a volume's rays read beside its density, for collided light, colour and emission [values a point].
double values_a_point(const Volume& volume)
{
    double values = channels_of(volume.colour) + channels_of(volume.emission) + channels_of(volume.collided.phi);
    for (int c = 0; c < channels_of(volume.collided.phi); ++c)
        values += channels_of(volume.collided.flux[size_t(c)]) + double(volume.collided.moments[size_t(c)].size());
    return values;
}

double edge_of(const Scene& scene)
{
    double voxels = 0;
    for (const Volume& volume : scene.volumes) voxels += double(volume.density->activeVoxelCount());
    return std::cbrt(voxels);
}

/// Values of all maps that rays read: each brick has 9^3 corners. Light has a map of the density's blocks.
double map_values(const Scene& scene, const IntegratorOptions& o)
{
    const bool path = o.kind == Integrator::Path && o.vertices == 0;
    double values = 0;
    for (const Volume& volume : scene.volumes) {
        const double leaves = 1.14 * leaves_of(*volume.density);
        if (o.vertices > 0) values += 729 * leaves;  // density once for paths and once for their ends
        const double lights = path || o.shadow_rays ? 0 : double(scene.lights.size()) * (volume.medium.grey() ? 1 : 3);
        values += 729 * leaves * (1 + lights);
        for (const GridBasePtr& grid : {GridBasePtr(volume.colour), GridBasePtr(volume.emission)})
            if (grid) values += 729 * 3 * leaves_of(*grid);
        if (!path && volume.collided.phi)
            values +=
                729 * leaves * (values_a_point(volume) - channels_of(volume.colour) - channels_of(volume.emission));
    }
    return values;
}

/// The medium as rays meet it, without light.
Scene dark(const Scene& scene)
{
    Scene out = scene;
    out.lights.clear();
    out.ground.reset();
    out.ground_radiance = nullptr;
    for (Volume& volume : out.volumes) {
        volume.transmittance.clear();
        CollidedLight none;
        none.scaling = volume.collided.scaling;
        volume.collided = none;
    }
    return out;
}

/// The picture with fewer pixels, about pilot_rays of them in its window.
ImageSize pilot_size(const ImageSize& size)
{
    const PixelWindow w = size.window();
    const double scale = std::min(1.0, std::sqrt(pilot_rays / (double(w.width()) * w.height())));
    ImageSize pilot = size;
    pilot.width = std::max(1, int(std::lround(size.width * scale)));
    pilot.height = std::max(1, int(std::lround(size.height * scale)));
    pilot.pixel_aspect = size.pixel_aspect * size.width / size.height * pilot.height / pilot.width;
    const auto place = [&](int of, int most) { return std::clamp(int(std::floor(of * scale)), 0, most); };
    pilot.crop = {place(w.x0, pilot.width - 1), place(w.y0, pilot.height - 1), 0, 0};
    pilot.crop.x1 = std::max(pilot.crop.x0 + 1, place(w.x1, pilot.width));
    pilot.crop.y1 = std::max(pilot.crop.y0 + 1, place(w.y1, pilot.height));
    return pilot;
}

/// Events of rays that march through the media with their light.
void add_march(Workload& work, const Scene& scene, const IntegratorOptions& o, const RenderCost& cost)
{
    const auto cells = double(cost.cells), lit = double(cost.lit), lights = double(scene.lights.size());
    work.add("ray", double(cost.rays));
    double values = 0, scaled = 0;
    for (const Volume& volume : scene.volumes) {
        values += values_a_point(volume);
        scaled += volume.collided.phi && volume.collided.scaling.delta_f > 0;
    }
    if (is_plain(scene, o)) {
        work.add("plain_cell", cells);
        work.add("plain_light", lit * lights);
        work.add("plain_value", lit * values);
        work.add("plain_peak", lit * lights * (scaled > 0 ? 1 : 0));
        return;
    }
    if (o.kind == Integrator::Cells) {
        work.add("cell", cells);
        work.add("cell_light", lit * lights);
        work.add("cell_value", lit * values);
        work.add("cell_peak", lit * lights * (scaled > 0 ? 1 : 0));
    } else {
        work.add(o.kind == Integrator::Romberg ? "romberg_point" : "quadrature_point", cells * (1 + lights));
    }
    if (o.shadow_rays)
        work.add("shadow_cell", (o.kind == Integrator::Cells ? 2 * lit : cells) * lights * edge_of(scene));
}

}  // namespace

Workload render_work(const Film& film, const Scene& scene, const IntegratorOptions& o, const RenderCost& cost)
{
    Workload work;
    work.add("film_value", pixels_of(film) * film.channels());
    work.add("brick_value", map_values(scene, o));
    if (o.kind == Integrator::Path) {
        const auto cells = double(cost.cells), lights = double(scene.lights.size());
        work.add("path_ray", double(cost.rays));
        work.add("path_collision", cells);
        const auto lamps = double(std::count_if(scene.lights.begin(), scene.lights.end(),
                                                [](const Light& light) { return !light->common_direction(); }));
        work.add("path_lamp_cell", cells * lamps * edge_of(scene));
        work.add("path_cell", cells * (lights + (scene.sky.dark() ? 0 : 1)) * edge_of(scene));
        if (o.vertices > 0) {
            RenderCost ends;
            ends.rays = cost.ends;
            ends.cells = cost.end_cells;
            ends.lit = cost.lit;
            add_march(work, scene, IntegratorOptions(), ends);
        }
        return work;
    }
    add_march(work, scene, o, cost);
    return work;
}

RenderCost expected_cost(const Film& film, const Scene& scene, const CameraView& view, const SamplingOptions& sampling,
                         const IntegratorOptions& o)
{
    const bool path = o.kind == Integrator::Path;
    // Paths follow the light, and Romberg's rule has more points where light changes.
    const Scene seen = path || o.kind == Integrator::Romberg ? scene : dark(scene);
    const ImageSize size = pilot_size(view.size());
    Film pilot(size, render_layers(seen, {}, o.kind));
    SamplingOptions few = sampling;
    few.samples = path ? pilot_samples : 1;
    IntegratorOptions options = o;
    options.shadow_rays = false;
    options.passes.noise = options.passes.time_limit = 0;
    // A series of which a run makes the light: whole paths are the most that such paths cost.
    for (const Volume& volume : seen.volumes)
        if (!volume.collided.phi) options.vertices = 0;
    const RenderCost found = render_image(pilot, seen, CameraView(view.camera(), size), few, options);
    auto samples = double(sampling.samples);
    if (path && o.passes.noise > 0) {
        const double ratio = found.passes.noise / o.passes.noise;
        samples = std::min(samples, std::max(16.0, pilot_samples * ratio * ratio));
    }
    const PixelWindow w = pilot.window();
    const double of_camera = path ? double(found.rays) : double(w.width()) * w.height() * few.samples;
    const double more = pixels_of(film) * samples / std::max(1.0, of_camera);
    RenderCost cost;
    cost.rays = uint64_t(more * double(found.rays));
    cost.cells = uint64_t(more * double(found.cells));
    cost.lit = uint64_t(more * double(found.lit));
    cost.ends = uint64_t(more * double(found.ends));
    cost.end_cells = uint64_t(more * double(found.end_cells));
    return cost;
}

double render_bytes(const Film& film, const Scene& scene, const IntegratorOptions& o)
{
    const double sums = o.kind == Integrator::Path ? 8.0 * (film.channels() + 7) : 0;  // and spreads, in double
    return 4 * map_values(scene, o) + pixels_of(film) * (sums + 4.0 * film.channels());
}

}  // namespace vdbcloud
