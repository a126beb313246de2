#include "vdbcloud/scatter/channel_mixture.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/active_slots.h"

#include <algorithm>

namespace vdbcloud {

namespace {

/// One part at the slots of an index.
struct Gathered {
    double sigma_t, albedo;
    std::vector<float> density, tint;  // empty: 1 everywhere

    double extinction(size_t slot) const { return sigma_t * density[slot]; }
    double scattering(size_t slot) const
    {
        return extinction(slot) * (tint.empty() ? albedo : std::clamp(albedo * tint[slot], 0.0, 1.0));
    }
};

}  // namespace

bool ChannelMixture::operator==(const ChannelMixture& other) const
{
    return sigma_t == other.sigma_t && albedo == other.albedo && density == other.density && tint == other.tint &&
           phases.share == other.phases.share;
}

ChannelMixture channel_mixture(const VoxelIndex& index, const std::vector<MediumPart>& parts, int channel)
{
    ChannelMixture all;
    std::vector<Gathered> gathered;
    bool one_albedo = true;
    all.sigma_t = all.albedo = 0;
    for (const MediumPart& part : parts) {
        Gathered& own = gathered.emplace_back(Gathered{
            part.medium.sigma_t_per_density[channel], part.medium.albedo[channel], index.gather(*part.density), {}});
        if (part.colour) own.tint = index.gather(*part.colour, channel);
        one_albedo = one_albedo && !part.colour && own.albedo == gathered[0].albedo;
        all.sigma_t = std::max(all.sigma_t, own.sigma_t);
        all.albedo = std::max(all.albedo, own.albedo);
        all.phases.phase.push_back(part.medium.phase);
    }
    const size_t slots = index.blocks().slots();
    all.density.assign(slots, 0.0f);
    if (!one_albedo) all.tint.assign(slots, 1.0f);
    all.phases.share.assign(parts.size() - 1, std::vector<float>(slots, 0.0f));
    each_active(index.blocks(), [&](size_t slot) {
        double density = 0, extinction = 0, scattering = 0;
        for (const Gathered& own : gathered) {
            density += own.density[slot];
            extinction += own.extinction(slot);
            scattering += own.scattering(slot);
        }
        // A voxel that does not attenuate this channel but others: sources are divided by extinction.
        if (all.sigma_t > 0) all.density[slot] = float(std::max(extinction / all.sigma_t, 1e-7 * density));
        if (!one_albedo && extinction > 0 && all.albedo > 0)
            all.tint[slot] = float(scattering / (extinction * all.albedo));
        for (size_t n = 1; n < gathered.size() && scattering > 0; ++n)
            all.phases.share[n - 1][slot] = float(gathered[n].scattering(slot) / scattering);
    });
    return all;
}

}  // namespace vdbcloud
