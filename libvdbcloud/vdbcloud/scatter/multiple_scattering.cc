#include "vdbcloud/scatter/multiple_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/channel_groups.h"
#include "vdbcloud/scatter/channel_report.h"
#include "vdbcloud/scatter/collided_grids.h"
#include "vdbcloud/scatter/emitted_light.h"
#include "vdbcloud/scatter/ground.h"
#include "vdbcloud/scatter/heating.h"
#include "vdbcloud/scatter/world_axes.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace vdbcloud {

namespace {

/// A ground hides the sky below the horizon.
ScatterOptions with_horizon(ScatterOptions options)
{
    options.sky.ends_at_horizon = options.ground_albedo.has_value();
    return options;
}

class Scattering {
public:
    Scattering(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
               const std::vector<Light>& lights, const ScatterOptions& options, ScatterReport& report)
        : grid_(density), sources_(sources_of(density, tint, emission)), medium_(medium), lights_(lights),
          beams_(points_of(lights, options.disc_samples)), o_(with_horizon(options)), report_(report),
          index_(density, {options.periodic}), density_(index_.gather(density)),
          exposed_(exposed_voxels(index_, density_))
    {
        for (const Light& light : lights)
            towards_.resize(towards_.size() + light.points(options.disc_samples).size(), light->common_direction());
        for (int c = 0; c < 3; ++c) {
            if (tint) tint_[c] = index_.gather(*tint, c);
            if (emission) emission_[c] = index_.gather(*emission, c);
        }
        if (tint && tint_[0] == tint_[1] && tint_[0] == tint_[2]) tint_[1] = tint_[2] = {};
        if (emission && emission_[0] == emission_[1] && emission_[0] == emission_[2]) emission_[1] = emission_[2] = {};
        if (tint) clamp_tint();
        periodic_ = index_.blocks().period() != Vec3i(0, 0, 0);
        report.voxels = index_.blocks().active_count();
        report.blocks = index_.blocks().count();
        report.exposed = exposed_.size();
        const int axis = frame_of(index_, {false, false, false}, o_.up).polar;
        report.top = 2 * axis + (index_.axis(axis).dot(o_.up) > 0);
        if (o_.flux_map) report.flux_map = columns_of(index_, o_.up);
        if (!o_.ground_albedo || report.blocks == 0) return;
        ground_.emplace(index_, o_.up, *o_.ground_albedo);
        ground_->mark(exposed_);
        if (o_.closure.iterations == 0) ground_->require_cover();
    }

    CollidedLight run(const Progress& progress)
    {
        CollidedLight fields;
        if (index_.blocks().count() == 0) return fields;
        const auto all = groups();
        int done = 0, count = 0;
        for (const ChannelGroup& group : all) count += int(group.solves.size());
        for (const ChannelGroup& group : all) solve_group(group, done, count, progress);

        if (o_.heating) put_heating();
        if (ground_) put_ground();
        fields.scaling = scaling();
        if (o_.closure.iterations == 0 && fields.scaling.mean_cosine() != 0) fields.flux_limit = longest_flux;
        collided_grids(
            index_, solution_, share_, std::min(degree(), o_.keep_moments), [&](GridBase& grid) { stamp(grid); },
            fields);
        return fields;
    }

    const FluenceOf* given = nullptr;  ///< P1's fluence, where it is known without a solve

private:
    const std::vector<float>* tint(int channel) const
    {
        if (tint_[0].empty()) return nullptr;
        return tint_[channel].empty() ? &tint_[0] : &tint_[channel];
    }
    const std::vector<float>* emission(int channel) const
    {
        if (emission_[0].empty()) return nullptr;
        return emission_[channel].empty() ? &emission_[0] : &emission_[channel];
    }

    /// Keeps w0 = albedo x tint within [0, 1], as render does.
    void clamp_tint()
    {
        for (int c = 0; c < 3; ++c)
            for (float& t : tint_[c])
                t = std::max(0.0f, medium_.albedo[c] > 0 ? std::min(t, float(1 / medium_.albedo[c])) : t);
    }

    /// Groups of channels that share a matrix or a solution.
    std::vector<ChannelGroup> groups() const
    {
        std::array<ChannelInput, 3> input;
        for (int c = 0; c < 3; ++c) {
            ChannelInput& of = input[size_t(c)];
            of.matrix = {medium_.sigma_t_per_density[c], medium_.albedo[c]};
            of.tint = tint(c);
            of.emission = emission(c);
            for (const Light& light : lights_) of.light.push_back(light.strength()[c]);
            for (const Vec3d& sky : {o_.sky.zenith, o_.sky.horizon, o_.sky.ground}) of.light.push_back(sky[c]);
            of.light.push_back(of.emission ? 1.0 : 0.0);
        }
        return group_channels(input);
    }

    BeamMedium beam_medium(const P1Operator& p1) const { return BeamMedium(index_, grid_, density_, p1); }

    /// Adds the beams of all lights in the medium of a channel. Density depths are cached if all channels share them.
    /// `note`, if given, is called with each light's depths at faces and at centres, the extinction, and the middle of
    /// the sun that the light is a part of.
    void add_beams(const P1Operator& p1, const std::vector<std::pair<P1Source*, int>>& sources,
                   const Progress& progress,
                   const std::function<void(const BeamDepths&, const std::vector<float>&, double,
                                            const std::optional<Vec3d>&)>& note = {})
    {
        if (beams_.empty()) return;
        const BeamMedium medium = beam_medium(p1);
        for (size_t l = 0; l < beams_.size(); ++l) {
            const Light& light = beams_[l];
            const Progress part =
                progress ? Progress([&](double f) { return progress((double(l) + f) / double(beams_.size())); })
                         : Progress();
            const BeamDepths depths = medium.depths(exposed_, light, o_.rays_per_voxel, part);
            note_bytes(p1, sources.size(), 20 * index_.blocks().slots());
            std::vector<std::pair<P1Source*, double>> channels;
            for (const auto& [source, channel] : sources) channels.emplace_back(source, light.strength()[channel]);
            add_beam(p1, depths, medium.extinction(), channels);
            if (note) note(depths, medium.centres(light, o_.rays_per_voxel), medium.extinction(), towards_[l]);
            if (!light->common_direction() || !o_.line_rays) continue;
            const double lost = medium.lost_by_lines(light);
            for (const auto& [source, channel] : sources) {
                auto& lines = report_.channel[channel].lines;
                lines = std::max(lines, 0.0) + lost * light.strength()[channel];
            }
        }
        const bool lamps =
            std::any_of(lights_.begin(), lights_.end(), [](const Light& l) { return !l->common_direction(); });
        for (const auto& [source, channel] : sources)
            if (lamps) report_.channel[channel].lines = -1;
    }

    bool by_rays() const { return o_.emission_by_rays && !o_.limiter && !periodic_ && !given; }

    /// Follows the emission of a group's channels by rays.
    void follow_emission(const P1Operator& p1, const ChannelGroup& group)
    {
        std::vector<const std::vector<float>*> of;
        std::vector<int> channels;
        for (const ChannelGroup::Solve& solve : group.solves)
            if (emission(solve.channel)) {
                of.push_back(emission(solve.channel));
                channels.push_back(solve.channel);
            }
        if (of.empty() || !by_rays() || !is_compact(index_.blocks(), of)) return;
        P1Medium medium = p1.medium();
        medium.degree = degree();
        const P1Operator scaled(index_, density_, exposed_, medium);
        auto light = emitted_light(scaled, beam_medium(scaled), of);
        for (size_t k = 0; k < channels.size(); ++k) {
            ChannelReport& report = report_.channel[channels[k]];
            report.emission_by_rays = true;
            report.emission_scaled_by = light[k].scaled_by;
            report.emission_collisions = light[k].collisions;
            emitted_[channels[k]] = std::move(light[k]);
        }
    }

    const EmittedLight* emitted(int channel) const { return emitted_[channel] ? &*emitted_[channel] : nullptr; }

    /// Emission as the sweeps take it.
    void add_emission_to(SecondMoment& closure, int c) const
    {
        if (const EmittedLight* light = emitted(c)) {
            closure.add_uncollided(light->moments);
            closure.add_emission(light->followed, -1);
        } else if (emission(c))
            closure.add_emission(*emission(c), 1);
    }

    void note_bytes(const P1Operator& p1, size_t sources, size_t besides)
    {
        const size_t slots = index_.blocks().slots();
        size_t now =
            p1.stencil().bytes() + slots * (4 + 8 * sources) + besides + exposed_.size() * sizeof(ExposedVoxel);
        if (medium_.phase.mean_cosine() != 0) now += 12 * slots * sources;
        report_.bytes = std::max(report_.bytes, now);
    }

    void solve_group(const ChannelGroup& group, int& done, int count, const Progress& progress)
    {
        const int first = group.solves[0].channel;
        P1Medium medium{medium_.sigma_t_per_density[first], medium_.albedo[first], tint(first), medium_.phase,
                        o_.delta};
        medium.ground_albedo = o_.ground_albedo.value_or(0);
        const P1Operator p1(index_, density_, exposed_, medium);
        std::vector<P1Source> sources(group.solves.size(), source_of(p1));
        std::vector<std::pair<P1Source*, int>> lit;
        for (size_t k = 0; k < sources.size(); ++k) lit.emplace_back(&sources[k], group.solves[k].channel);
        const auto part = [&](double f) { return !progress || progress((done + f) / count); };
        add_beams(p1, lit, [&](double f) { return part(0.3 * f); });
        follow_emission(p1, group);
        for (size_t k = 0; k < sources.size(); ++k) {
            const int c = group.solves[k].channel;
            add_sky_and_glow(p1, c, sources[k]);
            if (ground_) ground_->add_direct(p1, ground_->direct(beam_medium(p1), beams_, c), sources[k]);
        }
        std::optional<Multigrid> multigrid;
        if (o_.solver == P1Solver::Multigrid) {
            multigrid.emplace(p1.stencil());
            report_.levels = std::max(report_.levels, multigrid->levels());
        }
        note_bytes(p1, sources.size(), (multigrid ? multigrid->bytes() : 0) + 20 * index_.blocks().slots());
        for (size_t k = 0; k < sources.size(); ++k, ++done) {
            SolveOptions solve = o_.solve;
            solve.progress = [&](double f) { return part(0.3 + 0.7 * f); };
            std::vector<double> phi;
            const int c = group.solves[k].channel;
            ChannelReport& report = report_.channel[c];
            if (given) {
                phi = (*given)(index_, c);
                report.solve = judge_p1(p1, *multigrid, sources[k], phi);
            } else {
                report.solve = multigrid ? solve_p1(p1, *multigrid, sources[k], phi, solve)
                                         : relax_p1(p1, o_.relaxation, sources[k], phi, solve);
            }
            if (o_.closure.iterations > 0) {
                close(p1, sources[k], c, phi, report);
            } else if (o_.limiter) {
                limit(p1, sources[k], c, phi, report);
            } else {
                keep_p1(p1, sources[k], c, phi, report);
            }
            solution_[c].phi.assign(phi.begin(), phi.end());
            if (const EmittedLight* light = emitted(c))
                for (size_t slot = 0; slot < phi.size(); ++slot) solution_[c].phi[slot] += light->fluence[slot];
            emitted_[c].reset();
            share_[c] = {c, 1};
            for (const auto& [channel, scale] : group.solves[k].shared) share(c, channel, scale);
            ++report_.solves;
        }
    }

    void add_sky_and_glow(const P1Operator& p1, int c, P1Source& source) const
    {
        if (!o_.sky.dark()) add_sky(p1, sky_on_faces(index_, o_.sky, c), source);
        if (const EmittedLight* light = emitted(c))
            add_emitted(p1, *light, source);
        else if (emission(c))
            add_emission(p1, *emission(c), 1, source);
    }

    void keep_p1(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                 ChannelReport& report)
    {
        auto flux = cell_flux(p1, source, phi);
        PlaneLight planes;
        if (o_.flux_map) sweep_planes(p1, c, phi, flux, planes, report);
        finish(p1, source, c, phi, &flux, o_.flux_map ? &planes : nullptr, report);
        std::vector<double> whole = phi;
        if (const EmittedLight* light = emitted(c)) add_light(*light, whole, flux);
        if (p1.mean_cosine() != 0) {
            auto shortened = flux;  // as pictures will
            report.flux_limited = limit_flux(p1, whole, shortened);
        }
        solution_[c].flux = flux_in_world(index_, std::move(flux));
    }

    /// Adds uncollided light to collided light, components along the index axes.
    void add_light(const EmittedLight& light, std::vector<double>& phi, std::array<std::vector<float>, 3>& flux) const
    {
        const auto own = flux_of(light.moments);
        for (size_t slot = 0; slot < phi.size(); ++slot) {
            phi[slot] += light.fluence[slot];
            for (size_t a = 0; a < 3; ++a) flux[a][slot] += own[a][slot];
        }
    }

    /// Flux-limited diffusion of one channel: solves repeatedly, each time with factors from the last solution.
    void limit(const P1Operator& p1, const P1Source& p1_source, int c, std::vector<double>& phi, ChannelReport& report)
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

    /// P1's source, with room for what the request needs.
    P1Source source_of(const P1Operator& p1) const
    {
        P1Source source(p1);
        if (o_.heating || o_.flux_map) source.beam_absorbed.assign(index_.blocks().slots(), 0.0);
        return source;
    }

    /// P1's light on the planes, with the angular detail of one sweep.
    void sweep_planes(const P1Operator& p1, int c, const std::vector<double>& phi,
                      std::array<std::vector<float>, 3> flux, PlaneLight& planes, ChannelReport& report)
    {
        ClosureOptions options = o_.closure;
        options.degree = 1;
        SecondMoment closure(p1, options, frame_of(index_, o_.periodic, o_.up));
        if (!o_.sky.dark()) closure.set_sky(sky_along(index_, o_.sky, c, closure.set().direction));
        limit_flux(p1, phi, flux);
        closure.start_with_flux(flux);
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
        SweepGround ground = swept_ground(p1, c);
        if (ground_) closure.set_ground(&ground);
        closure.sweep_planes(phi, planes);
    }

    /// `flux`: of P1 alone, else null. `swept`: null without a sweep.
    void finish(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                const std::array<std::vector<float>, 3>* flux, const PlaneLight* swept, ChannelReport& report)
    {
        report.budget = budget(p1, source, phi);
        report.deposited = source.deposited;
        report.beam_in = source.beam_in;
        report.beam_out = source.beam_out;
        report.emitted = source.emitted;
        report_.converged = report_.converged && report.solve.converged;
        const PlaneGround ground = ground_under(p1, source, c, phi, flux != nullptr);
        const OutflowRays rays =
            trace_outflow(p1, source, phi, flux, o_.sky.dark() ? nullptr : &o_.sky, c, o_.reentry_rays);
        report.reentry = rays.reentry;
        P1Budget collided = report.budget;
        for (size_t face = 0; face < 6; ++face) collided.out[face] -= source.emission_out[face];
        if (swept)
            report.planes = planes_by_sweep(index_, *swept, collided, flux ? std::max(rays.reentry, 0.0) : 0.0, ground);
        else if (rays.reentry >= 0)
            report.planes = planes_by_rays(p1, source, collided, rays, o_.sky, c, ground);
        const PlanePower of_collided = report.planes;
        if (const EmittedLight* light = emitted(c); light && report.planes.known)
            for (size_t face = 0; face < 6; ++face) report.planes.out[face] += light->out_by_plane[face];
        set_sides(index_, lights_.empty() ? std::nullopt : lights_[0]->common_direction(), report_.top, report);
        if (ground_) note_ground(ground, c, flux ? nullptr : swept, report);
        if (o_.heating || o_.flux_map) solution_[c].heating = heating_rate(p1, source, phi);
        if (o_.flux_map) fill_map(p1, c, *swept, of_collided);
    }

    /// The ground as sweeps meet it; without cells where there is none.
    SweepGround swept_ground(const P1Operator& p1, int c) const
    {
        if (!ground_) return {};
        return {ground_->face(), ground_->albedo(), ground_->direct(beam_medium(p1), beams_, c), {}};
    }

    /// What reaches the ground; the diffuse light of P1 alone, for sweeps bring their own.
    PlaneGround ground_under(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
                             bool p1_alone)
    {
        if (!ground_) return {};
        direct_on_ground_ = ground_->direct(beam_medium(p1), beams_, c);
        PlaneGround under{ground_->face(), ground_->albedo(), ground_->power(direct_on_ground_), -1};
        if (!p1_alone) return under;
        diffuse_on_ground_ = ground_->irradiance(p1, source, phi, direct_on_ground_);
        under.diffuse = ground_->power(diffuse_on_ground_);
        return under;
    }

    /// `swept`: of sweeps; null for P1 alone.
    void note_ground(const PlaneGround& under, int c, const PlaneLight* swept, ChannelReport& report)
    {
        if (swept) diffuse_on_ground_ = plane_flux(*swept, report.planes, under.face);
        report.ground = {under.direct, ground_->power(diffuse_on_ground_), 0, 0};
        const double all = report.ground.direct + report.ground.diffuse;
        report.ground.sent_up = under.albedo * all;
        report.ground.absorbed = (1 - under.albedo) * all;
        solution_[c].ground = ground_->radiance(direct_on_ground_, diffuse_on_ground_);
    }

    void put_ground()
    {
        std::array<const std::vector<float>*, 3> of;
        Vec3d scale;
        for (int c = 0; c < 3; ++c) {
            of[size_t(c)] = &solution_[size_t(share_[size_t(c)].of)].ground;
            scale[c] = share_[size_t(c)].scale;
        }
        report_.ground = ground_->grid(of, scale, grid_.transform());
        stamp(*report_.ground);
    }

    void fill_map(const P1Operator& p1, int c, const PlaneLight& swept, const PlanePower& planes)
    {
        FluxMap& map = *report_.flux_map;
        FluxMap::Channel& channel = map.channel[size_t(c)];
        for (const int face : {map.top, map.base}) {
            std::vector<float> flux = plane_flux(swept, planes, face);
            if (const EmittedLight* light = emitted(c))
                for (size_t cell = 0; cell < flux.size(); ++cell) flux[cell] += light->planes[size_t(face)][cell];
            (face == map.top ? channel.diffuse_up : channel.diffuse_down) = by_pixel(map, flux);
        }
        add_absorbed(index_, solution_[c].heating, map, channel);
        add_direct(index_, beam_medium(p1), beams_, c, map, channel);
    }

    void put_heating()
    {
        std::array<const std::vector<float>*, 3> of;
        Vec3d scale;
        for (int c = 0; c < 3; ++c) {
            of[size_t(c)] = &solution_[size_t(share_[size_t(c)].of)].heating;
            scale[c] = share_[size_t(c)].scale;
        }
        report_.heating = heating_grid(index_, grid_, of, scale);
        stamp(*report_.heating);
    }

    /// Solves the transport equation of one channel. `phi` is P1's solution on entry and the closed solution on return.
    void close(const P1Operator& p1, const P1Source& p1_source, int c, std::vector<double>& phi, ChannelReport& report)
    {
        const auto exposed = closure_exposed(p1);
        P1Medium medium = p1.medium();
        medium.degree = o_.closure.degree;
        const P1Operator fine(index_, density_, exposed, medium);
        SecondMoment closure(fine, o_.closure, frame_of(index_, o_.periodic, o_.up));
        if (!o_.sky.dark()) closure.set_sky(sky_along(index_, o_.sky, c, closure.set().direction));
        // At g = 0.85 P1's flux is far too long where light enters. From half of it one sweep leaves half the error
        // that the whole leaves, without a limit that two lights would not share. The fixed point does not depend on
        // it.
        closure.start_with_flux(cell_flux(p1, p1_source, phi), 0.5);
        P1Source base = source_of(fine);
        report.lines = -1;
        add_beams(fine, {{&base, c}}, {},
                  [&](const BeamDepths& depths, const std::vector<float>& centre, double extinction,
                      const std::optional<Vec3d>& disc) {
                      const Light& light = depths.light;
                      const double strength = light.strength()[c];
                      add_beam_profile(fine, depths, extinction, {{&base, strength}});
                      const auto late = beam_fluence(fine, depths, centre, extinction);
                      closure.add_uncollided(light, late, strength, disc);
                      if (medium.degree == 1 || !medium.delta || !p1.uniform_albedo()) return;
                      // Light that is uncollided under P1's scaling but collided under this scaling starts along the
                      // beam.
                      auto early =
                          beam_fluence(p1, depths, centre, medium.sigma_t_per_density * p1.scaling(0).extinction);
                      for (size_t slot = 0; slot < early.size(); ++slot) {
                          early[slot] -= late[slot];
                          phi[slot] += strength * early[slot];
                      }
                      closure.start_with(light, early, strength);
                  });
        add_sky_and_glow(fine, c, base);
        add_emission_to(closure, c);
        SweepGround ground = swept_ground(fine, c);
        if (ground_) closure.set_ground(&ground);
        Multigrid multigrid(fine.stencil());
        note_bytes(fine, 3, multigrid.bytes() + closure.bytes() + 20 * index_.blocks().slots());
        P1Source source(fine);
        PlaneLight planes;
        report.closure = closure.run(multigrid, o_.solve, base, phi, source, &planes);
        for (const SolveResult& solve : report.closure.solves)
            if (!solve.converged) report.solve = solve;
        finish(fine, source, c, phi, nullptr, &planes, report);
        const int kept = std::min(o_.closure.degree, std::max(o_.keep_moments, 1));
        auto moments = closure.moments();
        if (const EmittedLight* light = emitted(c))
            for (size_t k = 0; k < std::min(moments.size(), light->moments.size()); ++k)
                for (size_t slot = 0; slot < moments[k].size(); ++slot) moments[k][slot] += light->moments[k][slot];
        solution_[c].moments = moments_in_world(index_, moments, kept);
        solution_[c].flux = flux_of(solution_[c].moments);
    }

    int degree() const { return o_.closure.iterations > 0 ? o_.closure.degree : 1; }
    DeltaScaling scaling() const
    {
        return o_.delta ? delta_scaling(medium_.phase, degree()) : no_scaling(medium_.phase, degree());
    }

    /// The report of a channel whose solution is `scale` times another channel's.
    void share(int from, int to, double scale)
    {
        report_.channel[to] = multiple_of(report_.channel[from], scale);
        report_.channel[to].solved_as = from;
        if (report_.flux_map) share_channel(from, to, scale, *report_.flux_map);
        share_[to] = {from, scale};
    }

    void stamp(GridBase& grid) const
    {
        write_medium(grid, medium_);
        write_sources(grid, sources_);
        write_sky(grid, o_.sky);
        set_text(grid, schema::lit_by, lights_text(lights_));
        write_periodic(grid, o_.periodic);
        write_ground(grid, o_.ground_albedo);
    }

    const FloatGrid& grid_;
    const Sources sources_;
    const Medium& medium_;
    const std::vector<Light>& lights_;
    const std::vector<Light> beams_;             // without extent, their sum is that of lights_
    std::vector<std::optional<Vec3d>> towards_;  // of each beam: the middle of its sun
    const ScatterOptions o_;
    ScatterReport& report_;
    VoxelIndex index_;
    std::vector<float> density_;
    std::vector<ExposedVoxel> exposed_;
    bool periodic_ = false;
    std::optional<GroundPlane> ground_;
    std::vector<float> direct_on_ground_, diffuse_on_ground_;  // of the channel that is being finished
    std::vector<float> tint_[3], emission_[3];
    std::array<Solution, 3> solution_;
    std::array<Share, 3> share_;
    std::array<std::optional<EmittedLight>, 3> emitted_;  // of the solve at work
};

}  // namespace

CollidedLight scatter_p1(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         const Progress& progress, ScatterReport& report)
{
    report.emission_outside = emission && emits_outside(*emission, density);
    Scattering scattering(density, tint, emission, medium, lights, options, report);
    return scattering.run(progress);
}

CollidedLight p1_light(const FloatGrid& density, const Vec3SGrid* emission, const Medium& medium,
                       const std::vector<Light>& lights, const ScatterOptions& options, const FluenceOf& fluence,
                       ScatterReport& report)
{
    ScatterOptions p1 = options;
    p1.solver = P1Solver::Multigrid;
    p1.closure.iterations = 0;
    p1.limiter = false;
    p1.emission_by_rays = false;
    p1.reentry_rays = p1.line_rays = 0;
    p1.flux_map = p1.heating = false;
    Scattering scattering(density, nullptr, emission, medium, lights, p1, report);
    scattering.given = &fluence;
    return scattering.run({});
}

}  // namespace vdbcloud
