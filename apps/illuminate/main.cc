// illuminate: the light that reaches each voxel of a cloud.
//
//   illuminate density.vdb --sun 0.3,1,0.2 -o light.vdb
//   fractalgen -o - | illuminate - --sun 0.3,1,0.2 --lamp 0,0.5,0 --lamp-intensity 3,2,1 -o - | render - -o cloud.exr
//
// First pass of Kajiya & Von Herzen 1984, section 3.1 (low albedo): one transmittance grid for each light, which render
// multiplies by the phase function along each ray of the camera.
#include "light_options.h"
#include "medium_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <algorithm>
#include <cmath>

using namespace vdbcloud;

namespace {

struct Options {
    std::string input, output, density;
    app::MediumOptions medium;
    app::LightOptions lights;
    TransmittanceOptions accuracy;
    app::Option disc_samples;
};

void declare(app::App& app, Options& o)
{
    app.add_option("input", o.input, ".vdb with a density, '-' for standard input")->required();
    app.add_option("-o,--output", o.output,
                   ".vdb to write: all of the input and the transmittance grids; '-' for standard output")
        ->required();
    app.add_option("--density", o.density, "the density grid's name, or NAME[k]; without it by common names");
    app.reads_grids();
    app.writes_grids();
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);

    const auto accuracy = "Accuracy";
    app.add_choice<Fidelity>(
           "--fidelity", o.accuracy.fidelity, {{"lattice", Fidelity::Lattice}, {"exact", Fidelity::Exact}},
           "lattice: rays carried along the light, time proportional to the voxels; exact: a ray for each voxel")
        ->group(accuracy);
    const auto lattice = [&o] { return o.accuracy.fidelity == Fidelity::Lattice; };
    app.add_option("--rays-per-voxel", o.accuracy.rays_per_voxel,
                   "of the lattice, along each axis: its error falls as the square")
        ->check(app::within(1, 8))
        ->only_with(lattice, "--fidelity lattice")
        ->group(accuracy);
    app.add_option("--refine", o.accuracy.refine, "light-grid points a voxel of density, along each axis")
        ->check(app::within(1, 8))
        ->group(accuracy);
    o.disc_samples = app.add_option("--disc-samples", o.accuracy.disc_samples,
                                    "directions over the disc of a sun that has a diameter")
                         ->check(app::within(1, 1024))
                         ->group(accuracy);
    app.add_option("--error-samples", o.accuracy.error_samples,
                   "voxels at which the lattice is compared with exact rays, for --json")
        ->check(app::within(0, 1000000))
        ->only_with(lattice, "--fidelity lattice")
        ->group(accuracy);
}

/// A light, and whether its grid in the file still holds.
struct Task {
    Light light;
    bool done;
};

/// What is asked for replaces lights of the same name in the file; those that the file has besides are kept, and done
/// again if density or extinction are no longer what they were computed with.
std::vector<Task> tasks_of(app::App& app, const Options& o, const GridFile& file, const FloatGrid& density,
                           const Medium& medium)
{
    std::vector<Task> tasks;
    const auto asked = app::lights_asked(o.lights);
    for (const auto& light : asked) tasks.push_back({light, false});
    const std::string digest = grid_digest(density);
    for (const auto& light : lights_of(file)) {
        const auto same = [&](const Task& t) { return t.light.name == light.name; };
        if (std::any_of(tasks.begin(), tasks.end(), same)) continue;
        const auto grid = find_grid(file, transmittance_name(light));
        const bool holds = app::same_extinction(*grid, medium) && get_text(*grid, schema::density_digest, "") == digest;
        if (!holds) app.say("light '" + light.name + "' was computed for another medium: doing it again");
        tasks.push_back({light, holds});
    }
    if (tasks.empty()) {
        tasks.push_back({app::automatic_sun(vector_of(read_up_axis(*file.metadata).value_or(UpAxis::Y))), false});
        app.say("no light asked for: a " + app::described(tasks[0].light));
    }
    return tasks;
}

/// Seconds and bytes from the counts of voxels; constants measured on one core of a 2.5 GHz server.
void estimate(app::App& app, const Options& o, const FloatGrid& density, size_t lights)
{
    const double voxels = 1.5 * double(density.activeVoxelCount()) * std::pow(o.accuracy.refine, 3);
    const double path = std::cbrt(double(density.evalActiveVoxelBoundingBox().volume()));
    const bool lattice = o.accuracy.fidelity == Fidelity::Lattice;
    const double each = lattice ? 15e-9 * o.accuracy.rays_per_voxel * o.accuracy.rays_per_voxel : 20e-9 * path;
    const double seconds = double(lights) * voxels * each, bytes = voxels * (24 + 8 * double(lights));
    app.report()["estimate"] = {{"memory_bytes", bytes}, {"seconds", seconds}};
    app.say(std::to_string(std::lround(voxels)) + " light-grid voxels, " + std::to_string(lights) + " lights: about " +
            std::to_string(std::lround(bytes / 1e6)) + " MB and " + std::to_string(std::lround(std::ceil(seconds))) +
            " s of processor time");
}

void illuminate(app::App& app, const Options& o)
{
    auto file = app.read(o.input);
    const auto density = density_of(file, o.density, app.warnings());
    app.uses(density->getName());
    const Medium medium = app::chosen_medium(app, o.medium, *density);
    const auto tasks = tasks_of(app, o, file, *density, medium);
    const auto disc = [](const Task& task) { return !task.done && task.light.parts(2).size() > 1; };
    o.disc_samples.check_effect(std::any_of(tasks.begin(), tasks.end(), disc), "a --sun-diameter above 0");
    if (app.dry_run()) return estimate(app, o, *density, tasks.size());

    for (const auto& task : tasks) {
        app.uses(transmittance_name(task.light));
        if (task.done) continue;
        const auto phase = app.phase(transmittance_name(task.light));
        TransmittanceReport found;
        put_grid(file,
                 transmittance_grid(*density, medium, task.light, o.accuracy, app.progress(task.light.name), &found));
        auto& report = app.report();
        report["counts"][task.light.name + "_voxels"] = found.voxels;
        if (found.compared > 0)
            report["accuracy"][task.light.name] = {{"compared_voxels", found.compared},
                                                   {"mean_transmittance_error", found.mean_error},
                                                   {"max_transmittance_error", found.max_error}};
    }
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("illuminate", "The light that reaches each voxel of a density: a transmittance grid for each light.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { illuminate(app, o); });
}
