#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/exposed_beam.h"
#include "vdbcloud/scatter/scattering.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace vdbcloud {

Scattering::KeptBeam Scattering::find_beam(const BeamMedium& medium, const Light& light, bool with_centres,
                                           const Progress& progress)
{
    std::atomic<size_t> products{0};
    std::vector<float> centres;
    BeamDepths depths =
        medium.depths(exposed_, light, o_.rays_per_voxel, with_centres ? &centres : nullptr, progress, &products);
    KeptBeam beam{std::move(depths), std::move(centres), {}};
    if (light->common_direction() && o_.line_rays && !solids_) beam.lines = medium.lines(light);
    note_work("beam_voxel", 1);
    report_.work.add("lattice_product", double(products));
    return beam;
}

void Scattering::find_one_beam(const P1Operator& p1, const Progress& progress)
{
    kept_.resize(beams_.size());
    if (beams_.size() != 1 || kept_[0]) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Lights);
    kept_[0].emplace(find_beam(beam_medium(p1), beams_[0], keeps_beams(p1) && sweeps_take_beams(), progress));
}

void Scattering::add_beams(const P1Operator& p1, const std::vector<std::pair<P1Source*, int>>& sources,
                           const Progress& progress, const BeamNote& note)
{
    if (beams_.empty()) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Lights);
    const double extinction = beam_extinction(p1);
    std::optional<BeamMedium> medium;  // where depths are not known
    const bool keeps = keeps_beams(p1);
    kept_.resize(beams_.size());
    for (size_t l = 0; l < beams_.size(); ++l) {
        const Light& light = beams_[l];
        const Progress part =
            progress ? Progress([&](double f) { return progress((double(l) + f) / double(beams_.size())); })
                     : Progress();
        std::optional<KeptBeam>& beam = kept_[l];
        if (!beam) {
            if (!medium) medium.emplace(beam_medium(p1));
            beam.emplace(find_beam(*medium, light, note || (keeps && sweeps_take_beams()), part));
        }
        if (l + 1 == beams_.size()) medium.reset();
        add_boxed_depths(p1, beam->depths);
        note_bytes(p1, sources.size(), 20 * index_.blocks().slots());
        std::vector<std::pair<P1Source*, double>> channels;
        for (const auto& [source, channel] : sources) channels.emplace_back(source, light.strength()[channel]);
        add_beam(p1, beam->depths, extinction, channels);
        if (note) note(beam->depths, beam->centres, extinction, towards_[l]);
        note_work("beam_voxel", 1);
        const double lost = beam->lines ? lost_power(*beam->lines, extinction) : 0;
        for (const auto& [source, channel] : sources) {
            if (!beam->lines) continue;
            auto& lines = report_.channel[channel].lines;
            lines = std::max(lines, 0.0) + lost * light.strength()[channel];
        }
        if (!keeps) beam.reset();
    }
    if (--beam_uses_ <= 0) kept_.clear();
    const bool lamps =
        std::any_of(lights_.begin(), lights_.end(), [](const Light& l) { return !l->common_direction(); });
    for (const auto& [source, channel] : sources)
        if (lamps) report_.channel[channel].lines = -1;
}

void Scattering::add_closed_beams(const P1Operator& fine, int c, SecondMoment& closure, P1Source& base,
                                  const BeamNote& note)
{
    double& lines = report_.channel[c].lines;
    ChannelBeams own{medium_.sigma_t_per_density[c], medium_.albedo[c], {}};
    for (const Light& light : beams_) own.strength.push_back(light.strength()[c]);
    const bool alike = fine.mean_cosine() == 0 && fine.uniform() && base.beam_absorbed.empty();
    const auto x = alike && beam_source_ ? beams_as(beam_source_->of, own) : std::nullopt;
    if (!x) {
        add_beams(fine, {{&base, c}}, {}, note);
        if (alike) base.share_through();
        if (alike && beam_uses_ > 0) beam_source_.emplace(BeamSource{own, base, closure.uncollided(), lines});
        return;
    }
    const double scattered = *x * own.albedo / beam_source_->of.albedo;
    base = beam_source_->source;
    const auto scale = [&](std::vector<double>& values) {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, values.size()), [&](const tbb::blocked_range<size_t>& range) {
            for (size_t k = range.begin(); k < range.end(); ++k) values[k] *= scattered;
        });
    };
    scale(base.rhs);
    base.shared_scale *= scattered;
    for (auto& faces : base.outflow)
        for (double& outflow : faces) outflow *= scattered;
    base.first_scatter *= scattered;
    for (double* power : {&base.deposited, &base.beam_in, &base.beam_out}) *power *= *x;
    auto uncollided = beam_source_->uncollided;
    for (auto& moment : uncollided)
        for (float& value : moment) value = float(*x * value);
    closure.add_uncollided(uncollided);
    lines = beam_source_->lines < 0 ? -1 : beam_source_->lines * *x;
    if (--beam_uses_ <= 0) {
        kept_.clear();
        beam_source_.reset();
    }
}

bool Scattering::keeps_beams(const P1Operator& p1) const
{
    constexpr size_t most = 4;
    return p1.uniform() && beams_.size() <= most && beam_uses_ > 1;
}

int Scattering::uses_of_beams(const std::vector<ChannelGroup>& groups) const
{
    constexpr int many = 1 << 20;
    if (o_.limiter) return many;
    int solves = 0;
    for (const ChannelGroup& group : groups) solves += int(group.solves.size());
    if (o_.closure.iterations > 0) return solves;
    return int(groups.size()) + solves * ((o_.flux_map || endless_ ? 1 : 0) + (endless_ ? 1 : 0));
}

void Scattering::follow_emission(const P1Operator& p1, const ChannelGroup& group)
{
    std::vector<const std::vector<float>*> of;
    std::vector<int> channels;
    for (const ChannelGroup::Solve& solve : group.solves)
        if (emission(solve.channel)) {
            of.push_back(emission(solve.channel));
            channels.push_back(solve.channel);
        }
    if (of.empty()) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Emission);
    const double share = share_by_rays(index_.blocks(), of);
    if (share == 0) return;
    if (!by_rays() || !box_allows_rays(index_.blocks())) {
        report_.emission_without_rays = true;
        return;
    }
    std::vector<std::vector<float>> part;
    for (size_t k = 0; share < 1 && k < of.size(); ++k) {
        part.push_back(*of[k]);
        for (float& j : part.back()) j = float(share * j);
    }
    for (size_t k = 0; k < part.size(); ++k) of[k] = &part[k];
    P1Medium medium = p1.medium();
    medium.degree = degree();
    medium.limiter = nullptr;
    const P1Operator scaled(index_, p1.density(), exposed_, medium);
    auto light = emitted_light(scaled, beam_medium(scaled), of, hemisphere());
    for (size_t k = 0; k < channels.size(); ++k) {
        ChannelReport& report = report_.channel[channels[k]];
        report.emission_by_rays = true;
        report.emission_scaled_by = light[k].scaled_by;
        report.emission_collisions = light[k].collisions;
        emitted_[channels[k]] = std::move(light[k]);
        emitted_share_[size_t(channels[k])] = share;
    }
}

void Scattering::add_emission_to(SecondMoment& closure, int c) const
{
    if (!emission(c)) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Emission);
    if (const EmittedLight* light = emitted(c)) {
        closure.add_uncollided(light->moments);
        closure.scatter_less(light->followed);
    }
    if (const double share = swept_share(c); share > 0) closure.add_emission(*emission(c), share);
}

void Scattering::add_sky_and_glow(const P1Operator& p1, int c, P1Source& source) const
{
    if (!o_.sky.dark() || endless_) {
        const EffectCosts::Timer timer(report_.costs, o_.sky.dark() ? Effect::Ground : Effect::Sky);
        auto radiance = sky_on_faces(index_, o_.sky, c);
        if (endless_) endless_->add_on_faces(c, radiance);
        add_sky(p1, radiance, source);
    }
    if (!emission(c)) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Emission);
    if (const EmittedLight* light = emitted(c)) add_emitted(p1, *light, source);
    if (const double share = swept_share(c); share > 0) add_emission(p1, *emission(c), share, source);
}

void Scattering::add_direct_ground(const P1Operator& p1, int c, P1Source& source)
{
    if (!ground_) return;
    const EffectCosts::Timer timer(report_.costs, Effect::Ground);
    ground_->add_direct(p1, ground_->direct(beam_medium(p1), beams_, c), source);
}

P1Source Scattering::source_of(const P1Operator& p1) const
{
    P1Source source(p1);
    if (o_.heating || o_.flux_map) source.beam_absorbed.assign(index_.blocks().slots(), 0.0);
    return source;
}

void Scattering::set_inflow(SecondMoment& closure, int c) const
{
    if (o_.sky.dark() && !endless_) return;
    const EffectCosts::Timer timer(report_.costs, o_.sky.dark() ? Effect::Ground : Effect::Sky);
    auto radiance = sky_along(index_, o_.sky, c, closure.set().direction);
    if (endless_) endless_->add_along(c, closure.set().direction, radiance);
    closure.set_sky(std::move(radiance));
}

std::optional<LitWalls> Scattering::lit_walls(const P1Operator& p1, int c) const
{
    if (!walls_) return std::nullopt;
    const EffectCosts::Timer timer(report_.costs, Effect::Solids);
    const size_t count = surface_.elements.size();
    LitWalls lit{{&*walls_, {}, std::vector<float>(count)}, std::vector<float>(count), std::vector<float>(count)};
    const BeamMedium medium = beam_medium(p1);
    const std::array<double, 6> sky = sky_on_faces(index_, o_.sky, c);
    tbb::parallel_for(size_t(0), count, [&](size_t n) {
        const SolidSurface::Element& e = surface_.elements[n];
        double direct = 0;
        // A mirror sends a sun's light into one direction; spread over all it would light what it does not reach.
        const bool spreads = solids_->material(e.solid).finish == Finish::Diffuse;
        for (const Light& light : beams_) {
            if (!spreads) break;
            const double cosine = light->towards(e.outside).direction.dot(e.normal);
            if (cosine > 0)
                direct += light.strength()[c] * light->irradiance(e.outside) * cosine *
                          std::exp(-medium.extinction() * medium.depth_from(e.outside, light));
        }
        lit.direct[n] = float(direct);
        lit.reflectance[n] = float(solids_->material(e.solid).reflectance(e.outside)[c]);
        double inflow = 0;  // exact for a uniform sky; sweeps find what it is
        for (int a = 0; a < 3; ++a) inflow += e.along[a] * e.along[a] * sky[size_t(2 * a + (e.along[a] > 0))];
        lit.light.irradiance[n] = float(pi * inflow);
    });
    report_.work.add("ground_ray", double(count * beams_.size()));
    lit.reflect();
    return lit;
}

std::optional<SweepGround> Scattering::swept_ground(const P1Operator& p1, int c) const
{
    if (!endless_ && !ground_) return std::nullopt;
    const EffectCosts::Timer timer(report_.costs, Effect::Ground);
    if (endless_) {
        report_.work.add("ground_ray", endless_->rays());
        return endless_->swept(beam_medium(p1), c);
    }
    return SweepGround{ground_->face(), ground_->albedo(), ground_->direct(beam_medium(p1), beams_, c), {}, {}};
}

void Scattering::note_patch(const std::optional<SweepGround>& ground)
{
    if (!endless_) return;
    direct_on_ground_ = ground->direct;
    diffuse_on_ground_ = ground->irradiance;
}

namespace {

template<typename T>
double held(const std::vector<T>& values)
{
    return double(values.capacity() * sizeof(T));
}

}  // namespace

void Scattering::note_fields()
{
    EffectCosts& costs = report_.costs;
    for (const auto& [effect, fields] : {std::pair{Effect::Tint, tint_}, {Effect::Emission, emission_}})
        for (int c = 0; c < 3; ++c) {
            if (fields[c].empty()) continue;
            costs.enter(effect);
            costs.hold(effect, 1, held(fields[c]));
        }
    if (solids_) {
        costs.enter(Effect::Solids);
        costs.hold(Effect::Solids, o_.solids.size(), bytes_of(o_.solids) + double(open_->memUsage()));
    }
    for (const ChannelMixture& mixture : mixtures_) {
        costs.enter(Effect::Mixture);
        costs.hold(Effect::Mixture, 1, held(mixture.density) + held(mixture.tint));
    }
    if (o_.periodic != std::array<bool, 3>{}) costs.enter(Effect::Periodic);
}

void Scattering::note_results(const CollidedLight& fields)
{
    EffectCosts& costs = report_.costs;
    const auto hold = [&](Effect effect, const GridBasePtr& grid) {
        if (grid) costs.hold(effect, 1, double(grid->memUsage()));
    };
    hold(Effect::Multiple, fields.phi);
    hold(Effect::Ground, report_.ground);
    costs.hold(Effect::Multiple, 0, double(report_.bytes));
    if (!beams_.empty()) costs.hold(Effect::Lights, beams_.size(), beam_bytes_);
    const bool one = fields.phi && fields.phi->isType<FloatGrid>();
    for (size_t c = 0; c < (one ? 1u : 3u); ++c) {
        hold(Effect::Anisotropy, fields.flux[c]);
        for (const FloatGridPtr& moment : fields.moments[c]) hold(Effect::Anisotropy, moment);
    }
    if (costs[Effect::Anisotropy].fields > 0) costs.enter(Effect::Anisotropy);
    for (size_t c = 1; c < 3; ++c) {
        const Solution& further = solution_[c];
        if (further.phi.empty()) continue;
        costs.enter(Effect::Colour);
        costs.hold(Effect::Colour, 1, held(further.phi));
    }
}

}  // namespace vdbcloud
