#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/sources.h"

namespace vdbcloud {

namespace {

void declare_closure(app::App& app, P1solveOptions& o)
{
    ClosureOptions& c = o.scatter.closure;
    const auto group = "From P1 to the transport equation";
    app.add_option("--iterations", c.iterations,
                   "transport sweeps at most; 0: P1 alone. 5 remove most of P1's error in a cloud")
        ->check(app::within(0, 1000))
        ->scene("accuracy")
        ->group(group);
    const auto of_sweeps = [&](const app::Option& option) {
        return option.only_with([&o] { return o.scatter.closure.iterations > 0; }, "--iterations above 0")
            .scene("accuracy")
            .group(group);
    };
    const auto of_directions = [&](const app::Option& option) {
        return option
            .only_with([&o] { return o.scatter.closure.iterations > 0 || !o.flux_map.empty(); },
                       "--iterations above 0 or --flux-map")
            .scene("accuracy")
            .group(group);
    };
    of_directions(app.add_option("--directions", c.directions,
                                 "directions of the quadrature, rounded up to a number that exists and that the degree "
                                 "needs; more where lights are small"))
        ->check(app::within(1, 8192));
    of_directions(app.add_choice<OrdinateKind>(
        "--quadrature", c.kind, {{"product", OrdinateKind::Product}, {"level-symmetric", OrdinateKind::LevelSymmetric}},
        "product: azimuths x half-range Gauss, best in layers; level-symmetric: no axis is special, degree 5 at most"));
    of_sweeps(app.add_option("--degree", c.degree,
                             "degree of the Legendre expansion of scattered light and of the delta-M scaling; higher "
                             "for strong forward scattering"))
        ->check(app::within(1, 7));
    of_sweeps(app.add_option("--change", c.change,
                             "stop when the relative change of collided light between two sweeps falls below this "
                             "value"))
        ->check(app::positive);
    const app::Option start = app.add_option("--start-from", o.start_from,
                                             "the solution of the frame before (.vdb of p1solve): its light, moved "
                                             "with the grid vel, starts the sweeps in place "
                                             "of P1's, so that one or two suffice for a frame of a film. With --frames "
                                             "a numbered name, as of --output, is that "
                                             "of the frame before, and the first frame starts from P1");
    start->type_name("FILE")
        ->reads_files()
        ->only_with([&o] { return o.scatter.closure.iterations > 0; }, "--iterations above 0")
        ->group(group);
    o.start_seconds_option =
        app.add_option("--start-seconds", o.start_seconds,
                       "seconds between that frame and this; without it the times of cloudsim, else 0")
            ->check(app::within(-1e9, 1e9))
            ->default_str("")
            ->needs(start)
            ->group(group);
    o.keep_moments = app.add_option("--keep-moments", o.scatter.keep_moments,
                                    "degree up to which moments are written; 1: phi and flux alone. Less makes smaller "
                                    "files and blunter pictures");
    of_sweeps(o.keep_moments)
        ->check(app::within(1, 7))
        ->only_with([&o] { return o.scatter.closure.degree > 1; }, "--degree above 1");
}

void declare_method(app::App& app, P1solveOptions& o)
{
    const auto method = "Method";
    o.delta = app.add_choice<bool>("--delta", o.scatter.delta, {{"on", true}, {"off", false}},
                                   "on: delta-Eddington scaling of forward scattering; off: the paper's plain form, "
                                   "for comparison. No effect without a forward peak")
                  ->scene("accuracy")
                  ->group(method);
    app.add_choice<P1Solver>(
           "--solver", o.scatter.solver, {{"multigrid", P1Solver::Multigrid}, {"relaxation", P1Solver::Relaxation}},
           "multigrid: conjugate gradients with a multigrid cycle; relaxation: the paper's, for comparison")
        ->scene("accuracy")
        ->group(method);
    app.add_choice<bool>("--limiter", o.scatter.limiter, {{"none", false}, {"levermore-pomraning", true}},
                         "levermore-pomraning: no flux above the fluence, also where the medium is thin; the equations "
                         "are then not linear, and lights no longer add up")
        ->scene("accuracy")
        ->group(method);
    app.add_option("--relaxation", o.scatter.relaxation, "factor of successive over-relaxation")
        ->check(app::within(0.1, 1.999))
        ->only_with([&o] { return o.scatter.solver == P1Solver::Relaxation; }, "--solver relaxation")
        ->scene("accuracy")
        ->group(method);
}

void declare_series(app::App& app, P1solveOptions& o)
{
    const auto group = "Series in absorption";
    app.add_option("--series", o.series.order,
                   "order of the expansion in 1 - albedo, I_0 .. I_K, from which render makes a picture at any albedo; "
                   "0: none")
        ->check(app::within(0, 32))
        ->group(group);
    const auto of_series = [&](const app::Option& option) {
        return option.only_with([&o] { return o.series.order > 0; }, "--series above 0").group(group);
    };
    of_series(app.add_flag("--galerkin", o.series.galerkin,
                           "solve on the span of I_0 .. I_K, which does not diverge, instead of summing them; for "
                           "albedos far below 1"));
    of_series(app.add_option("--least-albedo", o.series.least_albedo,
                             "lowest albedo that render can reconstruct from the series"))
        ->check(app::within(0.01, 0.999999));
    of_series(app.add_flag("--series-raw", o.series_raw, "write the I_k themselves, too"));
}

void declare_accuracy(app::App& app, P1solveOptions& o)
{
    const auto accuracy = "Accuracy";
    app.add_option("--tolerance", o.scatter.solve.tolerance,
                   "stop when the relative residual and the relative error estimate fall below this value; solves "
                   "between sweeps follow the change")
        ->check(app::positive)
        ->scene("accuracy")
        ->group(accuracy);
    app.add_option("--max-iterations", o.scatter.solve.max_iterations,
                   "iterations of the solver at most; status 3 if they do not suffice")
        ->check(app::within(1, 1000000))
        ->scene("accuracy")
        ->group(accuracy);
    app.add_flag("--allow-unconverged", o.allow_unconverged,
                 "write the result and end with status 0 where the solver missed its tolerance")
        ->group(accuracy);
    o.rays_per_voxel = app.add_option("--rays-per-voxel", o.scatter.rays_per_voxel,
                                      "rays of the light lattice along each axis; the error falls as the square")
                           ->check(app::within(1, 8))
                           ->scene("accuracy")
                           ->group(accuracy);
    o.disc_samples =
        app.add_option("--disc-samples", o.scatter.disc_samples, "directions over the disc of a sun with a diameter")
            ->check(app::within(1, 1024))
            ->scene("accuracy")
            ->group(accuracy);
    app.add_flag(
           "--voxel-error", o.voxel_error,
           "solve on voxels of twice and four times the edge, too, and report the error of phi that the size of the "
           "voxels makes; takes up to a seventh longer")
        ->group(accuracy);
    app.add_option(
           "--reentry-rays", o.scatter.reentry_rays,
           "rays used to estimate light that leaves one part of the medium and hits another, and for P1 alone the "
           "planes that light leaves through, for --json; 0 disables both estimates")
        ->check(app::within(0, 10000000))
        ->scene("accuracy")
        ->group(accuracy);
}

void declare_power(app::App& app, P1solveOptions& o)
{
    const auto group = "Power";
    app.add_option(
           "--flux-map", o.flux_map,
           "picture of power by column of the grid to write, an .exr: diffuse light up at the top and down at the "
           "base, direct light at both, absorbed power. P1 alone takes one sweep of --directions for it")
        ->type_name("FILE")
        ->writes_file(app::FileKind::Map)
        ->group(group);
    o.heating =
        app.add_flag("--heating", o.scatter.heating,
                     "write a grid heating: absorbed power per volume, whose sum is the absorbed power of --json")
            ->group(group);
}

void read_closure(app::App& app, P1solveOptions& o)
{
    ClosureOptions& c = o.scatter.closure;
    if (o.scatter.limiter && c.iterations > 0)
        throw UsageError("--iterations with --limiter: expected one of them, both are closures of P1");
    if (o.scatter.limiter && o.series.order > 0)
        throw UsageError("--series with --limiter: expected one of them, the series needs linear equations");
    if (o.scatter.limiter && o.scatter.solver != P1Solver::Multigrid)
        throw UsageError("--limiter with --solver relaxation: expected multigrid");
    if (o.ground.given() && (o.scatter.limiter || o.series.order > 0))
        throw UsageError(std::string("--ground-albedo with ") + (o.scatter.limiter ? "--limiter" : "--series") +
                         ": expected one of them");
    o.scatter.emission_by_rays = o.series.order == 0;
    if (c.iterations == 0 && !o.scatter.flux_map) return;
    if (c.iterations > 0 && o.series.order > 0)
        throw UsageError("--iterations and --series: expected one of them, the series expands P1");
    if (c.iterations > 0 && o.scatter.solver != P1Solver::Multigrid)
        throw UsageError("--iterations with --solver relaxation: expected multigrid");
    const int degree = c.iterations > 0 ? c.degree : 1;
    const size_t count = ordinates(c.kind, c.directions, degree).count();
    if (count != size_t(c.directions))
        app.say(std::to_string(c.directions) + " directions asked for degree " + std::to_string(degree) + ": " +
                std::to_string(count) + " taken");
}

}  // namespace

void declare(app::App& app, P1solveOptions& o)
{
    app::declare_stage(
        app, o,
        ".vdb files with a density and its lights' transmittance, or - for standard input; the densities "
        "of several files become one medium, so that each lights and shades the others",
        ".vdb to write, or - for standard output: all of the input, phi (fluence) and flux; of several "
        "inputs the joined density, Cd and emission");
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);
    app::declare_solids(app, o.solids, "Solids");
    app::declare_sky(app, o.sky, o.lights, "Lights", "none");
    o.sky.option.haze.only_with([&o] { return o.sky.sky == "day" || app::shape_asked(o.sky); }, "--sky day");
    o.ground =
        app.add_option("--ground-albedo", o.ground_albedo,
                       "albedo of a Lambertian ground beneath the medium, 0 to 1: an endless plane one voxel below the "
                       "centres of the lowest voxels, which reflects direct and diffuse light and hides the sky below "
                       "the horizon; without it light that leaves downwards is lost. Refused with lamps unless the "
                       "medium is periodic, and with --periodic along one axis. With --periodic along both horizontal "
                       "axes and gaps in the lowest layer give --iterations 5, too")
            ->check(app::within(0, 1))
            ->default_str("")
            ->scene("solids")
            ->group("Lights");
    o.sky.option.ground.not_with([&o] { return o.ground.given(); }, "--ground-albedo");
    declare_method(app, o);
    declare_series(app, o);
    declare_closure(app, o);
    declare_power(app, o);
    declare_accuracy(app, o);
    app::declare_effects(app, o.effects);
    app::declare_accuracy_error(app, o.effects);
    app.takes_rungs();
    app.examples(
        {{"multiple scattering in a cloud of droplets, and its picture",
          "fractalgen --size 64 -o cloud.vdb && illuminate cloud.vdb --sun 0.7,0.5,0.3 -o light.vdb && "
          "p1solve light.vdb --albedo 0.9999 --g 0.85 -o lit.vdb && render lit.vdb --resolution 128 -o lit.png"},
         {"beyond P1, by sweeps of the transport equation",
          "p1solve light.vdb --albedo 0.9999 --g 0.85 --iterations 3 --directions 48 --degree 3 -o "
          "swept.vdb"},
         {"a series, then a picture at another albedo without another solve",
          "p1solve light.vdb --series 6 --galerkin -o series.vdb && render series.vdb --albedo 0.95 "
          "--resolution 128 -o grey.png"}});
}

namespace {

/// The medium, or those that overlap.
std::vector<Medium> media_of(const app::MediumInput& in)
{
    std::vector<Medium> media;
    for (const MediumPart& part : in.parts) media.push_back(part.medium);
    return media.empty() ? std::vector{in.medium} : media;
}

}  // namespace

void check_overlap(const P1solveOptions& o, const app::MediumInput& in)
{
    if (in.parts.empty()) return;
    for (const auto& [given, name] : {std::pair{o.series.order > 0, "--series"}, {o.voxel_error, "--voxel-error"}})
        if (given)
            throw UsageError(in.file.path + ": media of different phase functions or colours, and " + name +
                             " takes one medium: give one --phase and --extinction for all, or leave " + name + " out");
}

void check_phase(const P1solveOptions& o, const app::MediumInput& in)
{
    bool peaked = false, detailed = false;
    for (const Medium& medium : media_of(in)) {
        const DeltaScaling scaled = delta_scaling(medium.phase, o.scatter.closure.degree);
        peaked = peaked || scaled.delta_f > 0;
        const DeltaScaling used = o.scatter.delta ? scaled : no_scaling(medium.phase, o.scatter.closure.degree);
        detailed = detailed || used.last_degree() > 1;
    }
    o.delta.check_effect(peaked, "a phase function with a forward peak (--g above 0)");
    o.keep_moments.check_effect(detailed, "a phase function with moments of degree 2 and more");
}

void check_heating(const P1solveOptions& o, const app::MediumInput& in, bool tinted)
{
    bool absorbs = tinted;
    for (const Medium& medium : media_of(in))
        for (int c = 0; c < 3; ++c) absorbs = absorbs || medium.albedo[c] < 1;
    for (const MediumPart& part : in.parts) absorbs = absorbs || part.colour;
    o.heating.check_effect(absorbs, "an --albedo below 1 or a grid Cd");
}

void choose_ground(P1solveOptions& o, const app::Axes& periodic)
{
    if (!o.ground.given()) return;
    if (const int axes = periodic[0] + periodic[1] + periodic[2]; axes != 0 && axes != 2)
        throw UsageError("--ground-albedo with --periodic " + periodic_text(periodic) +
                         ": expected --periodic none, or a medium periodic along both horizontal axes, such as "
                         "--periodic xz. For other media: render --integrator path");
    o.scatter.ground_albedo = o.ground_albedo;
}

void finish(app::App& app, P1solveOptions& o)
{
    o.scatter.flux_map = !o.flux_map.empty();
    read_closure(app, o);
}

}  // namespace vdbcloud
