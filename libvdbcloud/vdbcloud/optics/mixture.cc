#include "vdbcloud/optics/mixture.h"

#include "vdbcloud/core/shortest.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <algorithm>
#include <optional>

namespace vdbcloud {

namespace {

std::string text(const Vec3d& v) { return shortest(v[0]) + ',' + shortest(v[1]) + ',' + shortest(v[2]); }

std::string joined(const std::string& all, const char* separator, const std::string& next)
{
    return all.empty() ? next : all + separator + next;
}

/// 1 - delta_f albedo at the voxels of a part, of one channel.
class Scaling {
public:
    Scaling(const MediumPart& part, const DeltaScaling& delta, int channel)
        : delta_(delta), channel_(channel), albedo_(part.medium.albedo[channel])
    {
        if (part.colour && delta.delta_f > 0) colour_.emplace(*part.colour, part.density->transform());
    }
    double operator()(const openvdb::Coord& voxel) const
    {
        if (!colour_) return delta_.extinction(albedo_);
        return delta_.extinction(std::clamp(albedo_ * (*colour_)(voxel.asVec3i())[channel_], 0.0, 1.0));
    }

private:
    const DeltaScaling& delta_;
    int channel_;
    double albedo_;
    std::optional<VoxelMean> colour_;
};

}  // namespace

std::vector<DeltaScaling> scalings_of(const std::vector<MediumPart>& parts, int degree, bool delta)
{
    std::vector<DeltaScaling> scalings;
    for (const MediumPart& part : parts)
        scalings.push_back(delta ? delta_scaling(part.medium.phase, degree) : no_scaling(part.medium.phase, degree));
    return scalings;
}

std::string mixture_text(const std::vector<MediumPart>& parts, const std::vector<DeltaScaling>& scalings)
{
    std::string all;
    for (size_t n = 0; n < parts.size(); ++n) {
        const Medium& medium = parts[n].medium;
        std::string phase = medium.phase.name();
        for (const double parameter : medium.phase.parameters()) phase += ' ' + shortest(parameter);
        all = joined(all, "; ",
                     text(medium.sigma_t_per_density) + ' ' + text(medium.albedo) + ' ' + phase + ", delta_f " +
                         shortest(scalings[n].delta_f));
    }
    return all;
}

Sources sources_of(const std::vector<MediumPart>& parts, const Vec3SGrid* emission)
{
    Sources all;
    for (const MediumPart& part : parts) {
        const Sources own = sources_of(*part.density, part.colour.get(), emission);
        all = {joined(all.density, "+", own.density), joined(all.colour, "+", own.colour), own.emission};
    }
    return all;
}

bool same_extinction(const std::vector<MediumPart>& parts, const std::vector<DeltaScaling>& scalings, int channel,
                     int other)
{
    for (size_t n = 0; n < parts.size(); ++n) {
        const Medium& medium = parts[n].medium;
        if (medium.sigma_t_per_density[channel] != medium.sigma_t_per_density[other]) return false;
        if (scalings[n].delta_f > 0 && (parts[n].colour || medium.albedo[channel] != medium.albedo[other]))
            return false;
    }
    return true;
}

FloatGridPtr extinction_of(const std::vector<MediumPart>& parts, const std::vector<DeltaScaling>& scalings, int channel)
{
    auto all = FloatGrid::create(0.0f);
    all->setTransform(parts.at(0).density->transform().copy());
    for (const MediumPart& part : parts) all->topologyUnion(*part.density);
    all->tree().voxelizeActiveTiles();
    std::vector<double> sum;
    for (auto leaf = all->tree().beginLeaf(); leaf; ++leaf) {
        sum.assign(openvdb::FloatTree::LeafNodeType::SIZE, 0.0);
        for (size_t n = 0; n < parts.size(); ++n) {
            const Scaling scaling(parts[n], scalings[n], channel);
            const double sigma_t = parts[n].medium.sigma_t_per_density[channel];
            const auto density = parts[n].density->getConstAccessor();
            for (auto v = leaf->cbeginValueOn(); v; ++v)
                if (const float d = density.getValue(v.getCoord()); d > 0 && density.isValueOn(v.getCoord()))
                    sum[v.pos()] += sigma_t * d * scaling(v.getCoord());
        }
        for (auto v = leaf->beginValueOn(); v; ++v) v.setValue(float(sum[v.pos()]));
    }
    return all;
}

}  // namespace vdbcloud
