// p1solve: light that is scattered many times, by the paper's expansion in spherical harmonics cut after the first.
//
//   p1solve light.vdb --albedo 0.9999 --g 0.85 -o lit.vdb
//   fractalgen -o - | illuminate - --sun 0.3,1,0.2 -o - | p1solve - --albedo 0.9999 --g 0.85 -o - | render - -o cloud.exr
//   p1solve slab.vdb --sun 0.5,1,0 --periodic xz -o slab.lit.vdb        a cloud layer without end
//
//   p1solve light.vdb --g 0.85 --iterations 5 --directions 64 --degree 3 -o lit.vdb    on to the transport equation, by sweeps
//
// Kajiya & Von Herzen 1984, section 4 (high albedo). Writes phi (fluence) and flux of the collided light beside all that
// the input holds; the uncollided light is the transmittance grids', and render adds both.
#include "light_options.h"
#include "medium_options.h"
#include "scaled_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>
#include <cmath>

using namespace vdbcloud;

namespace {

struct Options {
    std::string input, output, density, periodic;
    app::MediumOptions medium;
    app::LightOptions lights;
    ScatterOptions scatter;
    bool allow_unconverged = false, series_raw = false;
    SeriesOptions series;

    Options() { series.order = 0; }
};

void declare_closure(app::App& app, ScatterOptions& o)
{
    const auto group = "From P1 to the transport equation";
    auto* iterations = app.add_option("--iterations", o.closure.iterations, "transport sweeps at most; 0 is P1")
                           ->check(app::within(0, 1000))->group(group);
    app.add_option("--directions", o.closure.directions, "of the quadrature, rounded up to what there is and to what the degree needs")
        ->check(app::within(1, 8192))->needs(iterations)->group(group);
    app.add_choice<OrdinateKind>("--quadrature", o.closure.kind,
                                 {{"product", OrdinateKind::Product}, {"level-symmetric", OrdinateKind::LevelSymmetric}},
                                 "product: azimuths x half-range Gauss, best in layers; level-symmetric: no axis is special, degree 5 at most")
        ->needs(iterations)->group(group);
    app.add_option("--degree", o.closure.degree, "of the expansion of scattered light and of the delta-M scaling: 1 to 7")
        ->check(app::within(1, 7))->needs(iterations)->group(group);
    app.add_option("--change", o.closure.change, "stop when phi changes by less from sweep to sweep, relative")
        ->check(app::positive)->needs(iterations)->group(group);
    app.add_option("--keep-moments", o.keep_moments, "degree up to which moments are written; 1: phi and flux")
        ->check(app::within(1, 7))->needs(iterations)->group(group);
}

void declare(app::App& app, Options& o)
{
    app.add_option("input", o.input, ".vdb with a density and its lights' transmittance, '-' for standard input")->required();
    app.add_option("-o,--output", o.output, ".vdb to write: all of the input, phi and flux; '-' for standard output")->required();
    app.add_option("--density", o.density, "the density grid's name, or NAME[k]; without it by common names");
    app.reads_grids();
    app.writes_grids();
    app::declare_medium(app, o.medium);
    app::declare_lights(app, o.lights);
    app.add_rgb("--sky", o.scatter.sky, "radiance of a uniform sky, one number or r,g,b")->check(app::nonnegative)->group("Lights");

    const auto method = "Method";
    app.add_choice<bool>("--delta", o.scatter.delta, {{"on", true}, {"off", false}},
                         "delta-Eddington scaling of forward scattering; off: the paper's plain form")->group(method);
    app.add_option("--periodic", o.periodic, "axes [of the grid] on which the medium repeats: x, z, xz, ...; their extent a multiple of 8 voxels")
        ->group(method);
    app.add_choice<P1Solver>("--solver", o.scatter.solver,
                             {{"multigrid", P1Solver::Multigrid}, {"relaxation", P1Solver::Relaxation}},
                             "multigrid: conjugate gradients with a multigrid cycle; relaxation: the paper's, for comparison")->group(method);
    app.add_option("--relaxation", o.scatter.relaxation, "over-relaxation factor of --solver relaxation")
        ->check(app::within(0.1, 1.999))->group(method);

    const auto series = "Series in absorption";
    app.add_option("--series", o.series.order, "write I_0 .. I_K of the expansion in 1 - albedo, from which render makes any albedo; 0: none")
        ->check(app::within(0, 32))->group(series);
    app.add_flag("--galerkin", o.series.galerkin, "solve on the span of I_0 .. I_K, which does not diverge, instead of summing them")->group(series);
    app.add_option("--least-albedo", o.series.least_albedo, "the table of coefficients reaches from here to 1")
        ->check(app::within(0.01, 0.999999))->group(series);
    app.add_flag("--series-raw", o.series_raw, "write the I_k themselves too")->group(series);

    declare_closure(app, o.scatter);

    const auto accuracy = "Accuracy";
    app.add_option("--tolerance", o.scatter.solve.tolerance, "of the residual and of the estimated error, relative")
        ->check(app::positive)->group(accuracy);
    app.add_option("--max-iterations", o.scatter.solve.max_iterations, "of the solver")->check(app::within(1, 1000000))->group(accuracy);
    app.add_flag("--allow-unconverged", o.allow_unconverged, "write the result and end with 0 all the same")->group(accuracy);
    app.add_option("--rays-per-voxel", o.scatter.rays_per_voxel, "of the light lattice, along each axis")
        ->check(app::within(1, 8))->group(accuracy);
    app.add_option("--reentry-rays", o.scatter.reentry_rays, "for the estimate of light that would enter again; 0: none")
        ->check(app::within(0, 10000000))->group(accuracy);
}

void read_periodic(Options& o)
{
    for (const char axis : o.periodic) {
        if (axis < 'x' || axis > 'z') throw UsageError("--periodic " + printable(o.periodic) + ": expected letters of x, y and z");
        o.scatter.periodic[size_t(axis - 'x')] = true;
    }
}

void read_closure(app::App& app, Options& o)
{
    ClosureOptions& c = o.scatter.closure;
    if (c.iterations == 0) return;
    if (o.series.order > 0) throw UsageError("--iterations and --series: expected one of them, the series expands P1");
    if (o.scatter.solver != P1Solver::Multigrid) throw UsageError("--iterations with --solver relaxation: expected multigrid");
    const size_t count = ordinates(c.kind, c.directions, c.degree).count();
    if (count != size_t(c.directions))
        app.say(std::to_string(c.directions) + " directions asked for degree " + std::to_string(c.degree) + ": " +
                std::to_string(count) + " taken");
}

/// Moments of an earlier run: they belong to a phi that is replaced.
void drop_moments(GridFile& file)
{
    const auto is_moment = [](const GridBasePtr& grid) { return grid->getName().rfind(schema::moment_prefix, 0) == 0; };
    file.grids.erase(std::remove_if(file.grids.begin(), file.grids.end(), is_moment), file.grids.end());
}

/// The vec3s grid of a role, if there is one.
Vec3SGridPtr vectors(app::App& app, const GridFile& file, const GridBasePtr& grid)
{
    if (!grid || grid->empty()) return nullptr;
    if (auto found = openvdb::gridPtrCast<Vec3SGrid>(grid)) return found;
    app.warnings()(file.path + ": grid '" + printable(grid->getName()) + "' is " + grid->valueType() + ", expected vec3s; passed over");
    return nullptr;
}

/// The lights asked for, else the file's, else a sun if nothing shines. What the file has no transmittance for gets one, as
/// render needs it.
std::vector<Light> lights_for(app::App& app, const Options& o, GridFile& file, const FloatGrid& density, const Medium& medium)
{
    auto lights = app::lights_asked(o.lights);
    if (lights.empty()) lights = lights_of(file);
    const bool sky = o.scatter.sky != Vec3d(0.0), glow = bool(find_grid(file, schema::emission));
    if (lights.empty() && !sky && !glow) {
        const bool z_up = get_text(*file.metadata, schema::up_axis, "Y") == "Z";
        lights.push_back(app::automatic_sun(z_up ? Vec3d(0, 0, 1) : Vec3d(0, 1, 0)));
        app.say("no light asked for: a " + app::described(lights[0]));
    }
    for (const Light& light : lights) {
        app.uses(transmittance_name(light));
        if (app.dry_run() || o.periodic.size()) continue;
        const GridBasePtr there = find_grid(file, transmittance_name(light));
        const auto theirs = there ? read_light(*there, there->getName()) : std::nullopt;
        if (theirs && app::same_place(*theirs, light) && theirs->irradiance == light.irradiance &&
            app::same_extinction(*there, medium) && get_text(*there, schema::density_digest, "") == grid_digest(density))
            continue;
        const auto phase = app.phase(transmittance_name(light));
        put_grid(file, transmittance_grid(density, medium, light, {}, app.progress(light.name)));
    }
    return lights;
}

nlohmann::json numbers(const std::array<double, 6>& v) { return nlohmann::json(std::vector<double>(v.begin(), v.end())); }

nlohmann::json described(const ClosureReport& c)
{
    nlohmann::json r = {{"directions", c.directions}, {"iterations", c.iterations}, {"converged", c.converged},
                        {"change", c.change}, {"seconds", c.seconds}, {"contraction", c.contraction}};
    if (c.error >= 0) r["error_estimate"] = c.error;
    for (const SolveResult& solve : c.solves) r["solver_iterations"].push_back(solve.iterations);
    return r;
}

nlohmann::json described(const ChannelReport& c)
{
    const P1Budget& b = c.budget;
    nlohmann::json r = {{"solved_as", std::string(1, "rgb"[c.solved_as])}, {"scale", c.scale},
                        {"iterations", c.solve.iterations}, {"converged", c.solve.converged},
                        {"residual", c.solve.residual}, {"error_estimate", c.solve.error}, {"residual_history", c.solve.history}};
    r["budget"] = {{"beam_lost_in_medium", c.deposited}, {"sky_in", b.sky_in}, {"emitted", c.emitted},
                   {"reflected", c.reflected}, {"transmitted_diffuse", c.transmitted}, {"absorbed", b.absorbed},
                   {"out_by_face", numbers(b.out)}, {"defect", b.defect}};
    if (c.lines >= 0) {
        r["budget"]["beam_lost_by_lines"] = c.lines;
        r["budget"]["faces_against_lines"] = c.lines > 0 ? c.deposited / c.lines - 1 : 0.0;
    }
    if (c.reentry >= 0) r["budget"]["share_that_would_enter_again_and_is_lost"] = c.reentry;
    if (c.closure.iterations > 0) r["sweeps"] = described(c.closure);
    r["phi"] = {{"smallest", b.smallest}, {"largest", b.largest}, {"negative_voxels", b.negative}};
    return r;
}

void fill_report(app::App& app, const ScatterReport& report)
{
    auto& r = app.report();
    r["counts"] = {{"active_voxels", report.voxels}, {"blocks", report.blocks}, {"exposed_voxels", report.exposed},
                   {"solves", report.solves}, {"levels", report.levels}};
    r["memory"] = {{"array_bytes", report.bytes},
                   {"bytes_per_active_voxel", report.voxels ? double(report.bytes) / double(report.voxels) : 0.0}};
    const char* const channels[] = {"r", "g", "b"};
    for (int c = 0; c < 3; ++c) r["channels"][channels[c]] = described(report.channel[c]);
    if (report.channel[0].closure.iterations == 0)
        r["accuracy"] = {{"bias", "P1: on clouds with directional light the picture is off by 10 to 45 %, which transport sweeps remove"}};
}

void estimate(app::App& app, const Options& o, const Medium& medium, const FloatGrid& density, size_t lights)
{
    const double voxels = double(density.activeVoxelCount()), slots = 512.0 * density.tree().leafCount();
    double bytes = 90 * slots + 60 * voxels, seconds = voxels * (1e-6 * double(lights) + 1e-6);
    if (const ClosureOptions& c = o.scatter.closure; c.iterations > 0) {
        const size_t directions = ordinates(c.kind, c.directions, c.degree).count();
        const int terms = medium.g == 0 ? 1 : harmonic_count(c.degree), moments = harmonic_count(std::max(c.degree, 2));
        bytes += slots * (4 * (2 * terms + moments) + 12 + 90) + 12 * voxels;
        seconds += voxels * c.iterations * (20e-9 * double(directions) + 1e-6) + voxels * 1e-6 * double(lights);
        app.report()["estimate"]["directions"] = directions;
    }
    app.report()["estimate"]["bytes_per_active_voxel"] = voxels > 0 ? bytes / voxels : 0.0;
    app.report()["estimate"]["memory_bytes"] = bytes;
    app.report()["estimate"]["seconds"] = seconds;
    app.say("would solve for " + std::to_string(std::lround(voxels)) + " voxels in about " + app::brief(std::ceil(seconds)) +
            " s of processor time and " + app::brief(std::ceil(bytes / 1e6)) + " MB");
}

/// || a - b || / || b || over the voxels and channels of b.
double difference(const Vec3SGrid& a, const Vec3SGrid& b)
{
    auto at = a.getConstAccessor();
    double sum = 0, norm = 0;
    for (auto v = b.cbeginValueOn(); v; ++v) {
        sum += double((at.getValue(v.getCoord()) - *v).lengthSqr());
        norm += double(v->lengthSqr());
    }
    return norm > 0 ? std::sqrt(sum / norm) : 0;
}

/// Adds the series to the file, and replaces the direct solution by what the series gives for the albedo asked for.
void add_series(app::App& app, Options& o, GridFile& file, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium& medium, const std::vector<Light>& lights, ScatterFields& fields)
{
    const auto phase = app.phase("series");
    if (find_grid(file, schema::colour)) throw InputError(file.path + ": the series in albedo needs one albedo for all voxels, and there is a Cd");
    SeriesReport report;
    o.series.solve.progress = app.progress("series");
    for (const auto& grid : series_p1(density, emission, medium, lights, o.scatter, o.series, o.series_raw, report)) put_grid(file, grid);
    const double worst = std::max({report.estimate[0], report.estimate[1], report.estimate[2]});
    auto& r = app.report()["series"] = {{"norms", report.norm}, {"ratio", report.ratio}, {"convergence_estimate", worst},
                                        {"galerkin", o.series.galerkin}, {"least_albedo", report.least_albedo},
                                        {"iterations", report.iterations}};
    const double least = std::min({medium.albedo[0], medium.albedo[1], medium.albedo[2]});
    if (!o.series.galerkin && least < report.least_albedo)
        throw ConvergenceError("the series does not converge at albedo " + app::shortest(least) + ": each order is " + app::brief(worst) +
                               " times the one before; it needs an albedo above " + app::brief(report.least_albedo) + ", or --galerkin");
    const double forward = o.scatter.delta && medium.phase == PhaseKind::HenyeyGreenstein && medium.g > 0 ? medium.g * medium.g : 0;
    std::vector<GridBasePtr> transmittance;
    for (const Light& light : lights) transmittance.push_back(app::scaled_light_grid(app, density, nullptr, medium, forward, light));
    const ScatterFields relit = relight(file, medium, lights, transmittance);
    r["error_against_direct_solve"] = difference(*relit.phi, *fields.phi);
    fields.phi = relit.phi;
    if (relit.flux[0]) fields.flux = relit.flux;
}

void solve(app::App& app, Options& o)
{
    read_periodic(o);
    read_closure(app, o);
    auto file = app.read(o.input);
    const auto density = density_of(file, o.density, app.warnings());
    const Medium medium = app::chosen_medium(app, o.medium, *density);
    const auto lights = lights_for(app, o, file, *density, medium);
    if (get_text(*file.metadata, schema::up_axis, "Y") == "Z") o.scatter.closure.polar = 2;
    if (app.dry_run()) return estimate(app, o, medium, *density, lights.size());

    const auto tint = vectors(app, file, grid_of(file, schema::colour));
    const auto emission = vectors(app, file, find_grid(file, schema::emission));
    ScatterReport report;
    ScatterFields fields;
    {
        const auto phase = app.phase("p1");
        fields = scatter_p1(*density, tint.get(), emission.get(), medium, lights, o.scatter, app.progress("p1"), report);
    }
    fill_report(app, report);
    if (report.emission_outside) app.warnings()("emission outside the density does not light it: it is left out of multiple scattering");
    for (int c = 0; c < 3; ++c) {
        const P1Budget& b = report.channel[c].budget;
        if (b.negative > 0 && report.channel[c].solved_as == c)
            app.warnings()(std::to_string(b.negative) + " voxels have negative fluence, the least " + app::brief(b.smallest) +
                           (o.scatter.delta ? "" : ": --delta on avoids most of them"));
    }
    if (!report.converged && !o.allow_unconverged) {
        for (const ChannelReport& c : report.channel)
            if (!c.solve.converged)
                throw ConvergenceError("residual " + app::brief(c.solve.residual) + " and error estimate " + app::brief(c.solve.error) +
                                       " after " + std::to_string(c.solve.iterations) + " iterations: expected both below " +
                                       app::brief(o.scatter.solve.tolerance));
    }
    if (o.series.order > 0 && fields.phi) add_series(app, o, file, *density, emission.get(), medium, lights, fields);
    if (!fields.phi) app.warnings()("no voxel above 0: nothing to scatter in");
    if (fields.phi) {
        drop_moments(file);
        put_grid(file, fields.phi);
        for (const auto& flux : fields.flux) put_grid(file, flux);
        for (const auto& moment : fields.moments) put_grid(file, moment);
    }
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("p1solve", "Multiple scattering in a density by the P1 equations: fluence and flux beside what the file holds.");
    Options o;
    declare(app, o);
    return app.run(argc, argv, [&] { solve(app, o); });
}
