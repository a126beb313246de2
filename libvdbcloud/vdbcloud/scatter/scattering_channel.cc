#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/scattering.h"
#include "vdbcloud/scatter/streaming.h"
#include "vdbcloud/scatter/world_axes.h"

#include <algorithm>

namespace vdbcloud {

void Scattering::keep_p1(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                         ChannelReport& report)
{
    auto flux = cell_flux(p1, source, phi);
    PlaneLight planes = requested_planes();
    const bool swept = o_.flux_map || endless_;
    if (swept) sweep_planes(p1, c, phi, flux, planes, report);
    finish(p1, source, c, phi, &flux, swept ? &planes : nullptr, report);
    std::vector<double> whole = phi;
    if (const EmittedLight* light = emitted(c)) add_light(*light, whole, flux);
    if (p1.mean_cosine() != 0) {
        auto shortened = flux;  // as pictures will
        report.flux_limited = limit_flux(p1, whole, shortened);
    }
    solution_[c].flux = flux_in_world(index_, std::move(flux));
}

void Scattering::add_light(const EmittedLight& light, std::vector<double>& phi,
                           std::array<std::vector<float>, 3>& flux) const
{
    const auto own = flux_of(light.moments);
    for (size_t slot = 0; slot < phi.size(); ++slot) {
        phi[slot] += light.fluence[slot];
        for (size_t a = 0; a < 3; ++a) flux[a][slot] += own[a][slot];
    }
}

void Scattering::limit(const P1Operator& p1, const P1Source& p1_source, int c, std::vector<double>& phi,
                       ChannelReport& report)
{
    FluxLimiter limiter(index_.blocks());
    P1Medium medium = p1.medium();
    medium.limiter = &limiter.factor();
    auto flux = cell_flux(p1, p1_source, phi);
    LimiterReport& done = report.limiter;
    for (;;) {
        limiter.update(phi, flux);
        const P1Operator limited(index_, density_, exposed_, medium);
        P1Source source = source_of(limited);
        report.lines = -1;
        add_beams(limited, {{&source, c}}, {});
        add_sky_and_glow(limited, c, source);
        Multigrid multigrid(limited.stencil());
        const std::vector<double> before = phi;
        report.solve = solve_p1(limited, multigrid, source, phi, o_.solve);
        note_work("p1_setup_voxel", 1);
        note_work("p1_iteration_voxel", report.solve.iterations);
        done.change = relative_change(phi, before);
        done.converged = done.change < o_.limiter_change;
        if (++done.iterations < o_.limiter_iterations && !done.converged && report.solve.converged) {
            flux = cell_flux(limited, source, phi);
            continue;
        }
        done.least = limiter.least();
        report_.converged = report_.converged && done.converged;
        return keep_p1(limited, source, c, phi, report);
    }
}

void Scattering::count_sweeps(const SecondMoment& closure, double sweeps)
{
    const auto directions = double(closure.set().count());
    note_work("sweep_voxel", sweeps * directions);
    note_work("sweep_moment_voxel", sweeps * directions * double(closure.moments().size()));
}

TransportSweep& Scattering::transport()
{
    if (!transport_) transport_ = std::make_unique<TransportSweep>(index_, faces_of(exposed_));
    return *transport_;
}

SecondMoment Scattering::plane_sweep(const P1Operator& p1, int c, ChannelReport& report)
{
    ClosureOptions options = o_.closure;
    options.degree = 1;
    SecondMoment closure(p1, options, frame_of(index_, o_.periodic, o_.up), &transport());
    set_inflow(closure, c);
    const double lines = report.lines;  // add_beams() measures them again
    P1Source unused(p1);
    add_beams(p1, {{&unused, c}}, {},
              [&](const BeamDepths& depths, const std::vector<float>& centre, double extinction,
                  const std::optional<Vec3d>& disc) {
                  closure.add_uncollided(depths.light, beam_fluence(p1, depths, centre, extinction),
                                         depths.light.strength()[c], disc);
              });
    report.lines = lines;
    add_emission_to(closure, c);
    return closure;
}

void Scattering::sweep_planes(const P1Operator& p1, int c, const std::vector<double>& phi,
                              std::array<std::vector<float>, 3> flux, PlaneLight& planes, ChannelReport& report)
{
    SecondMoment closure = plane_sweep(p1, c, report);
    // A limit would not let the ground's light of several lights add up.
    if (!endless_) limit_flux(p1, phi, flux);
    closure.start_with_flux(flux, endless_ ? 0.5 : 1);
    auto ground = swept_ground(p1, c);
    if (ground) closure.set_ground(&*ground);
    closure.sweep_planes(phi, &planes);
    count_sweeps(closure, 1);
    note_patch(ground);
}

void Scattering::add_patch(const P1Operator& p1, const P1Source& unlit, int c,
                           const std::function<void(P1Source&)>& solve, std::vector<double>& phi, P1Source& source,
                           ChannelReport& report)
{
    const int rounds = endless_->albedo() > 0 ? 6 : 1;  // each leaves a tenth, under wide slabs 0.4, of its change
    SecondMoment closure = plane_sweep(p1, c, report);
    auto ground = swept_ground(p1, c);
    closure.set_ground(&*ground);
    ground->irradiance.assign(ground->direct.size(), 0.0f);
    for (int round = 0; round < rounds; ++round) {
        source = unlit;
        endless_->add_to(p1, endless_->radiance_change(ground->direct, ground->irradiance), closure.set(), source);
        report_.work.add("ground_face", double(exposed_.size() * closure.set().count()));
        solve(source);
        if (round + 1 == rounds) return;
        const auto flux = cell_flux(p1, source, phi);
        closure.start_with_flux(flux, 0.5);
        closure.sweep_planes(phi, nullptr);
        count_sweeps(closure, 1);
        closure.start_with_flux(flux, -0.5);  // the next round has its own
    }
}

const Scattering::Closing& Scattering::closing(const P1Medium& medium)
{
    const double g = medium.phase.mean_cosine();
    const std::array<double, 2> of{medium.sigma_t_per_density, medium.albedo * g};
    const std::vector<float>* tint = g == 0 ? nullptr : medium.tint;
    if (closing_ && closing_->of == of && closing_->tint == tint) return *closing_;
    const P1Cells p1(index_, density_, medium);
    closing_.emplace(
        Closing{of, tint, closure_exposed(p1, exposed_), streaming_limit(p1, frame_of(index_, o_.periodic, o_.up))});
    note_work("sweep_voxel", streaming_directions);
    note_work("sweep_moment_voxel", streaming_directions);
    return *closing_;
}

SolveResult Scattering::solve(const P1Operator& p1, Multigrid* multigrid, P1Source& source, std::vector<double>& phi,
                              const SolveOptions& options)
{
    const SolveResult result =
        multigrid ? solve_p1(p1, *multigrid, source, phi, options) : relax_p1(p1, o_.relaxation, source, phi, options);
    note_work(multigrid ? "p1_iteration_voxel" : "p1_relaxation_voxel", result.iterations);
    return result;
}

void Scattering::close(const P1Operator& p1, Multigrid& multigrid, int c, SolveOptions options,
                       std::vector<double>& phi, ChannelReport& report)
{
    const P1Operator fine(p1, o_.closure.degree);
    SecondMoment closure(fine, o_.closure, frame_of(index_, o_.periodic, o_.up), &transport());
    set_inflow(closure, c);
    // Light that is uncollided in P1's scaling but collided in this scaling starts along the beam.
    const bool along = o_.closure.degree > 1 && o_.delta && p1.uniform_albedo() && p1.mean_cosine() != 0;
    P1Source base = source_of(fine);
    std::optional<P1Source> first;  // of P1 in its own scaling
    std::vector<double> ahead;
    if (along) {
        first.emplace(p1);
        ahead.assign(index_.blocks().slots(), 0.0);
    }
    add_closed_beams(fine, c, closure, base,
                     [&](const BeamDepths& depths, const std::vector<float>& centre, double extinction,
                         const std::optional<Vec3d>& disc) {
                         const Light& light = depths.light;
                         const double strength = light.strength()[c];
                         add_beam_profile(fine, depths, extinction, {{&base, strength}});
                         const auto late = beam_fluence(fine, depths, centre, extinction);
                         closure.add_uncollided(light, late, strength, disc);
                         if (!along) return;
                         add_beam(p1, depths, beam_extinction(p1), {{&*first, strength}});
                         auto early = beam_fluence(p1, depths, centre, beam_extinction(p1));
                         for (size_t slot = 0; slot < early.size(); ++slot) {
                             early[slot] -= late[slot];
                             ahead[slot] += strength * early[slot];
                         }
                         closure.start_with(light, early, strength);
                     });
    add_sky_and_glow(fine, c, base);
    add_emission_to(closure, c);
    if (along)
        add_sky_and_glow(p1, c, *first);
    else
        first = base;
    if (ground_) ground_->add_direct(p1, ground_->direct(beam_medium(p1), beams_, c), *first);
    // Besides: the source with its fluxes and a copy of its right side, fluence, the solver's vectors, fluxes of
    // close().
    note_bytes(fine, 0, multigrid.bytes() + closure.bytes() + (40 + 16 + 12 + 8) * index_.blocks().slots());
    options.tolerance = tolerance_before(o_.closure, o_.solve);
    report.solve = solve(p1, o_.solver == P1Solver::Multigrid ? &multigrid : nullptr, *first, phi, options);
    // At g = 0.85 P1's flux is far too long where light enters. From half of it one sweep leaves half the error
    // that the whole leaves, without a limit that two lights would not share. The fixed point does not depend on
    // it.
    if (closure.takes_flux()) closure.start_with_flux(cell_flux(p1, *first, phi), 0.5);
    first.reset();
    for (size_t slot = 0; slot < ahead.size(); ++slot) phi[slot] += ahead[slot];
    ahead = {};
    auto ground = swept_ground(fine, c);
    if (ground) closure.set_ground(&*ground);
    PlaneLight planes = requested_planes();
    report.closure = closure.run(multigrid, o_.solve, base, phi, &planes);
    note_patch(ground);
    if (report.solve.converged) report.solve = report.closure.solves.back();
    for (const SolveResult& solve : report.closure.solves) {
        if (!solve.converged) report.solve = solve;
        note_work("p1_iteration_voxel", solve.iterations);
    }
    count_sweeps(closure, report.closure.iterations);
    note_work("closure_voxel", report.closure.iterations);
    finish(fine, base, c, phi, nullptr, &planes, report);
    const int kept = std::min(o_.closure.degree, std::max(o_.keep_moments, 1));
    auto moments = closure.moments();
    if (const EmittedLight* light = emitted(c))
        for (size_t k = 0; k < std::min(moments.size(), light->moments.size()); ++k)
            for (size_t slot = 0; slot < moments[k].size(); ++slot) moments[k][slot] += light->moments[k][slot];
    solution_[c].moments = moments_in_world(index_, moments, kept);
    solution_[c].flux = flux_of(solution_[c].moments);
}

}  // namespace vdbcloud
