#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/scattering.h"

#include <algorithm>

namespace vdbcloud {

void Scattering::add_beams(
    const P1Operator& p1, const std::vector<std::pair<P1Source*, int>>& sources, const Progress& progress,
    const std::function<void(const BeamDepths&, const std::vector<float>&, double, const std::optional<Vec3d>&)>& note)
{
    if (beams_.empty()) return;
    const BeamMedium medium = beam_medium(p1);
    for (size_t l = 0; l < beams_.size(); ++l) {
        const Light& light = beams_[l];
        const Progress part =
            progress ? Progress([&](double f) { return progress((double(l) + f) / double(beams_.size())); })
                     : Progress();
        std::atomic<size_t> products{0};
        const BeamDepths depths = medium.depths(exposed_, light, o_.rays_per_voxel, part, &products);
        note_bytes(p1, sources.size(), 20 * index_.blocks().slots());
        std::vector<std::pair<P1Source*, double>> channels;
        for (const auto& [source, channel] : sources) channels.emplace_back(source, light.strength()[channel]);
        add_beam(p1, depths, medium.extinction(), channels);
        if (note) note(depths, medium.centres(light, o_.rays_per_voxel, &products), medium.extinction(), towards_[l]);
        note_work("beam_voxel", note ? sets_of_beam + 1 : sets_of_beam);
        report_.work.add("lattice_product", double(products));
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

void Scattering::follow_emission(const P1Operator& p1, const ChannelGroup& group)
{
    std::vector<const std::vector<float>*> of;
    std::vector<int> channels;
    for (const ChannelGroup::Solve& solve : group.solves)
        if (emission(solve.channel)) {
            of.push_back(emission(solve.channel));
            channels.push_back(solve.channel);
        }
    const double share = of.empty() ? 0.0 : share_by_rays(index_.blocks(), of);
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
    const P1Operator scaled(index_, density_, exposed_, medium);
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
    if (const EmittedLight* light = emitted(c)) {
        closure.add_uncollided(light->moments);
        closure.scatter_less(light->followed);
    }
    if (const double share = swept_share(c); share > 0) closure.add_emission(*emission(c), share);
}

void Scattering::add_sky_and_glow(const P1Operator& p1, int c, P1Source& source) const
{
    if (!o_.sky.dark() || endless_) {
        auto radiance = sky_on_faces(index_, o_.sky, c);
        if (endless_) endless_->add_on_faces(c, radiance);
        add_sky(p1, radiance, source);
    }
    if (const EmittedLight* light = emitted(c)) add_emitted(p1, *light, source);
    if (const double share = swept_share(c); share > 0) add_emission(p1, *emission(c), share, source);
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
    auto radiance = sky_along(index_, o_.sky, c, closure.set().direction);
    if (endless_) endless_->add_along(c, closure.set().direction, radiance);
    closure.set_sky(std::move(radiance));
}

std::optional<SweepGround> Scattering::swept_ground(const P1Operator& p1, int c) const
{
    if (endless_) return endless_->swept(beam_medium(p1), c);
    if (!ground_) return std::nullopt;
    return SweepGround{ground_->face(), ground_->albedo(), ground_->direct(beam_medium(p1), beams_, c), {}, {}};
}

void Scattering::note_patch(const std::optional<SweepGround>& ground)
{
    if (!endless_) return;
    direct_on_ground_ = ground->direct;
    diffuse_on_ground_ = ground->irradiance;
}

}  // namespace vdbcloud
