// p1solve: light that is scattered many times, by the paper's expansion in spherical harmonics cut after the first.
//
//   p1solve light.vdb --albedo 0.9999 --g 0.85 -o lit.vdb
//   fractalgen -o - | illuminate - --sun 0.3,1,0.2 -o - | p1solve - --albedo 0.9999 --g 0.85 -o - | render - -o cloud.exr
//   p1solve slab.vdb --sun 0.5,1,0 --periodic xz -o slab.lit.vdb        a cloud layer without end
//
//   p1solve light.vdb --g 0.85 --iterations 5 --directions 64 --degree 3 -o lit.vdb    on to the transport equation, by sweeps
//
// Kajiya & Von Herzen 1984, section 4 (high albedo). Writes phi (fluence) and flux of the collided light beside all
// that the input holds; the uncollided light is the transmittance grids', and render adds both.
#include "options.h"
#include "report.h"
#include "scaled_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <algorithm>
#include <cmath>

using namespace vdbcloud;

namespace {

/// Moments of an earlier run: they belong to a phi that is replaced.
void drop_moments(GridFile& file)
{
    remove_grids(file, [](const std::string& name) { return schema::has_role(name, schema::Role::Moment); });
}

/// The vec3s grid of a role, if there is one.
Vec3SGridPtr vectors(app::App& app, const GridFile& file, const GridBasePtr& grid)
{
    if (!grid || grid->empty()) return nullptr;
    if (auto found = openvdb::gridPtrCast<Vec3SGrid>(grid)) return found;
    app.warnings()(file.path + ": grid '" + printable(grid->getName()) + "' is " + grid->valueType() +
                   ", expected vec3s; passed over");
    return nullptr;
}

/// The lights asked for, else the file's, else a sun if nothing shines. What the file has no transmittance for gets
/// one, as render needs it.
std::vector<Light> lights_for(app::App& app, const P1solveOptions& o, GridFile& file, const FloatGrid& density,
                              const Medium& medium)
{
    auto lights = app::lights_asked(o.lights);
    if (lights.empty()) lights = lights_of(file);
    const bool sky = o.sky.size() || app::sky_asked(o.sky_shape), glow = bool(find_grid(file, schema::emission));
    if (lights.empty() && !sky && !glow) {
        lights.push_back(app::automatic_sun(vector_of(read_up_axis(*file.metadata).value_or(UpAxis::Y))));
        app.say("no light asked for: a " + app::described(lights[0]));
    }
    for (const Light& light : lights) {
        app.uses(transmittance_name(light));
        if (app.dry_run() || o.periodic.size()) continue;
        const GridBasePtr there = find_grid(file, transmittance_name(light));
        const auto theirs = there ? read_light(*there, there->getName()) : std::nullopt;
        if (theirs && same_place(*theirs, light) && theirs->strength() == light.strength() &&
            app::same_extinction(*there, medium) &&
            get_text(*there, schema::density_digest, "") == grid_digest(density))
            continue;
        const auto phase = app.phase(transmittance_name(light));
        put_grid(file, transmittance_grid(density, medium, light, {}, app.progress(light.name)));
    }
    return lights;
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
void add_series(app::App& app, P1solveOptions& o, GridFile& file, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium& medium, const std::vector<Light>& lights, ScatterFields& fields)
{
    const auto phase = app.phase("series");
    if (find_grid(file, schema::colour))
        throw InputError(file.path + ": the series in albedo needs one albedo for all voxels, and there is a Cd");
    SeriesReport report;
    o.series.solve.progress = app.progress("series");
    for (const auto& grid : series_p1(density, emission, medium, lights, o.scatter, o.series, o.series_raw, report))
        put_grid(file, grid);
    const double worst = std::max({report.estimate[0], report.estimate[1], report.estimate[2]});
    auto& r = app.report()["series"] = {{"norms", report.norm},
                                        {"ratio", report.ratio},
                                        {"convergence_estimate", worst},
                                        {"galerkin", o.series.galerkin},
                                        {"least_albedo", report.least_albedo},
                                        {"iterations", report.iterations}};
    const double least = std::min({medium.albedo[0], medium.albedo[1], medium.albedo[2]});
    if (!o.series.galerkin && least < report.least_albedo)
        throw ConvergenceError("the series does not converge at albedo " + app::shortest(least) + ": each order is " +
                               app::brief(worst) + " times the one before; it needs an albedo above " +
                               app::brief(report.least_albedo) + ", or --galerkin");
    std::vector<GridBasePtr> transmittance;
    for (const Light& light : lights)
        transmittance.push_back(app::scaled_light_grid(app, density, nullptr, medium, fields.scaling, light));
    const ScatterFields relit = relight(file, medium, lights, transmittance);
    r["error_against_direct_solve"] = difference(*relit.phi, *fields.phi);
    fields.phi = relit.phi;
    if (relit.flux[0]) fields.flux = relit.flux;
}

void solve(app::App& app, P1solveOptions& o)
{
    finish(app, o);
    auto file = app.read(o.input);
    const auto density = density_of(file, o.density, app.warnings());
    app.uses(density->getName());
    const Medium medium = app::chosen_medium(app, o.medium, *density);
    const auto lights = lights_for(app, o, file, *density, medium);
    o.rays_per_voxel.check_effect(!lights.empty(), "--sun or --lamp");
    const UpAxis up = read_up_axis(*file.metadata).value_or(UpAxis::Y);
    o.scatter.up = vector_of(up);
    o.scatter.sky = chosen_sky(o, lights, o.scatter.up);
    if (app.dry_run()) return estimate(app, o, medium, *density, lights.size());

    const auto tint = vectors(app, file, grid_of(file, schema::colour));
    const auto emission = vectors(app, file, find_grid(file, schema::emission));
    if (tint) app.uses(grid_of(file, schema::colour)->getName());
    if (emission) app.uses(emission->getName());
    ScatterReport report;
    ScatterFields fields;
    {
        const auto phase = app.phase("p1");
        fields =
            scatter_p1(*density, tint.get(), emission.get(), medium, lights, o.scatter, app.progress("p1"), report);
    }
    fill_report(app, report);
    if (report.emission_outside)
        app.warnings()("emission outside the density does not light it: it is left out of multiple scattering");
    for (int c = 0; c < 3; ++c) {
        const P1Budget& b = report.channel[c].budget;
        if (b.negative > 0 && report.channel[c].solved_as == c)
            app.warnings()(std::to_string(b.negative) + " voxels have negative fluence, the least " +
                           app::brief(b.smallest) +
                           (!o.scatter.delta ? ": --delta on avoids most of them"
                            : medium.phase.mean_cosine() > 2.0 / 7
                                ? ": P1's own on the lit side of thin parts where g is above 2/7"
                                : ""));
    }
    if (!report.converged && !o.allow_unconverged) {
        for (const ChannelReport& c : report.channel)
            if (c.solve.converged && !c.limiter.converged)
                throw ConvergenceError("the flux limiter changes phi by " + app::brief(c.limiter.change) + " after " +
                                       std::to_string(c.limiter.iterations) + " solves: expected below " +
                                       app::brief(o.scatter.limiter_change));
        for (const ChannelReport& c : report.channel)
            if (!c.solve.converged)
                throw ConvergenceError("residual " + app::brief(c.solve.residual) + " and error estimate " +
                                       app::brief(c.solve.error) + " after " + std::to_string(c.solve.iterations) +
                                       " iterations: expected both below " + app::brief(o.scatter.solve.tolerance));
    }
    if (o.series.order > 0 && fields.phi) add_series(app, o, file, *density, emission.get(), medium, lights, fields);
    if (!fields.phi) app.warnings()("no voxel above 0: nothing to scatter in");
    if (fields.phi) {
        drop_moments(file);
        put_grid(file, fields.phi);
        for (const auto& flux : fields.flux) put_grid(file, flux);
        for (const auto& of_channel : fields.moments)
            for (const auto& moment : of_channel) put_grid(file, moment);
    }
    app.write(o.output, file);
}

}  // namespace

int main(int argc, char** argv)
{
    app::App app("p1solve",
                 "Multiple scattering in a density by the P1 equations: fluence and flux beside what the file holds.");
    P1solveOptions o;
    declare(app, o);
    return app.run(argc, argv, [&] { solve(app, o); });
}
