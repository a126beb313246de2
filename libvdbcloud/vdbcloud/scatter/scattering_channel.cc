#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/scattering.h"
#include "vdbcloud/scatter/world_axes.h"

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
        const P1Operator limited(index_, density(c), exposed_, medium);
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

void Scattering::count_sweeps(const SecondMoment& closure, double sweeps, bool follows)
{
    const auto directions = double(closure.set().count());
    note_work(follows ? "sweep_channel_voxel" : "sweep_voxel", sweeps * directions);
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

SolveResult Scattering::solve(const P1Operator& p1, Multigrid* multigrid, P1Source& source, std::vector<double>& phi,
                              const SolveOptions& options, const Fields& alike)
{
    const SolveResult result = multigrid ? solve_p1(p1, *multigrid, source, phi, options, alike)
                                         : relax_p1(p1, o_.relaxation, source, phi, options);
    note_work(multigrid ? "p1_iteration_voxel" : "p1_relaxation_voxel", result.iterations);
    return result;
}

}  // namespace vdbcloud
