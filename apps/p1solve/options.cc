#include "options.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud {

namespace {

void declare_closure(app::App& app, ScatterOptions& o)
{
    const auto group = "From P1 to the transport equation";
    app.add_option("--iterations", o.closure.iterations, "transport sweeps at most; 0 is P1")
        ->check(app::within(0, 1000))
        ->group(group);
    const auto sweeps = [&o] { return o.closure.iterations > 0; };
    app.add_option("--directions", o.closure.directions,
                   "of the quadrature, rounded up to what there is and to what the degree needs")
        ->check(app::within(1, 8192))
        ->only_with(sweeps, "--iterations above 0")
        ->group(group);
    app.add_choice<OrdinateKind>(
           "--quadrature", o.closure.kind,
           {{"product", OrdinateKind::Product}, {"level-symmetric", OrdinateKind::LevelSymmetric}},
           "product: azimuths x half-range Gauss, best in layers; level-symmetric: no axis is special, degree 5 at "
           "most")
        ->only_with(sweeps, "--iterations above 0")
        ->group(group);
    app.add_option("--degree", o.closure.degree,
                   "of the expansion of scattered light and of the delta-M scaling: 1 to 7")
        ->check(app::within(1, 7))
        ->only_with(sweeps, "--iterations above 0")
        ->group(group);
    app.add_option("--change", o.closure.change, "stop when a sweep changes the light it was given by less, relative")
        ->check(app::positive)
        ->only_with(sweeps, "--iterations above 0")
        ->group(group);
    app.add_option("--keep-moments", o.keep_moments, "degree up to which moments are written; 1: phi and flux")
        ->check(app::within(1, 7))
        ->only_with(sweeps, "--iterations above 0")
        ->group(group);
}

void read_periodic(P1solveOptions& o)
{
    for (const char axis : o.periodic) {
        if (axis < 'x' || axis > 'z')
            throw UsageError("--periodic " + printable(o.periodic) + ": expected letters of x, y and z");
        o.scatter.periodic[size_t(axis - 'x')] = true;
    }
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
    if (c.iterations == 0) return;
    if (o.series.order > 0) throw UsageError("--iterations and --series: expected one of them, the series expands P1");
    if (o.scatter.solver != P1Solver::Multigrid)
        throw UsageError("--iterations with --solver relaxation: expected multigrid");
    const size_t count = ordinates(c.kind, c.directions, c.degree).count();
    if (count != size_t(c.directions))
        app.say(std::to_string(c.directions) + " directions asked for degree " + std::to_string(c.degree) + ": " +
                std::to_string(count) + " taken");
}

}  // namespace

void declare(app::App& app, P1solveOptions& o)
{
    app.add_option("input", o.input, ".vdb with a density and its lights' transmittance, '-' for standard input")
        ->required();
    app.add_option("-o,--output", o.output, ".vdb to write: all of the input, phi and flux; '-' for standard output")
        ->required();
    app.add_option("--density", o.density, "the density grid's name, or NAME[k]; without it by common names");
    app.reads_grids();
    app.writes_grids();
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);
    app.add_option(
           "--sky", o.sky,
           "day: a clear one over the suns; or the radiance of a uniform sky, one number or r,g,b; without it none")
        ->group("Lights");
    app::declare_sky_shape(app, o.sky_shape, "Lights");

    const auto method = "Method";
    app.add_choice<bool>("--delta", o.scatter.delta, {{"on", true}, {"off", false}},
                         "delta-Eddington scaling of forward scattering; off: the paper's plain form")
        ->group(method);
    app.add_option("--periodic", o.periodic,
                   "axes [of the grid] on which the medium repeats: x, z, xz, ...; their extent a multiple of 8 voxels")
        ->group(method);
    app.add_choice<P1Solver>(
           "--solver", o.scatter.solver, {{"multigrid", P1Solver::Multigrid}, {"relaxation", P1Solver::Relaxation}},
           "multigrid: conjugate gradients with a multigrid cycle; relaxation: the paper's, for comparison")
        ->group(method);
    app.add_choice<bool>("--limiter", o.scatter.limiter, {{"none", false}, {"levermore-pomraning", true}},
                         "levermore-pomraning: no flux above the fluence, also where the medium is thin; not linear, "
                         "so lights no longer add up")
        ->group(method);
    app.add_option("--relaxation", o.scatter.relaxation, "over-relaxation factor of --solver relaxation")
        ->check(app::within(0.1, 1.999))
        ->only_with([&o] { return o.scatter.solver == P1Solver::Relaxation; }, "--solver relaxation")
        ->group(method);

    const auto series = "Series in absorption";
    const auto expands = [&o] { return o.series.order > 0; };
    const auto with_series = "--series above 0";
    app.add_option("--series", o.series.order,
                   "write I_0 .. I_K of the expansion in 1 - albedo, from which render makes any albedo; 0: none")
        ->check(app::within(0, 32))
        ->group(series);
    app.add_flag("--galerkin", o.series.galerkin,
                 "solve on the span of I_0 .. I_K, which does not diverge, instead of summing them")
        ->only_with(expands, with_series)
        ->group(series);
    app.add_option("--least-albedo", o.series.least_albedo, "the table of coefficients reaches from here to 1")
        ->check(app::within(0.01, 0.999999))
        ->only_with(expands, with_series)
        ->group(series);
    app.add_flag("--series-raw", o.series_raw, "write the I_k themselves too")
        ->only_with(expands, with_series)
        ->group(series);

    declare_closure(app, o.scatter);

    const auto accuracy = "Accuracy";
    app.add_option("--tolerance", o.scatter.solve.tolerance, "of the residual and of the estimated error, relative")
        ->check(app::positive)
        ->group(accuracy);
    app.add_option("--max-iterations", o.scatter.solve.max_iterations, "of the solver")
        ->check(app::within(1, 1000000))
        ->group(accuracy);
    app.add_flag("--allow-unconverged", o.allow_unconverged, "write the result and end with 0 all the same")
        ->group(accuracy);
    app.add_option("--rays-per-voxel", o.scatter.rays_per_voxel, "of the light lattice, along each axis")
        ->check(app::within(1, 8))
        ->group(accuracy);
    app.add_option("--reentry-rays", o.scatter.reentry_rays,
                   "for the estimate of light that would enter again; 0: none")
        ->check(app::within(0, 10000000))
        ->group(accuracy);
}

Sky chosen_sky(const P1solveOptions& o, const std::vector<Light>& lights, const Vec3d& up)
{
    Sky sky;
    sky.up = up;
    if (o.sky == "day" || (o.sky.empty() && app::sky_asked(o.sky_shape))) {
        sky = Sky::clear_day(brightest_sun(lights), up);
    } else if (!o.sky.empty()) {
        sky = Sky::constant(app::colour_asked("--sky", o.sky, "day, one number or r,g,b"));
        sky.up = up;
    }
    sky = app::with_asked(o.sky_shape, sky);
    try {
        check(sky);
    } catch (const InputError& e) {
        throw UsageError(std::string("--sky: ") + e.what());
    }
    return sky;
}

void finish(app::App& app, P1solveOptions& o)
{
    read_periodic(o);
    read_closure(app, o);
}

}  // namespace vdbcloud
