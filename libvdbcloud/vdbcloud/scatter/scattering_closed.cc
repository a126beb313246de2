// Channels whose light sweeps close. Those of one extinction are swept together.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/scattering.h"
#include "vdbcloud/scatter/streaming.h"
#include "vdbcloud/scatter/world_axes.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

std::shared_ptr<const Scattering::Closing> Scattering::closing(int channel)
{
    const P1Medium medium = medium_of(channel);
    const double g = medium.phase.mean_cosine();
    const std::array<double, 2> of{medium.sigma_t_per_density, medium.albedo * g};
    const std::vector<float>*tint = g == 0 && !medium.mixed ? nullptr : medium.tint, *values = &density(channel);
    if (closing_ && closing_->of == of && closing_->tint == tint && closing_->density == values) return closing_;
    const P1Cells p1(index_, *values, medium);
    closing_ = std::make_shared<Closing>(Closing{of, values, tint, closure_exposed(p1, exposed_),
                                                 streaming_limit(p1, frame_of(index_, o_.periodic, o_.up))});
    note_work("sweep_voxel", streaming_directions);
    note_work("sweep_moment_voxel", streaming_directions);
    return closing_;
}

Scattering::ClosedMatrix Scattering::closed_matrix(const ChannelGroup& group,
                                                   const std::vector<std::unique_ptr<ClosedMatrix>>& others)
{
    const int channel = group.solves[0].channel;
    P1Medium medium = medium_of(channel);
    const auto closes = closing(channel);
    medium.limiter = &closes->limiter;
    const auto same = std::find_if(others.begin(), others.end(), [&](const auto& o) { return o->closing == closes; });
    P1Operator p1 = same == others.end() ? P1Operator(index_, density(channel), closes->exposed, medium)
                                         : P1Operator((*same)->p1, medium);
    note_work("p1_setup_voxel", 1);
    follow_emission(p1, group);
    const auto like = std::find_if(others.begin(), others.end(), [&](const auto& other) {
        return other->closing == closes && other->p1.uniform() && p1.uniform() &&
               other->p1.medium().albedo >= medium.albedo;
    });
    return {closes, std::move(p1), like == others.end() ? nullptr : like->get(), std::nullopt};
}

Multigrid& Scattering::hierarchy(ClosedMatrix& matrix)
{
    if (matrix.multigrid) return *matrix.multigrid;
    if (matrix.like)
        matrix.multigrid.emplace(matrix.p1.stencil(), *matrix.like->multigrid);
    else
        matrix.multigrid.emplace(matrix.p1.stencil());
    report_.levels = std::max(report_.levels, matrix.multigrid->levels());
    return *matrix.multigrid;
}

std::unique_ptr<Scattering::ClosedChannel> Scattering::open(ClosedMatrix& matrix, int c, SolveOptions options,
                                                            const std::vector<std::unique_ptr<ClosedChannel>>& others)
{
    const P1Operator& p1 = matrix.p1;
    auto channel = std::make_unique<ClosedChannel>(matrix.closing, p1, o_.closure.degree);
    const P1Operator& fine = channel->fine;
    SecondMoment& closure = channel->closure.emplace(fine, o_.closure, frame_of(index_, o_.periodic, o_.up),
                                                     &transport(), others.empty() ? nullptr : &*others[0]->closure);
    P1Source& base = channel->base.emplace(source_of(fine));
    std::vector<double>& phi = channel->phi;
    set_inflow(closure, c);
    // Light that is uncollided in P1's scaling but collided in this scaling starts along the beam.
    const bool along = o_.closure.degree > 1 && o_.delta && p1.uniform() && p1.mean_cosine() != 0;
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
    if (along) add_sky_and_glow(p1, c, *first);
    if (ground_) {
        if (!along) first = base;
        add_direct_ground(p1, c, *first);
    }
    std::vector<double> rhs;  // of `base`, where P1's source is that source
    if (!first) rhs = base.rhs;
    P1Source& source = first ? *first : base;
    options.tolerance = tolerance_before(o_.closure, o_.solve);
    std::vector<std::vector<float>> light;
    for (const auto& other : others) light.emplace_back(other->phi.begin(), other->phi.end());
    Fields alike;
    for (const auto& other : light) alike.push_back(&other);
    report_.channel[c].solve =
        solve(p1, o_.solver == P1Solver::Multigrid ? &hierarchy(matrix) : nullptr, source, phi, options, alike);
    light.clear();
    // At g = 0.85 P1's flux is far too long where light enters. From half of it one sweep leaves half the error
    // that the whole leaves, without a limit that two lights would not share. The fixed point does not depend on
    // it.
    if (closure.takes_flux()) closure.start_with_flux(cell_flux(p1, source, phi), 0.5);
    if (!first) base.rhs = std::move(rhs);
    for (size_t slot = 0; slot < ahead.size(); ++slot) phi[slot] += ahead[slot];
    if (o_.previous) start_with_previous(closure, c, phi);
    channel->ground = swept_ground(fine, c);
    if (channel->ground) closure.set_ground(&*channel->ground);
    channel->walls = lit_walls(fine, c);
    if (channel->walls) closure.set_walls(&*channel->walls);
    channel->planes = requested_planes();
    return channel;
}

void Scattering::start_with_previous(SecondMoment& closure, int c, std::vector<double>& phi)
{
    StartingLight start = starting_light(*o_.previous, index_, c, o_.closure.degree);
    const EmittedLight* light = emitted(c);  // which the file's phi has, and the sweeps' phi has not
    size_t known = 0;
    for (size_t slot = 0; slot < start.known.size(); ++slot) {
        if (!start.known[slot]) continue;
        ++known;
        phi[slot] = std::sqrt(4 * pi) * double(start.moments[0][slot]);
        if (!light) continue;
        phi[slot] = std::max(phi[slot] - light->fluence[slot], 0.0);
        for (size_t k = 1; k < std::min(start.moments.size(), light->moments.size()); ++k)
            start.moments[k][slot] -= light->moments[k][slot];
    }
    closure.start_with_moments(start.moments, start.known);
    report_.from_previous = known;
}

void Scattering::conclude(ClosedChannel& channel, int c, bool follows, ClosureReport&& of)
{
    ChannelReport& report = report_.channel[c];
    report.closure = std::move(of);
    note_patch(channel.ground);
    if (report.solve.converged) report.solve = report.closure.solves.back();
    for (const SolveResult& solve : report.closure.solves) {
        if (!solve.converged) report.solve = solve;
        note_work("p1_iteration_voxel", solve.iterations);
    }
    const SecondMoment& closure = *channel.closure;
    count_sweeps(closure, report.closure.iterations, follows);
    note_work("closure_voxel", report.closure.iterations);
    finish(channel.fine, *channel.base, c, channel.phi, nullptr, &channel.planes, report);
    if (scaling().last_degree() == 0) return;  // pictures take phi alone
    const int kept = std::min(o_.closure.degree, std::max(o_.keep_moments, 1));
    auto moments = channel.closure->take_moments();
    if (const EmittedLight* light = emitted(c))
        for (size_t k = 0; k < std::min(moments.size(), light->moments.size()); ++k)
            for (size_t slot = 0; slot < moments[k].size(); ++slot) moments[k][slot] += light->moments[k][slot];
    solution_[c].moments = moments_in_world(index_, moments, kept);
    solution_[c].flux = flux_of(solution_[c].moments);
}

void Scattering::solve_closed(const std::vector<const ChannelGroup*>& groups, int& done, int count,
                              const Progress& progress)
{
    std::vector<std::unique_ptr<ClosedMatrix>> matrices;
    std::vector<std::unique_ptr<ClosedChannel>> channels;
    std::vector<const ChannelGroup::Solve*> solves;
    std::vector<SecondMoment::Channel> swept;
    for (const ChannelGroup* group : groups)
        for (const ChannelGroup::Solve& solve : group->solves) solves.push_back(&solve);
    const auto part = [&](double f) { return !progress || progress((done + f * double(solves.size())) / count); };
    SolveOptions options = o_.solve;
    size_t bytes = 0;
    const size_t slots = index_.blocks().slots();
    for (const ChannelGroup* group : groups) {
        ClosedMatrix& matrix = *matrices.emplace_back(std::make_unique<ClosedMatrix>(closed_matrix(*group, matrices)));
        for (const ChannelGroup::Solve& solve : group->solves) {
            const auto opened = double(channels.size()), all = double(solves.size());
            options.progress = [&](double f) { return part(0.3 * (opened + f) / all); };
            channels.push_back(open(matrix, solve.channel, options, channels));
            ClosedChannel& channel = *channels.back();
            swept.push_back({&*channel.closure, &hierarchy(matrix), &*channel.base, &channel.phi, &channel.planes});
            bytes += channel.closure->bytes() + 12 * slots;  // and the source's right side, and the last excess
        }
        bytes += matrix.multigrid->bytes() + (matrices.size() > 1 ? matrix.p1.bytes() : 0);
    }
    // Besides, of the channel that is solved: right side and excess, swept fluence, the solver's direction.
    note_bytes(channels[0]->fine, 0, bytes + (16 + 8 + 4) * slots);
    options.progress = [&](double f) { return part(0.3 + 0.7 * f); };
    auto reports = SecondMoment::run(swept, options);
    matrices.clear();  // what follows needs their memory
    for (size_t k = 0; k < solves.size(); ++k, ++done) {
        const bool follows = k > 0 && o_.periodic == std::array<bool, 3>{};  // else each has sweeps of its own
        conclude(*channels[k], solves[k]->channel, follows, std::move(reports[k]));
        keep(*solves[k], channels[k]->phi);
        channels[k].reset();
    }
}

}  // namespace vdbcloud
