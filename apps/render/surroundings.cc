#include "surroundings.h"

#include "inputs.h"
#include "sky_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/sources.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// Throws if the sky that lit a file's medium stands over another axis than the picture's.
void require_same_up(const GridFile& file, const std::optional<Sky>& lit_by, UpAxis up)
{
    if (!lit_by || lit_by->uniform() || lit_by->up().dot(vector_of(up)) > 1 - 1e-6) return;
    throw UsageError(file.path + ": multiple scattering was computed under a sky over the axis " +
                     app::brief(lit_by->up()) + ", and " + up_axis_words.word(up) +
                     " is up here: run p1solve again with --up, or give --up here");
}

/// Whether emission or a sky that was asked for lights the scene, as p1solve judges it.
bool glows_by_itself(const Scene& scene, const RenderOptions& o)
{
    return app::sky_asked(o.sky) || std::any_of(scene.volumes.begin(), scene.volumes.end(),
                                                [](const Volume& volume) { return bool(volume.emission); });
}

}  // namespace

UpAxis up_of(app::App& app, const RenderOptions& o, std::vector<GridFile>& files)
{
    if (o.up) return *o.up;
    for (const GridFile& file : files)
        if (const auto says = read_up_axis(*file.metadata)) return *says;
    return app::settled_up(app, {}, files.front(), true);
}

void choose_sky(const RenderOptions& o, const std::vector<GridFile>& files, LoadedScene& out)
{
    for (const GridFile& file : files)
        if (const auto phi = fluence_grid(file)) {
            const auto lit_by = app::of_file(file.path, [&] { return read_sky(*phi, &file); });
            if (shows_light_grids(o)) require_same_up(file, lit_by, out.up);
            if (!out.sky) out.sky = lit_by;
        }
}

void choose_ground(const RenderOptions& o, const std::vector<GridFile>& files, LoadedScene& out)
{
    std::optional<double> albedo;
    if (o.option.ground.given()) albedo = o.ground_albedo;
    for (const GridFile& file : files) {
        const GridBasePtr phi = fluence_grid(file);
        const auto stored = app::of_file(file.path, [&] { return phi ? read_ground(*phi) : std::nullopt; });
        if (!stored || albedo) continue;
        albedo = stored;
        if (!shows_light_grids(o)) continue;
        const Vec3d up = get_vector(*phi, schema::lit_sky_up, vector_of(out.up));
        if (up.unit().dot(vector_of(out.up)) < 1 - 1e-6)
            throw UsageError(file.path + ": multiple scattering was computed over a ground across the axis " +
                             app::brief(up) + ", and " + up_axis_words.word(out.up) +
                             " is up here: run p1solve again with --up, or give --up here");
        out.scene.ground_radiance = openvdb::gridPtrCast<Vec3SGrid>(find_grid(file, schema::ground_radiance));
        if (!out.scene.ground_radiance)
            throw UsageError(file.path + ": multiple scattering was computed over a ground, and the grid '" +
                             schema::ground_radiance + "' is missing: run p1solve again");
    }
    if (!albedo) return;
    std::vector<const FloatGrid*> densities;
    for (const Volume& volume : out.scene.volumes) densities.push_back(volume.density.get());
    out.scene.ground = ground_beneath(densities, vector_of(out.up), *albedo);
}

void choose_lights(app::App& app, const RenderOptions& o, const std::vector<GridFile>& files, LoadedScene& out)
{
    out.lights = app::lights_asked(o.lights, vector_of(out.up));
    if (out.lights.empty()) out.lights = app::inherited_lights(app::lights_found(files));
    for (const GridFile& file : files)
        if (has_meta(*file.metadata, schema::multiple_left_out) &&
            app::lights_asked(o.lights, vector_of(out.up)).empty())
            out.left_out_before = get_number(*file.metadata, schema::multiple_left_out, 0);
    // A medium with phi is visible without a sun, and one that p1solve has found dark is dark.
    const bool glows =
        out.left_out_before ||
        std::any_of(files.begin(), files.end(), [](const GridFile& f) { return bool(fluence_grid(f)); }) ||
        ((!shows_light_grids(o) || o.multiple) && glows_by_itself(out.scene, o));
    if (!out.lights.empty() || glows) return;
    out.lights.push_back(app::automatic_sun(vector_of(out.up)));
    out.automatic_light = true;
    app.say("no light given: " + app::described(out.lights[0]) + ", irradiance " +
            app::brief(out.lights[0].strength()[0]));
}

}  // namespace vdbcloud
