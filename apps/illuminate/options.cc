#include "options.h"

#include "periodic_option.h"

#include <algorithm>

namespace vdbcloud {

void declare(app::App& app, IlluminateOptions& o)
{
    app::declare_stage(app, o,
                       ".vdb files with a density each, or - for standard input; the densities of several files become "
                       "one medium",
                       ".vdb to write, or - for standard output: all of the input and a transmittance grid for each "
                       "light; of several inputs the joined density, Cd and emission");
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);
    app::declare_solids(app, o.solids, "Solids");

    const auto accuracy = "Accuracy";
    const auto lattice = [&o] { return o.accuracy.fidelity == Fidelity::Lattice; };
    const auto of_suns = [&](const app::Option& option) {
        o.of_suns.push_back(option);
        return option.scene("accuracy").group(accuracy);
    };
    of_suns(app.add_choice<Fidelity>("--fidelity", o.accuracy.fidelity,
                                     {{"lattice", Fidelity::Lattice}, {"exact", Fidelity::Exact}},
                                     "lattice: rays carried along the light, time proportional to the voxels; exact: a "
                                     "ray for each voxel, for checks. Lamps and periodic media are always exact"));
    of_suns(app.add_option("--rays-per-voxel", o.accuracy.rays_per_voxel,
                           "rays of the lattice along each axis; the error falls as the square"))
        ->check(app::within(1, 8))
        ->only_with(lattice, "--fidelity lattice");
    app.add_option("--refine", o.accuracy.refine,
                   "points of the light grid in a voxel of density, along each axis; for sharp shadows in coarse grids")
        ->check(app::within(1, 8))
        ->scene("accuracy")
        ->group(accuracy);
    o.disc_samples =
        app.add_option("--disc-samples", o.accuracy.disc_samples, "directions over the disc of a sun with a diameter")
            ->check(app::within(1, 1024))
            ->scene("accuracy")
            ->group(accuracy);
    of_suns(app.add_option("--error-samples", o.accuracy.error_samples,
                           "voxels at which lattice and exact rays are compared, for --json; 0: none"))
        ->check(app::within(0, 1000000))
        ->only_with(lattice, "--fidelity lattice");

    app::declare_effects(app, o.effects);
    app.takes_rungs();
    app.examples({{"a cloud in the afternoon sun, and its picture",
                   "fractalgen --size 96 -o cloud.vdb && illuminate cloud.vdb --sun 0.7,0.5,0.3 -o lit.vdb && render "
                   "lit.vdb --resolution 128 -o sun.png"},
                  {"two lights: a white sun and a red lamp below the cloud",
                   "illuminate cloud.vdb --sun 0,1,0 --lamp 0,-1,0 --lamp-intensity 9,1,0 -o two.vdb"},
                  {"a mountain that shadows the cloud: it stands in the file, and render shows it",
                   "fractalgen cloud.vdb --mountain --size 64 -o both.vdb && illuminate both.vdb --sun 1,0.3,0 -o "
                   "shadowed.vdb"}});
}

void check_effects(const IlluminateOptions& o, const std::vector<Light>& computed)
{
    const auto any = [&](auto holds) { return std::any_of(computed.begin(), computed.end(), holds); };
    const bool sun = any([](const Light& light) { return light.kind().at_infinity; });
    for (const app::Option& option : o.of_suns) {
        option.check_effect(sun, "--sun");
        option.check_effect(o.accuracy.periodic == app::Axes{}, "--periodic none: rays of a periodic medium are exact");
    }
    o.disc_samples.check_effect(any([](const Light& light) { return light.has_extent(); }), "--sun-diameter above 0");
}

}  // namespace vdbcloud
