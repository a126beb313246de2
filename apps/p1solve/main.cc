// p1solve: light that is scattered many times, by the paper's expansion in spherical harmonics cut after the first.
//
//   p1solve light.vdb --albedo 0.9999 --g 0.85 -o lit.vdb
//   fractalgen -o - | illuminate - --sun 0.3,1,0.2 -o - | p1solve - --albedo 0.9999 --g 0.85 -o - | render - -o cloud.exr
//   p1solve low.vdb high.vdb --sun 0,1,0 -o both.vdb         several files as one medium
//   p1solve slab.vdb --sun 0.5,1,0 --periodic xz -o slab.lit.vdb        a cloud layer without end
//   p1solve slab.vdb --sun 0.5,1,0 --periodic xz --ground-albedo 0.8 -o snow.vdb        the same over snow
//   p1solve cloud.vdb --sun 0.3,1,0.2 --ground-albedo 0.3 --iterations 3 -o grass.vdb   a cloud over grass
//
//   p1solve light.vdb --g 0.85 --iterations 5 --directions 64 --degree 3 -o lit.vdb    on to the transport equation, by sweeps
//
// Kajiya & Von Herzen 1984, section 4 (high albedo). Writes phi (fluence) and flux of the collided light beside all
// that the input holds; the uncollided light is the transmittance grids', and render adds both.
#include "accuracy_line.h"
#include "add_series.h"
#include "effects.h"
#include "lights.h"
#include "map_file.h"
#include "options.h"
#include "previous.h"
#include "report.h"
#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/scene/panorama.h"
#include "vdbcloud/scene/solid.h"

#include <algorithm>

using namespace vdbcloud;

namespace {

/// The solids asked for take the place of those of the file, and travel in it.
std::vector<Solid> choose_solids(app::App& app, P1solveOptions& o, app::MediumInput& in)
{
    const Vec3d up = vector_of(app::settled_up(app, o.up, in.file, false));
    std::vector<Solid> solids = app::chosen_solids(app, o.solids, {&in.file}, up);
    if (!o.solids.asked.empty()) put_solids(in.file, solids);
    if (is_asked(app::effects_asked(o.effects), Effect::Solids)) o.scatter.solids = solids;
    if (o.series.order > 0 && o.lights.environment.asked())
        throw UsageError("--series " + std::to_string(o.series.order) +
                         " beside --environment: the series keeps no picture of the sky, leave one of them out");
    if (o.series.order > 0 && !o.scatter.solids.empty())
        throw UsageError("--series " + std::to_string(o.series.order) + " beside the " +
                         described(o.scatter.solids.front()) + ": the series knows no solids, leave --series out");
    return solids;
}

/// A run without a solution.
void pass_on(app::App& app, const P1solveOptions& o, P1Scene& scene, const std::vector<Light>& lights,
             const Effects& effects)
{
    app::MediumInput& in = scene.in;
    app::tell_darkness(app, lights, effects.on(Effect::Emission));
    if (!has_matter(*in.density)) app.warnings()("no voxel above 0: nothing to scatter in");
    leave_out_multiple(app, effects, in.file);
    if (app.dry_run()) return app::tell(app, writing_plan(o, in, lights), "pass on the input");
    app::tell_costs(app, o.effects, effects, {});
    app.write(o.output, in.file);
}

void solve(app::App& app, P1solveOptions& o, const P1Scene& scene, const Effects& effects)
{
    app::MediumInput& in = scene.in;
    GridFile& file = in.file;
    const FloatGridPtr density = in.density;
    const Medium& medium = in.medium;
    const std::vector<Light>& lights = scene.lights;
    const auto &emission = scene.emission, &tint = scene.tint;
    const app::Plan plan =
        app::of_file(file.path, [&] { return plan_of(app, o, in, tint.get(), emission.get(), lights); });
    if (app.dry_run())
        return app::tell(app, plan, "solve for " + std::to_string(density->activeVoxelCount()) + " voxels");
    app::require_memory(plan);
    ScatterReport report;
    CollidedLight light;
    {
        const auto phase = app.phase("p1");
        light = scatter_p1(*density, tint.get(), emission.get(), medium, lights, o.scatter, app.progress("p1"), report);
    }
    fill_report(app, report);
    app::tell_costs(app, o.effects, effects, report.costs);
    check_solution(app, o, medium, report);
    app::tell_darkness(app, lights, glows(report));
    if (!light.phi) app.warnings()("no voxel above 0: nothing to scatter in");
    if (o.series.order > 0 && light.phi) add_series(app, o, file, *density, emission.get(), medium, lights, light);
    Accuracy accuracy = accuracy_of(report, lights);
    if (o.voxel_error) {
        const auto phase = app.phase("voxel_error");
        Workload work;
        add_voxel_error(app, accuracy,
                        voxel_error(*density, tint.get(), emission.get(), medium, lights, o.scatter, light,
                                    app.progress("voxel error"), work));
        app.add_work(work);
    }
    if (light.phi) app::tell_accuracy(app, "multiple scattering", accuracy, *light.phi);
    put_collided_light(file, light);
    put_panorama(file, light.phi ? o.scatter.sky.map() : nullptr);
    remove_grids(file, [](const std::string& name) {
        return schema::has_role(name, schema::Role::Heating) || schema::has_role(name, schema::Role::GroundRadiance);
    });
    file.metadata->removeMeta(schema::multiple_left_out);
    for (const GridBasePtr& grid : {report.heating, report.ground})
        if (grid) put_grid(file, grid);
    write_flux_map(app, o, report, get_text(*file.metadata, schema::history, ""));
    app.write(o.output, file);
}

void run(app::App& app, P1solveOptions& o)
{
    finish(app, o);
    app::MediumInput in = app::read_one_medium(app, o, o.medium, true);
    o.scatter.parts = in.parts;
    o.scatter.periodic = in.periodic;
    choose_ground(o, in.periodic);
    GridFile& file = in.file;
    check_overlap(o, in);
    app.uses(in.density->getName());
    for (const MediumPart& part : in.parts) {
        app.uses(part.density->getName());
        if (part.colour) app.uses(part.colour->getName());
    }
    check_phase(o, in);
    choose_start(app, o, in);
    P1Scene scene{in, {}, choose_solids(app, o, in), {}, nullptr, nullptr};
    scene.lights = app::of_file(file.path, [&] { return lights_for(app, o, in); });
    const std::vector<Light> lights = scene.lights;
    o.rays_per_voxel.check_effect(!lights.empty(), "--sun or --lamp");
    o.rays_per_voxel.check_effect(in.periodic == app::Axes{}, "--periodic none: rays of a periodic medium are exact");
    o.disc_samples.check_effect(
        std::any_of(lights.begin(), lights.end(), [](const Light& light) { return light.has_extent(); }),
        "--sun-diameter above 0");
    const UpAxis up = app::settled_up(app, o.up, file, app::sky_asked(o.sky) || o.ground.given());
    o.scatter.up = vector_of(up);
    scene.sky = app::lighting_sky(o.sky, o.lights, lights, o.scatter.up);
    scene.tint = in.parts.empty() ? app::vector_grid(app, file, grid_of(file, schema::colour)) : nullptr;
    scene.emission = app::emission_of(app, file, in.fire, *in.density, in.medium, scene.tint.get());
    check_heating(o, in, bool(scene.tint));
    if (scene.tint) app.uses(grid_of(file, schema::colour)->getName());
    if (find_grid(file, schema::emission)) app.uses(schema::emission);
    const Effects effects = app::of_file(file.path, [&] { return effects_of(app, o, scene); });
    app::tell_effects(app, o.effects, effects);
    apply(effects, scene, o);
    if (effects.on(Effect::Multiple))
        solve(app, o, scene, effects);
    else
        pass_on(app, o, scene, lights, effects);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("p1solve",
                 "Multiple scattering in a density by the P1 equations: fluence and flux beside what the file holds.");
    P1solveOptions o;
    declare(app, o);
    return app.run(argc, argv, [&] {
        std::string last;
        app.each_frame([&](const auto& place) {
            P1solveOptions frame = o;
            app::place_stage(frame, place);
            place_start(frame, place, last);
            place(frame.flux_map);
            run(app, frame);
        });
    });
}
