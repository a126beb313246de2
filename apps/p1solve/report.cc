#include "report.h"

#include "lights.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/scatter/scatter_plan.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>

namespace vdbcloud {

namespace {

nlohmann::json numbers(const std::array<double, 6>& v)
{
    return nlohmann::json(std::vector<double>(v.begin(), v.end()));
}

nlohmann::json described(const ClosureReport& c)
{
    nlohmann::json r = {{"directions", c.directions}, {"iterations", c.iterations}, {"converged", c.converged},
                        {"change", c.change},         {"seconds", c.seconds},       {"contraction", c.contraction}};
    if (c.error >= 0) r["error_estimate"] = c.error;
    for (const SolveResult& solve : c.solves) r["solver_iterations"].push_back(solve.iterations);
    return r;
}

/// Powers through the planes of the box.
void add_planes(const ChannelReport& c, int top, nlohmann::json& to)
{
    const PlanePower& p = c.planes;
    to["reflected"] = p.reflected;
    to["transmitted_diffuse"] = p.transmitted();
    to["out_by_plane"] = numbers(p.out);
    to["out_of_top"] = p.out[size_t(top)];
    to["out_of_base"] = p.out[size_t(top ^ 1)];
    double sides = 0, sky = 0;
    for (int face = 0; face < 6; ++face) {
        if (face / 2 != top / 2) sides += p.out[size_t(face)];
        sky += p.sky_in[size_t(face)];
    }
    to["out_of_sides"] = sides;
    to["sky_into_box"] = sky;
    to["entered_again"] = p.reentered;
    to["planes_scaled_by"] = p.scaled_by;
    to["from_ground"] = p.from_ground;
}

nlohmann::json described(const ChannelReport& c, int top, bool endless_ground)
{
    const P1Budget& b = c.budget;
    nlohmann::json r = {{"solved_as", std::string(1, "rgb"[c.solved_as])},
                        {"scale", c.scale},
                        {"iterations", c.solve.iterations},
                        {"converged", c.solve.converged},
                        {"residual", c.solve.residual},
                        {"error_estimate", c.solve.error},
                        {"residual_history", c.solve.history}};
    r["budget"] = {
        {"beam_lost_in_medium", c.deposited}, {"sky_in", b.sky_in}, {"emitted", c.emitted}, {"absorbed", b.absorbed},
        {"out_by_face", numbers(b.out)},      {"defect", b.defect}};
    if (c.planes.known) add_planes(c, top, r["budget"]);
    if (const GroundPower& ground = c.ground; endless_ground) {
        r["budget"]["shadow_on_ground"] = -ground.direct;
        r["budget"]["light_on_ground"] = ground.diffuse;
    } else if (ground.direct + ground.diffuse > 0) {
        r["budget"]["direct_on_ground"] = ground.direct;
        r["budget"]["from_ground"] = ground.sent_up;
        r["budget"]["absorbed_by_ground"] = ground.absorbed;
    }
    if (c.lines >= 0) {
        r["budget"]["beam_lost_by_lines"] = c.lines;
        r["budget"]["faces_against_lines"] = c.lines > 0 ? c.deposited / c.lines - 1 : 0.0;
    }
    if (c.reentry >= 0) r["budget"]["share_that_would_enter_again_and_is_lost"] = c.reentry;
    if (c.emission_by_rays)
        r["emission"] = {{"scaled_by", c.emission_scaled_by}, {"collisions", c.emission_collisions}};
    if (c.closure.iterations > 0) r["sweeps"] = described(c.closure);
    if (c.limiter.iterations > 0)
        r["limiter"] = {{"iterations", c.limiter.iterations},
                        {"change", c.limiter.change},
                        {"converged", c.limiter.converged},
                        {"least_factor", c.limiter.least}};
    r["phi"] = {{"smallest", b.smallest}, {"largest", b.largest}, {"negative_voxels", b.negative}};
    r["flux_limited_voxels"] = c.flux_limited;
    return r;
}

}  // namespace

void fill_report(app::App& app, const ScatterReport& report)
{
    auto& r = app.report();
    r["counts"] = {{"active_voxels", report.voxels},
                   {"blocks", report.blocks},
                   {"exposed_voxels", report.exposed},
                   {"solves", report.solves},
                   {"levels", report.levels}};
    app.add_work(report.work);
    r["memory"] = {{"array_bytes", report.bytes},
                   {"bytes_per_active_voxel", report.voxels ? double(report.bytes) / double(report.voxels) : 0.0}};
    const char* const channels[] = {"r", "g", "b"};
    for (int c = 0; c < 3; ++c)
        r["channels"][channels[c]] = described(report.channel[c], report.top, report.endless_ground);
}

void add_voxel_error(app::App& app, Accuracy& accuracy, const VoxelError& voxels)
{
    accuracy.add("voxel_error", voxels.error);
    app.report()["voxel_error"] = {{"estimate", voxels.error},
                                   {"order", voxels.order},
                                   {"against_twice_the_edge", voxels.twice},
                                   {"twice_against_four_times", voxels.four}};
}

namespace {

/// Adds the grids of lights that the file lacks.
void add_lights(app::Plan& plan, const P1solveOptions& o, const app::MediumInput& in, const std::vector<Light>& lights)
{
    for (const Light& light : lights) {
        if (adds_nothing(app::effects_asked(o.effects), light) || has_light(in, light, o.scatter.solids)) continue;
        TransmittanceOptions accuracy;
        accuracy.disc_samples = o.scatter.disc_samples;
        accuracy.periodic = in.periodic;
        const TransmittancePlan stored = transmittance_plan(*in.density, in.medium, light, accuracy, true);
        plan.work += stored.work;
        plan.work.add("write_byte", stored.value_bytes);
        plan.bytes += stored.grid_bytes;
    }
}

}  // namespace

app::Plan writing_plan(const P1solveOptions& o, const app::MediumInput& in, const std::vector<Light>& lights)
{
    app::Plan plan;
    for (const GridBasePtr& grid : in.file.grids) plan.work.add("write_byte", app::value_bytes(*grid));
    add_lights(plan, o, in, lights);
    return plan;
}

app::Plan plan_of(app::App& app, const P1solveOptions& o, const app::MediumInput& in, const Vec3SGrid* tint,
                  const Vec3SGrid* emission, const std::vector<Light>& lights)
{
    app::Plan plan;
    const bool count = app.dry_run();
    const FloatGrid& density = *in.density;
    plan.way_out = std::string("a coarser density") +
                   (o.scatter.closure.iterations > 0 ? ", a smaller --degree, or --iterations 0" : "");
    const ScatterPlan scatter = scatter_plan(density, tint, emission, in.medium, lights, o.scatter, count);
    plan.work = scatter.work;
    plan.bytes = scatter.bytes;
    if (count) {
        // Of grids that are replaced the new ones count twice: a file with the light of an earlier run is rare.
        for (const GridBasePtr& grid : in.file.grids) plan.work.add("write_byte", app::value_bytes(*grid));
        plan.work.add("write_byte", scatter.value_bytes);
    }
    if (o.series.order > 0) {
        const ScatterPlan series = series_plan(density, in.medium, lights, o.scatter, o.series, o.series_raw);
        ScatterOptions given = o.scatter;  // relight(): without a solve, which the tolerance stands for
        given.reentry_rays = 0;
        given.solve.tolerance = 0.5;
        const ScatterPlan relit = scatter_plan(density, nullptr, emission, in.medium, lights, given, count);
        plan.bytes = std::max(
            {plan.bytes, scatter.grid_bytes + series.bytes, scatter.grid_bytes + series.grid_bytes + relit.bytes});
        if (count) {
            plan.work += series.work;
            plan.work += relit.work;
            plan.work.add("write_byte", series.value_bytes);
        }
    }
    if (o.voxel_error) {
        const ScatterPlan voxels = voxel_error_plan(density, tint, emission, in.medium, lights, o.scatter, count);
        plan.work += voxels.work;
        plan.bytes = std::max(plan.bytes, scatter.grid_bytes + voxels.bytes);
    }
    if (!count) return plan;
    add_lights(plan, o, in, lights);
    auto& estimate = app.report()["estimate"];
    if (scatter.directions > 0) estimate["directions"] = scatter.directions;
    estimate["bytes_per_active_voxel"] = plan.bytes / std::max(1.0, double(density.activeVoxelCount()));
    return plan;
}

bool glows(const ScatterReport& report)
{
    return std::any_of(report.channel.begin(), report.channel.end(),
                       [](const ChannelReport& c) { return c.budget.sky_in > 0 || c.emitted > 0; });
}

void check_solution(app::App& app, const P1solveOptions& o, const Medium& medium, const ScatterReport& report)
{
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
    if (report.converged || o.allow_unconverged) return;
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

}  // namespace vdbcloud
