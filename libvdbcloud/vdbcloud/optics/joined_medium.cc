#include "vdbcloud/optics/joined_medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/optics/joined_grids.h"
#include "vdbcloud/voxels/extend.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace vdbcloud {

namespace {

std::string text(const Vec3d& v)
{
    std::ostringstream out;
    out << v[0] << ',' << v[1] << ',' << v[2];
    return out.str();
}

/// sigma_t of `part` over that of `lead`, one number for all channels; none if there is no such number.
std::optional<double> proportion(const MediumPart& part, const MediumPart& lead)
{
    const Vec3d &ours = part.medium.sigma_t_per_density, &theirs = lead.medium.sigma_t_per_density;
    double ratio = -1;
    bool proportional = true;
    for (int c = 0; c < 3; ++c) {
        if (theirs[c] == 0) {
            proportional = proportional && ours[c] == 0;
            continue;
        }
        if (ratio < 0) ratio = ours[c] / theirs[c];
        proportional = proportional && std::abs(ours[c] - ratio * theirs[c]) <= 1e-9 * std::max(ours[c], theirs[c]);
    }
    return proportional && ratio >= 0 ? std::optional(ratio) : std::nullopt;
}

double extinction_ratio(const MediumPart& part, const MediumPart& lead)
{
    if (const auto ratio = proportion(part, lead)) return *ratio;
    throw UsageError(lead.name + " has the extinction " + text(lead.medium.sigma_t_per_density) + " and " + part.name +
                     " " + text(part.medium.sigma_t_per_density) +
                     ": one density needs extinctions that are proportional over r, g and b. Give one with "
                     "--extinction for all, or give the files to p1solve or render, which keep them apart");
}

void require_one_phase(const MediumPart& a, const MediumPart& b)
{
    if (a.medium.phase == b.medium.phase) return;
    throw UsageError(
        a.name + " has the phase function " + a.medium.phase.text() + " and " + b.name + " " + b.medium.phase.text() +
        ": one medium has one. Give one with --phase for all, or give the files to p1solve or render, which "
        "keep them apart");
}

/// Numbers of the parts that have matter.
std::vector<size_t> with_matter(const std::vector<MediumPart>& parts)
{
    std::vector<size_t> found;
    for (size_t n = 0; n < parts.size(); ++n)
        if (has_matter(*parts[n].density)) found.push_back(n);
    return found;
}

bool scatters(const MediumPart& part) { return !(part.medium.albedo == Vec3d(0.0)); }

/// The albedo at voxels of a density, within [0, 1]. One object per thread, as VoxelMean.
class Albedo {
public:
    Albedo(const MediumPart& part) : albedo_(part.medium.albedo)
    {
        if (part.colour) colour_.emplace(*part.colour, part.density->transform());
    }
    Vec3d operator()(const openvdb::Coord& voxel) const
    {
        if (!colour_) return albedo_;
        Vec3d a = albedo_ * Vec3d((*colour_)(voxel.asVec3i()));
        for (int c = 0; c < 3; ++c) a[c] = std::clamp(a[c], 0.0, 1.0);
        return a;
    }

private:
    Vec3d albedo_;
    std::optional<VoxelMean> colour_;
};

/// Calls visit(leaf) for each leaf of a grid, in parallel.
template<typename Visit>
void for_each_leaf(Vec3SGrid& grid, const Visit& visit)
{
    std::vector<openvdb::Vec3STree::LeafNodeType*> leaves;
    grid.tree().getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t n) { visit(*leaves[n]); });
}

/// A grid of vectors with the active topology of a density.
Vec3SGridPtr vectors_like(const FloatGrid& density, float background)
{
    auto out = Vec3SGrid::create(Vec3f(background));
    out->setTree(std::make_shared<openvdb::Vec3STree>(density.tree(), Vec3f(background), openvdb::TopologyCopy()));
    out->setTransform(density.transform().copy());
    return out;
}

/// density x albedo, where density is active.
Vec3SGridPtr scattering_of(const MediumPart& part)
{
    auto out = vectors_like(*part.density, 0);
    if (part.colour) out->tree().voxelizeActiveTiles();
    const openvdb::FloatTree& density = part.density->tree();
    const Albedo of_tile(part);
    for_each_active_tile(*out, [&](const auto& tile) {
        tile.setValue(Vec3f(double(density.getValue(tile.getCoord())) * of_tile(tile.getCoord())));
    });
    for_each_leaf(*out, [&](auto& leaf) {
        const openvdb::tree::ValueAccessor<const openvdb::FloatTree> at(density);
        const Albedo albedo(part);
        for (auto v = leaf.beginValueOn(); v; ++v)
            v.setValue(Vec3f(double(at.getValue(v.getCoord())) * albedo(v.getCoord())));
    });
    return out;
}

/// scattering / (density x albedo) where density is above 0, and one voxel about.
Vec3SGridPtr colour_grid(const FloatGrid& density, const Vec3SGrid& scattering, const Vec3d& albedo)
{
    const auto out = vectors_like(density, 1);
    out->tree().voxelizeActiveTiles();
    for_each_leaf(*out, [&](auto& leaf) {
        const openvdb::tree::ValueAccessor<const openvdb::FloatTree> density_at(density.tree());
        const openvdb::tree::ValueAccessor<const openvdb::Vec3STree> scattering_at(scattering.tree());
        for (auto v = leaf.beginValueOn(); v; ++v) {
            const double d = density_at.getValue(v.getCoord());
            if (!(d > 0)) {
                v.setValueOff();
                continue;
            }
            const Vec3f s = scattering_at.getValue(v.getCoord());
            Vec3f factor(1.0f);
            for (int c = 0; c < 3; ++c)
                if (albedo[c] > 0) factor[c] = float(double(s[c]) / (d * albedo[c]));
            v.setValue(factor);
        }
    });
    return with_fringe(*out);
}

Vec3SGridPtr joined_emission(const std::vector<MediumPart>& parts)
{
    std::vector<Summand<Vec3SGrid>> glow;
    for (const MediumPart& part : parts)
        if (emits(part.emission.get())) glow.push_back({part.emission, 1.0, part.name});
    if (glow.empty()) return nullptr;
    const auto& first = *glow[finest(glow)].grid;
    std::vector<double> kept;
    auto sum = sum_on_lattice(glow, first.transform(), kept);
    sum->setName(first.getName());
    return sum;
}

/// Whether no one medium stands for parts that have matter.
bool overlap(const std::vector<MediumPart>& parts, const std::vector<size_t>& matter)
{
    const MediumPart* scattering = nullptr;
    for (const size_t n : matter) {
        if (!proportion(parts[n], parts[matter.front()])) return true;
        if (!scatters(parts[n])) continue;
        if (scattering && scattering->medium.phase != parts[n].medium.phase) return true;
        scattering = &parts[n];
    }
    return false;
}

double mean_extinction(const MediumPart& part)
{
    const Vec3d& sigma_t = part.medium.sigma_t_per_density;
    return (sigma_t[0] + sigma_t[1] + sigma_t[2]) / 3;
}

/// Sets the density, on the finest lattice. Returns the factors that keep the mass of each summand.
std::vector<double> set_density(const std::vector<Summand<FloatGrid>>& densities, const FloatGrid& lead,
                                JoinedMedium& joined)
{
    std::vector<double> kept;
    joined.density = sum_on_lattice(densities, densities[finest(densities)].grid->transform(), kept);
    joined.density->setName(lead.getName());
    joined.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (size_t n = 0; n < kept.size(); ++n)
        if (kept[n] != 1) joined.resampled.push_back({densities[n].name, kept[n]});
    return kept;
}

/// Sets density and parts of media that overlap.
void keep_parts(const std::vector<MediumPart>& parts, const std::vector<size_t>& matter, JoinedMedium& joined)
{
    std::vector<Summand<FloatGrid>> densities;
    const MediumPart& lead = parts[joined.lead];
    for (const size_t n : matter)
        densities.push_back({parts[n].density, mean_extinction(parts[n]) / mean_extinction(lead), parts[n].name});
    const std::vector<double> kept = set_density(densities, *lead.density, joined);
    joined.medium.sigma_t_per_density = Vec3d(mean_extinction(lead));
    for (size_t n = 0; n < matter.size(); ++n) {
        MediumPart& part = joined.parts.emplace_back(parts[matter[n]]);
        std::vector<double> factor{kept[n]};
        const std::vector<Summand<FloatGrid>> own{{parts[matter[n]].density, 1.0, part.name}};
        part.density = sum_on_lattice(own, joined.density->transform(), factor);
        part.density->setGridClass(openvdb::GRID_FOG_VOLUME);
        part.emission = nullptr;
    }
}

}  // namespace

bool has_matter(const FloatGrid& density)
{
    bool found = false;
    for_each_active_tile(density, [&](const auto& tile) { found = found || *tile > 0; });
    for (auto leaf = density.tree().cbeginLeaf(); leaf && !found; ++leaf)
        for (auto v = leaf->cbeginValueOn(); v && !found; ++v) found = *v > 0;
    return found;
}

JoinedMedium joined_medium(const std::vector<MediumPart>& parts, bool may_overlap)
{
    JoinedMedium joined;
    joined.emission = joined_emission(parts);
    const std::vector<size_t> matter = with_matter(parts);
    joined.lead = matter.empty() ? 0 : matter.front();
    const MediumPart& lead = parts.at(joined.lead);
    joined.medium = lead.medium;
    if (may_overlap && overlap(parts, matter)) {
        keep_parts(parts, matter, joined);
        return joined;
    }

    std::vector<Summand<FloatGrid>> densities;
    std::vector<size_t> scattering_parts;
    bool one_albedo = true;
    Vec3d most = lead.medium.albedo;
    for (const size_t n : matter) {
        const MediumPart& part = parts[n];
        densities.push_back({part.density, extinction_ratio(part, lead), part.name});
        one_albedo = one_albedo && !part.colour && part.medium.albedo == lead.medium.albedo;
        for (int c = 0; c < 3; ++c) most[c] = std::max(most[c], part.medium.albedo[c]);
        if (!scatters(part)) continue;
        if (!scattering_parts.empty()) require_one_phase(parts[scattering_parts.front()], part);
        scattering_parts.push_back(n);
    }
    if (!scattering_parts.empty()) joined.medium.phase = parts[scattering_parts.front()].medium.phase;
    joined.medium.albedo = most;
    if (densities.empty()) {
        joined.density = lead.density->deepCopy();
        return joined;
    }

    std::vector<double> kept = set_density(densities, *lead.density, joined);
    if (one_albedo) return joined;

    std::vector<Summand<Vec3SGrid>> scattering;
    for (size_t n = 0; n < matter.size(); ++n)
        scattering.push_back({scattering_of(parts[matter[n]]), densities[n].scale, densities[n].name});
    joined.colour = colour_grid(*joined.density, *sum_on_lattice(scattering, joined.density->transform(), kept), most);
    joined.colour->setName("Cd");
    return joined;
}

}  // namespace vdbcloud
