#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/sweep/light_lattice.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/extend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace vdbcloud {

namespace {

/// Where transmittance is wanted, in the light grid's own index space, `refine` points a voxel of density: at the
/// leaves of `tree`, whose values mean nothing. Point n of leaf b is wanted where its bit is set.
struct Wanted {
    openvdb::FloatTree::Ptr tree;
    int refine;
    std::vector<Vec3i> leaf;     // origins / 8
    std::vector<uint64_t> bits;  // 8 words of 64 a leaf
    int64_t voxels = 0;

    Wanted(const FloatGrid& density, int refine_by) : refine(refine_by)
    {
        const FloatGridPtr coarse = with_fringe(density);
        if (refine == 1) {
            tree = coarse->treePtr();
        } else {
            tree = std::make_shared<openvdb::FloatTree>(0.0f);
            openvdb::tree::ValueAccessor<openvdb::FloatTree> fine(*tree);
            for (auto v = coarse->cbeginValueOn(); v; ++v)
                for (int n = 0; n < refine * refine * refine; ++n)
                    fine.setValueOn(openvdb::Coord(v.getCoord()[0] * refine + n / (refine * refine),
                                                   v.getCoord()[1] * refine + n / refine % refine,
                                                   v.getCoord()[2] * refine + n % refine));
        }
        for (auto it = tree->cbeginLeaf(); it; ++it) {
            leaf.push_back({it->origin()[0] >> 3, it->origin()[1] >> 3, it->origin()[2] >> 3});
            for (openvdb::Index w = 0; w < 8; ++w) bits.push_back(it->getValueMask().getWord<openvdb::Index64>(w));
            voxels += it->onVoxelCount();
        }
    }

    bool has(size_t n) const { return bits[n / 64] >> (n % 64) & 1; }

    /// Point n in the light grid's index space, integers.
    Vec3i point(size_t n) const
    {
        const int o = int(n % 512);
        return leaf[n / 512] * 8 + Vec3i(o >> 6, (o >> 3) & 7, o & 7);
    }
    Vec3d world(size_t n, const BrickMap& density) const
    {
        const Vec3i p = point(n);
        return density.world_from_index().point(Vec3d(p[0], p[1], p[2]) / refine);
    }
};

/// Depths at all wanted points to one light without extent.
std::vector<float> find_depths(const BrickMap& density, const LightModel& light, const TransmittanceOptions& o,
                               const Wanted& wanted, const Progress& progress)
{
    if (const auto to_light = light.common_direction(); to_light && o.fidelity == Fidelity::Lattice)
        return lattice_depths(density, *to_light, wanted.leaf, {o.rays_per_voxel, Vec3d(0), o.refine}, progress);
    std::vector<float> depth(wanted.leaf.size() * 512, 0.0f);
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
        for (size_t n = b * 512; n < (b + 1) * 512; ++n)
            if (wanted.has(n)) depth[n] = float(depth_to_light(density, light, wanted.world(n, density)));
        report(progress, double(++done) / double(wanted.leaf.size()));
    });
    return depth;
}

/// Compares with exact rays at voxels spread evenly over the targets.
void compare(const BrickMap& density, const Medium& medium, const std::vector<std::shared_ptr<const LightModel>>& parts,
             const TransmittanceOptions& o, const Wanted& wanted, const std::vector<float>& transmittance,
             size_t channels, TransmittanceReport& report)
{
    std::vector<size_t> sample;
    const size_t step = std::max<size_t>(1, size_t(report.voxels) / size_t(std::max(1, o.error_samples)));
    size_t seen = 0;
    for (size_t n = 0; n < wanted.leaf.size() * 512; ++n)
        if (wanted.has(n))
            if (seen++ % step == step / 2) sample.push_back(n);
    std::vector<double> error(sample.size());
    tbb::parallel_for(size_t(0), sample.size(), [&](size_t s) {
        double exact = 0;
        for (const auto& part : parts)
            exact += std::exp(-medium.sigma_t_per_density[0] *
                              depth_to_light(density, *part, wanted.world(sample[s], density)));
        error[s] = std::abs(exact / double(parts.size()) - transmittance[sample[s] * channels]);
    });
    report.compared = int(error.size());
    for (const double e : error) {
        report.mean_error += e / double(error.size());
        report.max_error = std::max(report.max_error, e);
    }
}

/// A grid with the topology of another tree, its leaf values from `value` (channels per voxel, leaves in tree order).
template<typename GridT>
typename GridT::Ptr make_grid(const openvdb::FloatTree& topology, const std::vector<float>& value)
{
    using Tree = typename GridT::TreeType;
    using Value = typename GridT::ValueType;
    constexpr size_t channels = sizeof(Value) / sizeof(float);
    const Value one(1.0f);
    auto tree = std::make_shared<Tree>(topology, one, one, openvdb::TopologyCopy());
    std::vector<typename Tree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t b) {
        for (auto v = leaves[b]->beginValueOn(); v; ++v) {
            const float* from = &value[(b * 512 + v.pos()) * channels];
            if constexpr (channels == 1)
                v.setValue(*from);
            else
                v.setValue(Value(from[0], from[1], from[2]));
        }
    });
    return GridT::create(tree);
}

}  // namespace

GridBasePtr transmittance_grid(const FloatGrid& density, const Medium& medium, const Light& light,
                               const TransmittanceOptions& o, const Progress& progress, TransmittanceReport* report)
{
    if (o.refine < 1 || o.refine > 8) throw InputError("refine " + std::to_string(o.refine) + ": expected 1 to 8");
    if (o.rays_per_voxel < 1 || o.rays_per_voxel > 8)
        throw InputError("rays per voxel " + std::to_string(o.rays_per_voxel) + ": expected 1 to 8");
    const BrickMap bricks(density);
    const Wanted wanted(density, o.refine);
    TransmittanceReport found;
    found.voxels = wanted.voxels;

    const size_t channels = medium.grey() ? 1 : 3;
    const auto parts = light.parts(o.disc_samples);
    std::vector<float> transmittance(wanted.leaf.size() * 512 * channels, 0.0f);
    for (size_t p = 0; p < parts.size(); ++p) {
        const Progress of_part =
            progress ? Progress([&](double f) { return progress((double(p) + f) / double(parts.size())); })
                     : Progress();
        const std::vector<float> depth = find_depths(bricks, *parts[p], o, wanted, of_part);
        tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
            for (size_t n = b * 512; n < (b + 1) * 512; ++n)
                for (size_t c = 0; c < channels; ++c)
                    transmittance[n * channels + c] +=
                        float(std::exp(-medium.sigma_t_per_density[int(c)] * depth[n]) / double(parts.size()));
        });
    }
    if (report) {
        if (o.fidelity == Fidelity::Lattice && light->common_direction() && o.error_samples > 0)
            compare(bricks, medium, parts, o, wanted, transmittance, channels, found);
        *report = found;
    }

    GridBasePtr grid;
    if (channels == 1)
        grid = make_grid<openvdb::FloatGrid>(*wanted.tree, transmittance);
    else
        grid = make_grid<openvdb::Vec3SGrid>(*wanted.tree, transmittance);
    grid->setName(transmittance_name(light));
    grid->setTransform(density.transform().copy());
    if (o.refine > 1) grid->transform().preScale(1.0 / o.refine);
    grid->setGridClass(openvdb::GRID_UNKNOWN);
    write_light(*grid, light);
    write_medium(*grid, medium);
    set_text(*grid, schema::density_digest, grid_digest(density));
    return grid;
}

}  // namespace vdbcloud
