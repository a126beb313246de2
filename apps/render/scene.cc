#include "scene.h"

#include "effects.h"
#include "inputs.h"
#include "multiple.h"
#include "overlap.h"
#include "periodic_option.h"
#include "scaled_light.h"
#include "shared_light.h"
#include "surroundings.h"
#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/memory.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/accuracy.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/extent.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/optics/mixture.h"
#include "vdbcloud/scatter/scatter_plan.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>
#include <set>

namespace vdbcloud {

namespace {

/// A file without a medium shows its solids.
bool holds_solids_alone(const GridFile& file, const RenderOptions& o)
{
    return o.density.empty() && !file.grids.empty() &&
           std::all_of(file.grids.begin(), file.grids.end(),
                       [](const GridBasePtr& grid) { return schema::has_role(grid->getName(), schema::Role::Solid); });
}

Volume volume_of(app::App& app, GridFile& file, const RenderOptions& o)
{
    Volume volume;
    volume.density =
        holds_solids_alone(file, o) ? FloatGrid::create(0.0f) : density_of(file, o.density, app.warnings());
    const Fire fire = app::fire_of(app, file, o.medium.fire);
    volume.medium = app::chosen_medium(app, o.medium, *volume.density, fire.heat());
    volume.colour = app::vector_grid(app, file, grid_of(file, schema::colour));
    volume.emission = app::emission_of(app, file, fire, *volume.density, volume.medium, volume.colour.get());
    if (!shows_light_grids(o) || !is_asked(app::effects_asked(o.effects), Effect::Multiple)) return volume;
    volume.collided = read_collided_light(file, volume.medium.phase, app.warnings());
    const GridBasePtr& phi = volume.collided.phi;
    if (const GridBasePtr series = find_grid(file, schema::series_phi_name(0));
        series && (!phi || read_medium(*phi).albedo != volume.medium.albedo)) {
        volume.collided = {};  // relight_volume() makes it from the series
        volume.collided.scaling = read_delta_scaling(*series, volume.medium.phase);
    }
    if (phi && !is_mixture(*phi)) app::require_same_medium(file.path + ": multiple scattering", *phi, volume.medium);
    return volume;
}

Sources sources_behind(const Volume& volume)
{
    return sources_of(*volume.density, volume.colour.get(), volume.emission.get());
}

/// Throws if multiple scattering was computed for a medium that repeats otherwise than the scene.
void require_same_period(const GridFile& file, const app::Axes& periodic)
{
    for (const GridBasePtr& grid : {fluence_grid(file), find_grid(file, schema::series_phi_name(0))})
        if (grid && read_periodic(*grid) != periodic)
            throw UsageError(file.path + ": multiple scattering was computed for a medium periodic along " +
                             periodic_text(read_periodic(*grid)) + ", and --periodic " + periodic_text(periodic) +
                             " is asked for: run p1solve again");
}

/// Throws if phi is of another density, Cd or emission, or scattered other lights than the scene has.
void require_same_light(const GridFile& file, const Overlap& overlap, const Scene& scene)
{
    const Volume& volume = scene.volumes[overlap.first];
    const std::vector<Light>& lights = scene.lights;
    if (!volume.collided.phi) return;
    if (get_text(*volume.collided.phi, schema::solids, "") != solids_digest(scene.solids, /*materials=*/true))
        throw UsageError(file.path + ": multiple scattering was computed beside other solids: run p1solve again with "
                                     "these");
    const std::string changed =
        changed_source(*volume.collided.phi, overlap.several() ? sources_of(overlap.parts(scene), volume.emission.get())
                                                               : sources_behind(volume));
    if (!changed.empty())
        throw UsageError(file.path + ": multiple scattering was computed from another " + changed +
                         " than the file holds now: run p1solve again");
    if (const auto lit_by = other_lights(*volume.collided.phi, lights))
        throw UsageError(file.path + ": multiple scattering was computed for '" + printable(*lit_by) + "', and '" +
                         lights_text(lights) + "' is asked for: run p1solve again");
}

/// Why a transmittance grid of the input cannot be used for `light`; empty if it can.
std::string misfit(const GridBase& grid, const Light& light, const Volume& volume, const Scene& scene)
{
    const app::Axes& periodic = scene.periodic;
    const auto found = read_light(grid, grid.getName());
    if (!found) return "has no metadata of its light";
    if (const auto axes = read_periodic(grid); axes != periodic)
        return "belongs to a medium periodic along " + periodic_text(axes) + ", now " + periodic_text(periodic);
    if (!same_place(*found, light)) return "belongs to the " + app::described(*found);
    if (!app::same_extinction(grid, volume.medium))
        return "was computed with extinction " + app::brief(get_vector(grid, schema::sigma_t_per_density, Vec3d(0.0))) +
               ", now " + app::brief(volume.medium.sigma_t_per_density);
    if (get_text(grid, schema::solids, "") != solids_digest(scene.solids, /*materials=*/false))
        return "was computed beside other solids";
    const std::string digest = get_text(grid, schema::density_digest, "");
    if (digest.empty()) return "has no fingerprint of its density";
    return digest == grid_digest(*volume.density) ? "" : "was computed from another density";
}

/// The grid stands for a light that added nothing in an earlier stage, and has no values.
bool is_unlit(const GridBase& grid, const Volume& volume)
{
    return grid.activeVoxelCount() == 0 && volume.density->activeVoxelCount() > 0;
}

/// True if the inputs have a usable transmittance grid for each light.
bool brings_all(const std::vector<GridFile>& files, const Scene& scene)
{
    if (has_several_media(scene)) return false;
    for (size_t v = 0; v < files.size(); ++v)
        for (const Light& light : scene.lights) {
            const Volume& volume = scene.volumes[v];
            const GridBasePtr grid = volume.collided.scaling.delta_f > 0 ? nullptr : grid_of_light(files[v], light);
            if (!grid || is_unlit(*grid, volume) || !misfit(*grid, light, volume, scene).empty()) return false;
        }
    return true;
}

/// In place of a grid that a run would compute, whose plan is added to `planned`.
GridBasePtr planned_grid(const Volume& volume, const Light& light, const RenderOptions& o, TransmittancePlan& planned)
{
    const TransmittancePlan plan = transmittance_plan(*volume.density, volume.medium, light, o.light, true);
    planned.work += plan.work;
    planned.bytes = std::max(planned.bytes, planned.grid_bytes + plan.bytes);
    planned.grid_bytes += plan.grid_bytes;
    return FloatGrid::create(1.0f);
}

/// The transmittance grid of volume `v` towards a light: the input's if that is usable, else computed, through all
/// media where there are several. A dry run computes none.
GridBasePtr light_grid(app::App& app, const GridFile& file, LoadedScene& loaded, const Overlap& overlap, size_t v,
                       const Light& light, const RenderOptions& o)
{
    const Scene& scene = loaded.scene;
    const Volume& volume = scene.volumes[v];
    TransmittancePlan& planned = loaded.planned;
    if (overlap.several() && volume.collided.phi) {
        if (app.dry_run()) return planned_grid(volume, light, o, planned);
        return overlap_light(app, file, overlap, scene, light, o.light);
    }
    if (volume.collided.scaling.delta_f > 0) {
        if (app.dry_run()) return planned_grid(volume, light, o, planned);
        const auto phase = app.phase("scaled light");
        return app::scaled_light_grid(app, *volume.density, volume.colour.get(), volume.medium, volume.collided.scaling,
                                      light, o.light);
    }
    GridBasePtr own = grid_of_light(file, light);
    if (own && is_unlit(*own, volume)) own = nullptr;
    if (own)
        if (const std::string reason = misfit(*own, light, volume, scene); !reason.empty()) {
            app.warnings()(file.path + ": " + printable(own->getName()) + " " + reason +
                           "; the grid is computed again for the " + app::described(light));
            own = nullptr;
        }
    if (has_several_media(scene) && app.dry_run()) return planned_grid(volume, light, o, planned);
    if (has_several_media(scene)) return shared_light_grid(app, scene, v, light, own, o);
    if (own) return own;
    if (app.dry_run()) return planned_grid(volume, light, o, planned);
    const auto phase = app.phase("light");
    TransmittanceOptions options = o.light;
    options.error_samples = 0;
    TransmittanceReport found;
    const GridBasePtr grid =
        transmittance_grid(*volume.density, volume.medium, light, options, app.progress("light"), &found);
    app.add_work(found.work);
    return grid;
}

/// Sets the collided light of a volume without phi from the input's series in albedo, if the input has one.
void relight_volume(app::App& app, const GridFile& file, Volume& volume, const Scene& scene)
{
    const std::vector<Light>& lights = scene.lights;
    if (volume.collided.phi || !find_grid(file, schema::series_phi_name(0))) return;
    if (!scene.solids.empty())
        throw UsageError(file.path + ": its series in albedo knows no solids, and there is a " +
                         described(scene.solids.front()) + ": run p1solve again without --series");
    if (app.dry_run()) {  // without a solve, which the tolerance stands for
        ScatterOptions given;
        given.reentry_rays = 0;
        given.solve.tolerance = 0.5;
        app.add_work(
            scatter_plan(*volume.density, nullptr, volume.emission.get(), volume.medium, lights, given, true).work);
        return;
    }
    if (!has_series(file, sources_behind(volume), volume.medium, lights))
        throw UsageError(file.path +
                         ": its series was computed for another density, emission, medium or light: run p1solve again");
    const auto phase = app.phase("series");
    ScatterReport report;
    volume.collided = relight(file, *volume.density, volume.emission.get(), volume.medium, lights, {}, report);
    double error = 0;
    for (const ChannelReport& channel : report.channel) error = std::max(error, channel.solve.error);
    if (error > 0.01)
        app.warnings()(file.path + ": the series errs by " + app::brief(100 * error) + " % at albedo " +
                       app::shortest(volume.medium.albedo) +
                       ": run p1solve at this albedo, or a series of higher order");
}

/// Frees what no picture shows. Volumes hold their density, Cd and emission themselves.
void release_unused(GridFile& file)
{
    remove_grids(file, [](const std::string& name) {
        const schema::GridKind* kind = schema::kind_of(name);
        return !kind || !kind->kept;
    });
    give_back_free_memory();
}

/// Adds the volume of a file to the scene, and frees the file's other grids.
void load_volume(app::App& app, const RenderOptions& o, GridFile& file, LoadedScene& out)
{
    if (shows_light_grids(o)) app::of_file(file.path, [&] { require_same_period(file, out.scene.periodic); });
    out.paths.push_back(file.path);
    out.scene.volumes.push_back(app::of_file(file.path, [&] { return volume_of(app, file, o); }));
    auto corners = occupied_corners(*out.scene.volumes.back().density);
    if (const auto& emission = out.scene.volumes.back().emission) {
        const auto of_emission = occupied_corners(*emission);
        corners.insert(corners.end(), of_emission.begin(), of_emission.end());
    }
    if (corners.empty() && !holds_solids_alone(file, o))
        app.say(file.path + ": the density is empty and adds nothing to the picture");
    release_unused(file);
    out.corners.insert(out.corners.end(), corners.begin(), corners.end());
    const std::string history = get_text(*file.metadata, schema::history, "");
    if (!history.empty()) out.history += (out.history.empty() ? "" : "\n") + history;
}

/// The solids of options and files. They stand in the scene if their effect is `asked` for.
std::vector<Solid> load_solids(app::App& app, RenderOptions& o, const std::vector<GridFile>& files, bool asked,
                               LoadedScene& out)
{
    std::vector<const GridFile*> all;
    for (const GridFile& file : files) all.push_back(&file);
    const std::vector<Solid> solids = app::chosen_solids(app, o.solids, all, vector_of(out.up));
    if (asked) out.scene.solids = o.light.solids = solids;
    for (const Solid& solid : out.scene.solids)
        for (const Vec3d& corner : corners_of(solid)) out.corners.push_back(corner);
    o.option.solid_rays.check_effect(!out.scene.solids.empty(), "--solid");
    return solids;
}

/// Gives each volume a transmittance grid for each light of the scene.
void add_light_grids(app::App& app, const RenderOptions& o, const std::vector<GridFile>& files,
                     const std::vector<Overlap>& overlaps, LoadedScene& out)
{
    if (o.option.fidelity.given())
        o.option.fidelity.check_effect(!brings_all(files, out.scene), "a light that the input does not bring");
    o.option.fidelity.check_effect(out.scene.periodic == app::Axes{},
                                   "--periodic none: rays of a periodic medium are exact");
    for (const Overlap& overlap : overlaps)
        for (const Light& light : out.scene.lights) {
            GridBasePtr grid;
            for (size_t v = overlap.first; v < overlap.first + overlap.count; ++v) {
                // One grid of all media serves each, where light passes no medium of another file.
                if (v == overlap.first || overlaps.size() > 1) {
                    const EffectCosts::Timer timer(out.costs, Effect::Lights);
                    grid = app::of_file(files[v].path,
                                        [&] { return light_grid(app, files[v], out, overlap, v, light, o); });
                }
                out.scene.volumes[v].transmittance.push_back(grid);
            }
        }
}

}  // namespace

LoadedScene load_scene(app::App& app, RenderOptions& o)
{
    std::vector<GridFile> files = app::read_inputs(app, o.inputs, o.density, !o.up);
    app::check_fire(o.medium.fire, files);
    const EffectsAsked asked = checked_effects(o);
    end_paths_in_solution(app, o, files);

    LoadedScene out;
    out.scene.periodic = o.light.periodic = app::periodic_axes(o.periodic, files);
    for (GridFile& file : files) load_volume(app, o, file, out);
    out.up = up_of(app, o, files);
    const std::vector<Solid> solids = load_solids(app, o, files, is_asked(asked, Effect::Solids), out);
    choose_sky(o, files, out);

    if (shows_light_grids(o)) require_one_solution(files, out.scene);
    const auto overlaps = overlaps_of(files);
    for (const Overlap& overlap : overlaps)
        if (overlap.several() && is_asked(asked, Effect::Multiple))
            share_collided(files[overlap.first], overlap, out.scene);
    choose_ground(o, files, out);
    choose_lights(app, o, files, out);
    out.effects = effects_of(app, o, files, out, solids,
                             out.scene.ground ? std::optional(out.scene.ground->albedo) : std::nullopt);
    app::tell_effects(app, o.effects, out.effects);
    apply(out.effects, o, out);
    if (o.multiple && out.effects.on(Effect::Multiple))
        app::of_file(files.front().path, [&] { add_multiple(app, o, files, out); });
    for (const Overlap& overlap : overlaps)
        app::of_file(files[overlap.first].path, [&] { require_same_light(files[overlap.first], overlap, out.scene); });
    for (size_t v = 0; v < files.size() && shows_light_grids(o) && is_asked(asked, Effect::Multiple); ++v)
        app::of_file(files[v].path, [&] { relight_volume(app, files[v], out.scene.volumes[v], out.scene); });
    for (size_t v = 0; v < files.size() && o.integrator.vertices > 0; ++v)
        if (const Volume& volume = out.scene.volumes[v];
            !volume.collided.phi && !find_grid(files[v], schema::series_phi_name(0)) && !volume.density->empty())
            throw InputError(files[v].path + ": --gather " + std::to_string(o.integrator.vertices) +
                             ": expected multiple scattering in which light paths end: run p1solve first");
    if (!o.integrator.shadow_rays && shows_light_grids(o)) add_light_grids(app, o, files, overlaps, out);
    return out;
}

bool glows(const Scene& scene)
{
    const auto glows = [](const Volume& v) { return v.collided.phi || (v.emission && !v.emission->empty()); };
    return !scene.sky.dark() || std::any_of(scene.volumes.begin(), scene.volumes.end(), glows);
}

std::string accuracy_of_light(const LoadedScene& loaded)
{
    std::string all;
    std::set<GridBasePtr> told;  // volumes that overlap share grids
    for (size_t v = 0; v < loaded.scene.volumes.size(); ++v) {
        const Volume& volume = loaded.scene.volumes[v];
        std::vector<GridBasePtr> light(volume.transmittance.begin(), volume.transmittance.end());
        light.push_back(volume.collided.phi);
        for (const GridBasePtr& grid : light) {
            const std::string text = grid && told.insert(grid).second
                                         ? app::of_file(loaded.paths[v], [&] { return text_of(read_accuracy(*grid)); })
                                         : "";
            if (!text.empty()) all += (all.empty() ? "" : "; ") + grid->getName() + ": " + text;
        }
    }
    return all;
}

}  // namespace vdbcloud
