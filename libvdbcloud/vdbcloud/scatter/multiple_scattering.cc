#include "vdbcloud/scatter/multiple_scattering.h"

#include "vdbcloud/core/release.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/scattering.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// A ground hides the sky below the horizon.
ScatterOptions with_horizon(ScatterOptions options)
{
    if (options.ground_albedo) options.sky = options.sky.above_horizon();
    return options;
}

}  // namespace

Scattering::Scattering(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission, const Medium& medium,
                       const std::vector<Light>& lights, const ScatterOptions& options, ScatterReport& report)
    : solids_(options.solids.empty() ? nullptr : std::make_unique<SolidRays>(options.solids)),
      open_(solids_ ? without_solids(density, *solids_, options.periodic) : nullptr), grid_(open_ ? *open_ : density),
      sources_(options.parts.empty() ? sources_of(density, tint, emission) : sources_of(options.parts, emission)),
      medium_(medium), lights_(lights), beams_(points_of(lights, options.disc_samples)), o_(with_horizon(options)),
      report_(report), surface_(grid_, options.closure.iterations > 0 ? solids_.get() : nullptr),
      index_(grid_, {options.periodic, surface_.blocks}), density_(index_.gather(grid_)),
      exposed_(exposed_voxels(index_, density_))
{
    for (const Light& light : lights)
        towards_.resize(towards_.size() + light.points(options.disc_samples).size(), light->common_direction());
    for (int c = 0; c < 3; ++c) {
        if (tint) tint_[c] = index_.gather(*tint, c);
        if (emission) emission_[c] = index_.gather(*emission, c);
    }
    if (tint && tint_[0] == tint_[1] && tint_[0] == tint_[2]) release(tint_[1], tint_[2]);
    if (emission && emission_[0] == emission_[1] && emission_[0] == emission_[2]) release(emission_[1], emission_[2]);
    if (tint) clamp_tint();
    report.solids = bool(solids_);
    if (!surface_.elements.empty()) walls_ = walls_of(surface_, *solids_, index_);
    mix();
    note_fields();
    report.voxels = index_.blocks().active_count();
    report.blocks = index_.blocks().count();
    report.exposed = exposed_.size();
    const int axis = frame_of(index_, {false, false, false}, o_.up).polar;
    report.top = 2 * axis + (index_.axis(axis).dot(o_.up) > 0);
    if (o_.flux_map) report.flux_map = columns_of(index_, o_.up);
    if (!o_.ground_albedo || report.blocks == 0) return;
    const EffectCosts::Timer timer(report.costs, Effect::Ground);
    if (index_.blocks().period() == Vec3i(0, 0, 0)) {
        endless_.emplace(index_, o_.up, *o_.ground_albedo, beams_, o_.sky);
        report.endless_ground = true;
        return;
    }
    ground_.emplace(index_, o_.up, *o_.ground_albedo);
    ground_->mark(exposed_);
    if (o_.closure.iterations == 0) ground_->require_cover();
}

CollidedLight Scattering::run(const Progress& progress)
{
    CollidedLight fields;
    if (index_.blocks().count() == 0) return fields;
    const auto all = groups();
    beam_uses_ = uses_of_beams(all);
    int done = 0, count = 0;
    for (const ChannelGroup& group : all) count += int(group.solves.size());
    if (o_.closure.iterations > 0)
        for (const auto& groups : swept_together(
                 all, {medium_.sigma_t_per_density[0], medium_.sigma_t_per_density[1], medium_.sigma_t_per_density[2]},
                 scaling().delta_f > 0 || !mixtures_.empty()))
            solve_closed(groups, done, count, progress);
    else
        for (const ChannelGroup& group : all) solve_group(group, done, count, progress);

    if (o_.heating) put_heating();
    if (ground_ || endless_) put_ground();
    fields.scaling = scaling();
    if (o_.closure.iterations == 0 && fields.scaling.mean_cosine() != 0) fields.flux_limit = longest_flux;
    collided_grids(
        index_, solution_, share_, std::min(degree(), o_.keep_moments), [&](GridBase& grid) { stamp(grid); }, fields);
    note_results(fields);
    return fields;
}

/// Channels of equal coefficients share arrays.
void Scattering::mix()
{
    for (int c = 0; c < 3 && !o_.parts.empty(); ++c) {
        ChannelMixture own = channel_mixture(index_, o_.parts, c);
        auto place = std::find(mixtures_.begin(), mixtures_.end(), own);
        if (place == mixtures_.end()) place = mixtures_.insert(place, std::move(own));
        mixture_of_[size_t(c)] = size_t(place - mixtures_.begin());
    }
}

void Scattering::clamp_tint()
{
    for (int c = 0; c < 3; ++c)
        for (float& t : tint_[c])
            t = std::max(0.0f, medium_.albedo[c] > 0 ? std::min(t, float(1 / medium_.albedo[c])) : t);
}

std::vector<ChannelGroup> Scattering::groups() const
{
    std::array<ChannelInput, 3> input;
    for (int c = 0; c < 3; ++c) {
        ChannelInput& of = input[size_t(c)];
        const P1Medium medium = medium_of(c);
        of.matrix = {medium.sigma_t_per_density, medium.albedo};
        of.mixed = medium.mixed;
        of.tint = tint(c);
        of.emission = emission(c);
        for (const Light& light : lights_) of.light.push_back(light.strength()[c]);
        for (const Vec3d& tone : o_.sky.tones()) of.light.push_back(tone[c]);
        of.light.push_back(of.emission ? 1.0 : 0.0);
        if (walls_) of.surfaces = reflectances(o_.solids, c);
    }
    return group_channels(input, o_.channels_apart);
}

void Scattering::note_bytes(const P1Operator& p1, size_t sources, size_t besides)
{
    const size_t slots = index_.blocks().slots();
    size_t now = p1.bytes() + slots * (4 + 8 * sources) + besides + exposed_.size() * sizeof(ExposedVoxel);
    size_t beams = 0;
    for (const auto& beam : kept_)
        if (beam)
            beams += 4 * slots * (beam->centres.empty() ? 3 : 4) + exposed_.size() * sizeof(beam->depths.exposed[0]) +
                     beam->depths.boxed.size() * sizeof(beam->depths.boxed[0]);
    now += beams;
    beam_bytes_ = std::max(beam_bytes_, double(beams));
    if (medium_.phase.mean_cosine() != 0) now += 24 * slots * sources;
    report_.bytes = std::max(report_.bytes, now);
}

std::vector<P1Source> Scattering::p1_sources(const P1Operator& p1, const ChannelGroup& group, const Progress& progress)
{
    find_one_beam(p1, progress);  // while there are no sources yet
    std::vector<P1Source> sources;
    for (size_t k = 0; k < group.solves.size(); ++k) sources.push_back(source_of(p1));
    std::vector<std::pair<P1Source*, int>> lit;
    for (size_t k = 0; k < sources.size(); ++k) lit.emplace_back(&sources[k], group.solves[k].channel);
    add_beams(p1, lit, progress);
    for (const auto& [source, c] : lit) {
        add_sky_and_glow(p1, c, *source);
        add_direct_ground(p1, c, *source);
    }
    return sources;
}

P1Medium Scattering::medium_of(int channel) const
{
    P1Medium medium{medium_.sigma_t_per_density[channel], medium_.albedo[channel], tint(channel), medium_.phase,
                    o_.delta};
    if (const ChannelMixture* all = mixture(channel)) {
        medium.sigma_t_per_density = all->sigma_t;
        medium.albedo = all->albedo;
        medium.phase = all->phases.phase[0];
        medium.mixed = &all->phases;
    }
    medium.ground_albedo = o_.ground_albedo.value_or(0);
    return medium;
}

void Scattering::solve_group(const ChannelGroup& group, int& done, int count, const Progress& progress)
{
    const P1Operator p1(index_, density(group.solves[0].channel), exposed_, medium_of(group.solves[0].channel));
    note_work("p1_setup_voxel", 1);
    const auto part = [&](double f) { return !progress || progress((done + f) / count); };
    follow_emission(p1, group);
    std::vector<P1Source> sources = p1_sources(p1, group, [&](double f) { return part(0.3 * f); });
    std::optional<Multigrid> multigrid;
    if (o_.solver == P1Solver::Multigrid) {
        multigrid.emplace(p1.stencil());
        report_.levels = std::max(report_.levels, multigrid->levels());
    }
    note_bytes(p1, sources.size(), (multigrid ? multigrid->bytes() : 0) + 12 * index_.blocks().slots());
    for (size_t k = 0; k < group.solves.size(); ++k, ++done) {
        SolveOptions options = o_.solve;
        options.progress = [&](double f) { return part(0.3 + 0.7 * f); };
        std::vector<double> phi;
        const int c = group.solves[k].channel;
        ChannelReport& report = report_.channel[c];
        const auto solve_for = [&](P1Source& source) {
            report.solve = solve(p1, multigrid ? &*multigrid : nullptr, source, phi, options);
        };
        if (given) {
            phi = (*given)(index_, c);
            report.solve = judge_p1(p1, *multigrid, sources[k], phi);
        } else if (endless_) {
            const P1Source unlit = sources[k];
            add_patch(p1, unlit, c, solve_for, phi, sources[k], report);
        } else {
            solve_for(sources[k]);
        }
        if (k + 1 == group.solves.size()) multigrid.reset();  // what follows needs its memory
        if (o_.limiter)
            limit(p1, sources[k], c, phi, report);
        else
            keep_p1(p1, sources[k], c, phi, report);
        keep(group.solves[k], phi);
    }
}

void Scattering::keep(const ChannelGroup::Solve& solve, const std::vector<double>& phi)
{
    const int c = solve.channel;
    solution_[c].phi.assign(phi.begin(), phi.end());
    if (const EmittedLight* light = emitted(c))
        for (size_t slot = 0; slot < phi.size(); ++slot) solution_[c].phi[slot] += light->fluence[slot];
    emitted_[c].reset();
    share_[c] = {c, 1};
    for (const auto& [channel, scale] : solve.shared) share(c, channel, scale);
    ++report_.solves;
    note_work("p1_channel_voxel", 1);
}

void Scattering::share(int from, int to, double scale)
{
    report_.channel[to] = multiple_of(report_.channel[from], scale);
    report_.channel[to].solved_as = from;
    if (report_.flux_map) share_channel(from, to, scale, *report_.flux_map);
    share_[to] = {from, scale};
}

void Scattering::stamp(GridBase& grid) const
{
    if (o_.parts.empty())
        write_medium(grid, medium_);
    else
        set_text(grid, schema::mixture, mixture_text(o_.parts, scalings_of(o_.parts, degree(), o_.delta)));
    write_sources(grid, sources_);
    write_sky(grid, o_.sky);
    std::vector<Light> lights = lights_;
    lights.insert(lights.end(), o_.hidden_lights.begin(), o_.hidden_lights.end());
    set_text(grid, schema::lit_by, lights_text(lights));
    write_periodic(grid, o_.periodic);
    write_ground(grid, o_.ground_albedo);
    if (o_.previous) set_text(grid, schema::started_from, o_.previous->digest);
    if (solids_) set_text(grid, schema::solids, solids_digest(o_.solids, /*materials=*/true));
}

CollidedLight scatter_p1(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission,
                         const Medium& medium, const std::vector<Light>& lights, const ScatterOptions& options,
                         const Progress& progress, ScatterReport& report)
{
    const EffectCosts::Timer timer(report.costs, Effect::Multiple);
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
