#include "multiple.h"

#include "accuracy_line.h"
#include "inputs.h"
#include "plan.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scatter/expected_share.h"
#include "vdbcloud/scatter/scatter_plan.h"
#include "vdbcloud/scene/panorama.h"

#include <algorithm>
#include <cstdio>

namespace vdbcloud {

namespace {

ScatterOptions scatter_options(const RenderOptions& o, const LoadedScene& loaded)
{
    ScatterOptions options;
    options.closure.iterations = 3;
    options.periodic = loaded.scene.periodic;
    options.solids = loaded.scene.solids;
    options.channels_apart = loaded.effects.forced();
    options.up = vector_of(loaded.up);
    if (loaded.effects.on(Effect::Sky)) options.sky = app::lighting_sky(o.sky, o.lights, loaded.lights, options.up);
    return options;
}

}  // namespace

void add_multiple(app::App& app, const RenderOptions& o, std::vector<GridFile>& files, LoadedScene& loaded)
{
    if (files.size() > 1)
        throw UsageError("--multiple with several files: expected one; run p1solve on all of them into one file first");
    GridFile& file = files.front();
    Volume& volume = loaded.scene.volumes.front();
    const bool brings = volume.collided.phi || find_grid(file, schema::series_phi_name(0));
    o.option.multiple.check_effect(!brings, "a file without multiple scattering");
    if (brings) return;
    const ScatterOptions options = scatter_options(o, loaded);
    const std::vector<Light>& lights = loaded.scene.lights;
    const FloatGrid& density = *volume.density;
    const ScatterPlan planned = scatter_plan(density, volume.colour.get(), volume.emission.get(), volume.medium, lights,
                                             options, app.dry_run());
    if (app.dry_run()) {
        app.add_work(planned.work);
        loaded.planned.bytes = std::max(loaded.planned.bytes, planned.bytes);
        loaded.planned.grid_bytes += planned.grid_bytes;
        return;
    }
    app::Plan plan;
    plan.bytes = planned.bytes;
    plan.way_out = "a coarser density, or leave out --multiple";
    app::require_memory(plan);
    const auto phase = app.phase("multiple");
    ScatterReport report;
    const CollidedLight light = scatter_p1(density, volume.colour.get(), volume.emission.get(), volume.medium, lights,
                                           options, app.progress("multiple"), report);
    app.add_work(report.work);
    loaded.costs += report.costs;
    if (!report.converged)
        throw ConvergenceError(file.path +
                               ": --multiple: the solver missed its tolerance: run p1solve with other options");
    if (!light.phi) return;  // nothing to scatter in
    app::tell_accuracy(app, "multiple scattering", accuracy_of(report, lights), *light.phi);
    put_collided_light(file, light);
    volume.collided = read_collided_light(file, volume.medium.phase, app.warnings());
    put_panorama(file, options.sky.map());
    loaded.sky = read_sky(*light.phi, &file);
}

ShareFound share_of_multiple(app::App& app, const RenderOptions& o, const LoadedScene& loaded)
{
    const auto phase = app.phase("expected share");
    const Volume& volume = loaded.scene.volumes.front();
    ShareOptions options;
    options.periodic = loaded.scene.periodic;
    options.enough = app::accuracy_error(o.effects);
    options.error = std::min(options.error, std::max(1e-5, options.enough / 8));
    const ExpectedShare found =
        expected_share(*volume.density, volume.colour.get(), volume.medium, loaded.lights, Sky(), options);
    return {found.share, found.error};
}

void tell_left_out(app::App& app, const RenderOptions& o, const LoadedScene& loaded)
{
    const std::vector<Volume>& volumes = loaded.scene.volumes;
    const auto complete = [](const Volume& volume) { return bool(volume.collided.phi); };
    const bool unread = app.get_option("--quiet")->count() > 0 && app.get_option("--json")->count() == 0;
    if (unread) return;
    if (traces_paths(o) || app.dry_run() || std::any_of(volumes.begin(), volumes.end(), complete)) return;
    if (const EffectState& multiple = loaded.effects[Effect::Multiple]; multiple.left_out)
        return app.say("the picture shows light that is scattered once: multiple scattering is left out, " +
                       multiple.why);
    if (loaded.left_out_before)
        return app.say("the picture shows light that is scattered once: p1solve left out an expected " +
                       share_text(*loaded.left_out_before) + " of scattered light");
    ExpectedShare most;
    ShareOptions options;
    options.error = 0.01;  // the line has whole percents
    options.periodic = loaded.scene.periodic;
    const auto phase = app.phase("left out");
    for (const Volume& volume : volumes) {
        const ExpectedShare found =
            expected_share(*volume.density, volume.colour.get(), volume.medium, loaded.scene.lights, Sky(), options);
        if (found.share > most.share) most = found;
    }
    if (most.paths == 0) return;
    app.report()["left_out"] = {{"share", most.share}, {"error", most.error}};
    app.say("the picture shows light that is scattered once: light that is scattered again, " + share_text(most.share) +
            " of all scattering, is left out; --multiple adds it");
}

}  // namespace vdbcloud
