#include "vdbcloud/scatter/multiple_scattering.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

Accuracy accuracy_of(const ScatterReport& report, const std::vector<Light>& lights)
{
    Accuracy accuracy;
    // The value of the channel in which it is farthest from 0, of channels where it is known.
    const auto worst = [&](const char* name, const auto& value, const auto& known) {
        double most = -1;
        for (const ChannelReport& c : report.channel)
            if (known(c)) most = std::max(most, std::abs(value(c)));
        if (most >= 0) accuracy.add(name, most);
    };
    const auto always = [](const ChannelReport&) { return true; };
    const auto swept = [](const ChannelReport& c) { return !c.closure.change.empty(); };
    worst(
        "residual", [](const ChannelReport& c) { return c.solve.residual; }, always);
    worst(
        "solver_error", [](const ChannelReport& c) { return c.solve.error; }, always);
    worst(
        "change", [](const ChannelReport& c) { return c.closure.change.back(); }, swept);
    worst(
        "contraction", [](const ChannelReport& c) { return c.closure.contraction; }, swept);
    worst(
        "sweep_error", [](const ChannelReport& c) { return c.closure.error; },
        [&](const ChannelReport& c) { return swept(c) && c.closure.error >= 0; });
    worst(
        "defect", [](const ChannelReport& c) { return c.budget.defect; }, always);
    worst(
        "faces_against_lines", [](const ChannelReport& c) { return c.deposited / c.lines - 1; },
        [](const ChannelReport& c) { return c.lines > 0; });
    worst(
        "lost_at_voids", [](const ChannelReport& c) { return c.reentry; },
        [](const ChannelReport& c) { return c.reentry >= 0; });
    worst(
        "emission_scaled_by", [](const ChannelReport& c) { return c.emission_scaled_by; },
        [](const ChannelReport& c) { return c.emission_by_rays; });
    worst(
        "planes_scaled_by", [](const ChannelReport& c) { return c.planes.scaled_by; },
        [](const ChannelReport& c) { return c.planes.scaled_by != 0; });
    if (std::any_of(lights.begin(), lights.end(), [](const Light& light) { return light->source().has_value(); }))
        accuracy.left_out.push_back(lamp_cusp);
    if (report.endless_ground) accuracy.left_out.push_back("changes of the ground's light beyond its patch");
    if (report.solids && std::any_of(report.channel.begin(), report.channel.end(), swept))
        accuracy.left_out.push_back(
            "what mirrors and glossy solids send into the medium of suns and lamps, and of other "
            "light otherwise than a diffuse surface; what solids far from it hide and send");
    else if (report.solids)
        accuracy.left_out.push_back(
            "light that solids reflect into the medium, and that they hide but for suns and lamps");
    if (report.emission_outside) accuracy.left_out.push_back("emission outside the density");
    if (report.emission_without_rays) accuracy.left_out.push_back("rays of compact emission");
    return accuracy;
}

}  // namespace vdbcloud
