// illuminate: the light that reaches each voxel of a cloud.
//
//   illuminate density.vdb --sun 0.3,1,0.2 -o light.vdb
//   illuminate low.vdb high.vdb --sun 0,1,0 -o both.vdb       several files as one medium: each shades the others
//   illuminate field.vdb --sun 0.3,1,0.2 --periodic xz -o light.vdb       a field of clouds without end
//   fractalgen -o - | illuminate - --sun 0.3,1,0.2 --lamp 0,0.5,0 --lamp-intensity 3,2,1 -o - | render - -o cloud.exr
//
// First pass of Kajiya & Von Herzen 1984, section 3.1 (low albedo): one transmittance grid for each light, which render
// multiplies by the phase function along each ray of the camera.
#include "accuracy_line.h"
#include "inputs.h"
#include "options.h"
#include "plan.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/sources.h"

#include <algorithm>

using namespace vdbcloud;

namespace {

/// A light. `done`: its grid in the file is valid for this density and medium. `idle`: it adds nothing.
struct Task {
    Light light;
    bool done;
    bool idle = false;
};

/// The lights of the command line, which replace lights of the same name and the same lights in the inputs, then the
/// other lights of the inputs. A grid of the file that was computed with another density or extinction is computed
/// again.
std::vector<Task> tasks_of(app::App& app, const IlluminateOptions& o, const std::vector<Light>& asked,
                           app::MediumInput& in)
{
    GridFile& file = in.file;
    std::vector<Task> tasks;
    for (const auto& light : asked) tasks.push_back({light, false});
    for (const Light& theirs : vdbcloud::lights_of(file)) {  // the same light by another name
        const auto is_it = [&](const Light& light) { return same_light(light, theirs); };
        if (std::any_of(asked.begin(), asked.end(), is_it))
            remove_grids(file, [&](const std::string& name) { return name == transmittance_name(theirs); });
    }
    const std::string digest = grid_digest(*in.density), standing = solids_digest(o.accuracy.solids, false);
    for (const auto& light : app::inherited_lights(in.lights, asked)) {
        if (!asked.empty()) app.say("the " + app::described(light) + " of the input stays: '" + light.name + "'");
        const auto grid = find_grid(file, transmittance_name(light));
        const bool filled = grid && (grid->activeVoxelCount() > 0 || in.density->activeVoxelCount() == 0);
        const bool holds = filled && app::same_extinction(*grid, in.medium) && read_periodic(*grid) == in.periodic &&
                           get_text(*grid, schema::density_digest, "") == digest &&
                           get_text(*grid, schema::solids, "") == standing;
        if (!holds && light.strength() != Vec3d(0.0))
            app.say("light '" + light.name + "' was computed for another medium: doing it again");
        tasks.push_back({light, holds});
    }
    if (tasks.empty() && o.lights.environment.asked()) {
        app.say(printable(o.lights.environment.path) +
                ": the environment has no sun, and no light is written: it is a sky for p1solve and render");
    } else if (tasks.empty()) {
        tasks.push_back({app::automatic_sun(vector_of(app::settled_up(app, o.up, file, true))), false});
        app.say("no light asked for: a " + app::described(tasks[0].light));
    }
    return tasks;
}

/// The solids asked for take the place of those of the file, and travel in it. Results for other solids are dropped.
std::vector<Solid> choose_solids(app::App& app, IlluminateOptions& o, app::MediumInput& in)
{
    std::vector<Solid> solids =
        app::chosen_solids(app, o.solids, {&in.file}, vector_of(app::settled_up(app, o.up, in.file, false)));
    if (!o.solids.asked.empty()) put_solids(in.file, solids);
    for (const Solid& solid : solids) app.say("solid: " + described(solid));
    if (is_asked(app::effects_asked(o.effects), Effect::Solids)) o.accuracy.solids = solids;
    return solids;
}

/// The effects in play. Lights that add nothing become idle.
Effects choose_effects(const IlluminateOptions& o, const app::MediumInput& in, const std::vector<Solid>& solids,
                       std::vector<Task>& tasks)
{
    EffectFacts facts;
    facts.stage = EffectStage::Light;
    facts.media = {{in.density.get(), in.medium}};
    for (const Task& task : tasks) facts.lights.push_back(task.light);
    facts.solids = solids;
    facts.periodic = in.periodic;
    Effects effects(facts, app::effects_asked(o.effects));
    for (size_t n = 0; n < tasks.size(); ++n) tasks[n].idle = !effects.lights()[n];
    return effects;
}

std::vector<Light> lights_of(const std::vector<Task>& tasks)
{
    std::vector<Light> lights;
    for (const Task& task : tasks) lights.push_back(task.light);
    return lights;
}

std::vector<Light> computed(const std::vector<Task>& tasks)
{
    std::vector<Light> lights;
    for (const Task& task : tasks)
        if (!task.done && !task.idle) lights.push_back(task.light);
    return lights;
}

/// Events and memory. Without `count` memory alone, in no time.
app::Plan plan_of(const IlluminateOptions& o, const app::MediumInput& in, const std::vector<Task>& tasks, bool count)
{
    app::Plan plan;
    plan.way_out = "a coarser density" + std::string(o.accuracy.refine > 1 ? ", a smaller --refine" : "");
    double kept = 0;
    for (const GridBasePtr& grid : in.file.grids) plan.work.add("write_byte", app::value_bytes(*grid));
    for (const Task& task : tasks) {
        if (task.done || task.idle) continue;
        const TransmittancePlan light = transmittance_plan(*in.density, in.medium, task.light, o.accuracy, count);
        plan.work += light.work;
        plan.work.add("write_byte", light.value_bytes);
        plan.bytes = std::max(plan.bytes, kept + light.bytes);
        kept += light.grid_bytes;
    }
    return plan;
}

/// Adds the grid of a light to the file.
EffectCosts illuminate_by(app::App& app, const IlluminateOptions& o, app::MediumInput& in, const Light& light)
{
    const auto phase = app.phase(transmittance_name(light));
    TransmittanceReport found;
    const GridBasePtr grid =
        transmittance_grid(*in.density, in.medium, light, o.accuracy, app.progress(light.name), &found);
    put_grid(in.file, grid);
    app::tell_accuracy(app, grid->getName(), accuracy_of(found), *grid);
    auto& report = app.report();
    report["counts"][light.name + "_voxels"] = found.voxels;
    if (!o.accuracy.solids.empty()) {
        report["counts"][light.name + "_hidden_voxels"] = found.hidden;
        if (found.voxels > 0 && found.hidden == found.voxels) app.say(app::described(light) + " reaches no voxel");
    }
    app.add_work(found.work);
    if (found.compared > 0)
        report["accuracy"][light.name] = {{"compared_voxels", found.compared},
                                          {"mean_transmittance_error", found.mean_error},
                                          {"max_transmittance_error", found.max_error}};
    return found.costs;
}

void illuminate(app::App& app, IlluminateOptions& o)
{
    app::MediumInput in = app::read_one_medium(app, o, o.medium);
    o.accuracy.periodic = in.periodic;
    const std::vector<Solid> solids = choose_solids(app, o, in);
    app.uses(in.density->getName());
    const UpAxis up = app::settled_up(app, o.up, in.file, o.lights.by_atmosphere || o.lights.environment.asked());
    const auto asked = app::lights_asked(o.lights, vector_of(up));
    auto tasks = app::of_file(in.file.path, [&] { return tasks_of(app, o, asked, in); });
    const Effects effects = choose_effects(o, in, solids, tasks);
    app::tell_effects(app, o.effects, effects);
    check_effects(o, computed(tasks));
    app::tell_darkness(app, lights_of(tasks), o.lights.environment.asked());
    if (app.dry_run())
        return app::tell(app, plan_of(o, in, tasks, true),
                         "light " + std::to_string(in.density->activeVoxelCount()) + " voxels by " +
                             std::to_string(tasks.size()) + " lights");
    app::require_memory(plan_of(o, in, tasks, false));

    EffectCosts costs;
    for (const auto& task : tasks) {
        app.uses(transmittance_name(task.light));
        if (task.idle && !task.done) put_grid(in.file, unlit_grid(*in.density, task.light));
        if (!task.done && !task.idle) costs += illuminate_by(app, o, in, task.light);
    }
    in.file.metadata->removeMeta(schema::multiple_left_out);  // of other light
    app::tell_costs(app, o.effects, effects, costs);
    app.write(o.output, in.file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("illuminate", "The light that reaches each voxel of a density: a transmittance grid for each light.");
    IlluminateOptions o;
    declare(app, o);
    return app.run(argc, argv, [&] {
        app.each_frame([&](const auto& place) {
            IlluminateOptions frame = o;
            app::place_stage(frame, place);
            illuminate(app, frame);
        });
    });
}
