#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/scattering.h"

#include <algorithm>

namespace vdbcloud {

void Scattering::finish(const P1Operator& p1, const P1Source& source, int c, const std::vector<double>& phi,
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
        trace_outflow(p1, source, phi, flux, o_.sky.dark() ? nullptr : &o_.sky, c, hemisphere(), o_.reentry_rays);
    if (o_.reentry_rays > 0) {
        report_.work.add("outflow_ray", o_.reentry_rays);
        if (!o_.sky.dark())
            report_.work.add("outflow_sky_voxel", double(std::min(exposed_.size(), size_t(o_.reentry_rays))));
    }
    report.reentry = rays.reentry;
    P1Budget collided = report.budget;
    for (size_t face = 0; face < 6; ++face) collided.out[face] -= source.emission_out[face];
    if (swept)
        report.planes = planes_by_sweep(index_, *swept, collided, flux ? std::max(rays.reentry, 0.0) : 0.0,
                                        hemisphere(), ground, !walls_);
    else if (rays.reentry >= 0)
        report.planes = planes_by_rays(p1, source, collided, rays, o_.sky, c, hemisphere(), ground);
    const PlanePower of_collided = report.planes;
    if (const EmittedLight* light = emitted(c); light && report.planes.known) {
        for (size_t face = 0; face < 6; ++face) report.planes.out[face] += light->out_by_plane[face];
        report.planes.reflected += light->reflected;
    }
    if (ground_) note_ground(ground, c, flux ? nullptr : swept, report);
    if (endless_) note_endless(c, report);
    if (o_.heating || o_.flux_map) solution_[c].heating = heating_rate(p1, source, phi);
    if (o_.flux_map) fill_map(p1, c, *swept, of_collided);
}

Hemisphere Scattering::hemisphere() const
{
    return reflected_into(index_, lights_.empty() ? std::nullopt : lights_[0]->common_direction(), o_.up);
}

PlaneGround Scattering::ground_under(const P1Operator& p1, const P1Source& source, int c,
                                     const std::vector<double>& phi, bool p1_alone)
{
    if (!ground_) return {};
    direct_on_ground_ = ground_->direct(beam_medium(p1), beams_, c);
    PlaneGround under{ground_->face(), ground_->albedo(), ground_->power(direct_on_ground_), -1};
    if (!p1_alone) return under;
    diffuse_on_ground_ = ground_->irradiance(p1, source, phi, direct_on_ground_);
    under.diffuse = ground_->power(diffuse_on_ground_);
    return under;
}

void Scattering::note_ground(const PlaneGround& under, int c, const PlaneLight* swept, ChannelReport& report)
{
    if (swept) diffuse_on_ground_ = plane_flux(*swept, report.planes, under.face);
    report.ground = {under.direct, ground_->power(diffuse_on_ground_), 0, 0};
    const double all = report.ground.direct + report.ground.diffuse;
    report.ground.sent_up = under.albedo * all;
    report.ground.absorbed = (1 - under.albedo) * all;
    solution_[c].ground = ground_->radiance(direct_on_ground_, diffuse_on_ground_);
}

void Scattering::note_endless(int c, ChannelReport& report)
{
    report.ground = {endless_->power(direct_on_ground_), endless_->power(diffuse_on_ground_), 0, 0};
    const double all = report.ground.direct + report.ground.diffuse;
    report.ground.sent_up = endless_->albedo() * all;
    report.ground.absorbed = (1 - endless_->albedo()) * all;
    solution_[c].ground = endless_->radiance_change(direct_on_ground_, diffuse_on_ground_);
}

std::pair<std::array<const std::vector<float>*, 3>, Vec3d>
Scattering::by_channel(std::vector<float> Solution::*field) const
{
    std::array<const std::vector<float>*, 3> of;
    Vec3d scale;
    for (int c = 0; c < 3; ++c) {
        of[size_t(c)] = &(solution_[size_t(share_[size_t(c)].of)].*field);
        scale[c] = share_[size_t(c)].scale;
    }
    return {of, scale};
}

void Scattering::put_ground()
{
    const auto [of, scale] = by_channel(&Solution::ground);
    report_.ground =
        endless_ ? endless_->grid(of, scale, grid_.transform()) : ground_->grid(of, scale, grid_.transform());
    stamp(*report_.ground);
}

void Scattering::fill_map(const P1Operator& p1, int c, const PlaneLight& swept, const PlanePower& planes)
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

void Scattering::put_heating()
{
    const auto [of, scale] = by_channel(&Solution::heating);
    report_.heating = heating_grid(index_, grid_, of, scale);
    stamp(*report_.heating);
}

}  // namespace vdbcloud
