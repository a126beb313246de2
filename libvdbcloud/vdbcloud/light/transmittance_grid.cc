#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/brick_map.h"
#include "vdbcloud/grid/io.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/sweep/light_lattice.h"

#include <openvdb/tools/Morphology.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// The directions that stand for a light: its own, or a sunflower spiral over its disc (equal weights, no randomness).
std::vector<Vec3d> directions_of(const Light& light, int samples)
{
    const Vec3d z = light.to_light.unit();
    if (light.kind == LightKind::Point || !(light.angular_diameter > 0) || samples < 2) return {z};
    const Vec3d x = (std::abs(z[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(z).unit(), y = z.cross(x);
    const double cos_edge = std::cos(light.angular_diameter / 2 * M_PI / 180);
    std::vector<Vec3d> directions;
    for (int n = 0; n < samples; ++n) {
        const double c = 1 - (1 - cos_edge) * (n + 0.5) / samples, s = std::sqrt(1 - c * c);
        const double turn = n * 2.399963229728653;  // the golden angle
        directions.push_back(c * z + s * (std::cos(turn) * x + std::sin(turn) * y));
    }
    return directions;
}

/// Density depth from a point of index space to the light, by a ray of its own.
double exact_depth(const BrickMap& density, const Light& light, const Vec3d& direction, const Vec3d& index)
{
    const Vec3d x = density.world_from_index().point(index);
    if (light.kind == LightKind::Directional)
        return density_depth(density, {x, direction}, 0, std::numeric_limits<double>::infinity());
    const Vec3d to = light.position - x;
    const double r = to.length();
    return r > 0 ? density_depth(density, {x, to / r}, 0, r) : 0;
}

Vec3d voxel(const VoxelBlocks& blocks, size_t n)
{
    const Vec3i& b = blocks.block[n / 512];
    const int o = int(n % 512);
    return {8.0 * b[0] + (o >> 6), 8.0 * b[1] + ((o >> 3) & 7), 8.0 * b[2] + (o & 7)};
}

/// Depths at all targets from one direction.
void find_depths(const BrickMap& density, const Light& light, const Vec3d& direction, const TransmittanceOptions& o,
                 VoxelBlocks& targets, const std::vector<uint64_t>& wanted, const Progress& progress)
{
    if (light.kind == LightKind::Directional && o.fidelity == Fidelity::Lattice) {
        lattice_depth(density, direction, {o.rays_per_voxel, Vec3d(0)}, targets, progress);
        return;
    }
    targets.value.assign(targets.block.size() * 512, 0.0f);
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), targets.block.size(), [&](size_t b) {
        for (size_t n = 0; n < 512; ++n)
            if (wanted[b * 8 + n / 64] >> (n % 64) & 1)
                targets.value[b * 512 + n] = float(exact_depth(density, light, direction, voxel(targets, b * 512 + n)));
        report(progress, double(++done) / double(targets.block.size()));
    });
}

/// Compares with exact rays at voxels spread evenly over the targets.
void compare(const BrickMap& density, const Medium& medium, const Light& light, const std::vector<Vec3d>& directions,
             const TransmittanceOptions& o, const VoxelBlocks& targets, const std::vector<uint64_t>& wanted,
             const std::vector<float>& transmittance, size_t channels, TransmittanceReport& report)
{
    std::vector<size_t> sample;
    const size_t step = std::max<size_t>(1, size_t(report.voxels) / size_t(std::max(1, o.error_samples)));
    size_t seen = 0;
    for (size_t n = 0; n < targets.block.size() * 512; ++n)
        if (wanted[n / 64] >> (n % 64) & 1)
            if (seen++ % step == step / 2) sample.push_back(n);
    std::vector<double> error(sample.size());
    tbb::parallel_for(size_t(0), sample.size(), [&](size_t s) {
        double exact = 0;
        for (const auto& d : directions)
            exact += std::exp(-medium.sigma_t_per_density[0] * exact_depth(density, light, d, voxel(targets, sample[s])));
        error[s] = std::abs(exact / double(directions.size()) - transmittance[sample[s] * channels]);
    });
    report.compared = int(error.size());
    for (const double e : error) {
        report.mean_error += e / double(error.size());
        report.max_error = std::max(report.max_error, e);
    }
}

/// A grid with the topology of `mask`, its leaf values from `value` (channels per voxel, leaves in tree order).
template<typename GridT>
typename GridT::Ptr make_grid(const openvdb::MaskTree& mask, const std::vector<float>& value)
{
    using Tree = typename GridT::TreeType;
    using Value = typename GridT::ValueType;
    constexpr size_t channels = sizeof(Value) / sizeof(float);
    const Value one(1.0f);
    auto tree = std::make_shared<Tree>(mask, one, one, openvdb::TopologyCopy());
    std::vector<typename Tree::LeafNodeType*> leaves;
    tree->getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t b) {
        for (auto v = leaves[b]->beginValueOn(); v; ++v) {
            const float* from = &value[(b * 512 + v.pos()) * channels];
            if constexpr (channels == 1) v.setValue(*from);
            else v.setValue(Value(from[0], from[1], from[2]));
        }
    });
    return GridT::create(tree);
}

}  // namespace

GridBasePtr transmittance_grid(const FloatGrid& density, const Medium& medium, const Light& light,
                               const TransmittanceOptions& o, const Progress& progress, TransmittanceReport* report)
{
    const BrickMap bricks(density);
    openvdb::MaskTree mask(density.tree(), false, true, openvdb::TopologyCopy());
    mask.voxelizeActiveTiles();
    openvdb::tools::dilateActiveValues(mask, 1, openvdb::tools::NN_FACE_EDGE_VERTEX, openvdb::tools::IGNORE_TILES);

    VoxelBlocks targets;
    std::vector<uint64_t> wanted;  // 8 words of 64 voxels a block
    std::vector<const openvdb::MaskTree::LeafNodeType*> leaves;
    mask.getNodes(leaves);
    TransmittanceReport found;
    for (const auto* leaf : leaves) {
        targets.block.push_back({leaf->origin()[0] >> 3, leaf->origin()[1] >> 3, leaf->origin()[2] >> 3});
        for (openvdb::Index w = 0; w < 8; ++w) wanted.push_back(leaf->getValueMask().getWord<openvdb::Index64>(w));
        found.voxels += leaf->onVoxelCount();
    }

    const size_t channels = medium.grey() ? 1 : 3;
    const auto directions = directions_of(light, o.disc_samples);
    std::vector<float> transmittance(targets.block.size() * 512 * channels, 0.0f);
    for (size_t d = 0; d < directions.size(); ++d) {
        const Progress part = progress ? Progress([&](double f) { return progress((double(d) + f) / double(directions.size())); })
                                       : Progress();
        find_depths(bricks, light, directions[d], o, targets, wanted, part);
        tbb::parallel_for(size_t(0), targets.block.size(), [&](size_t b) {
            for (size_t n = b * 512; n < (b + 1) * 512; ++n)
                for (size_t c = 0; c < channels; ++c)
                    transmittance[n * channels + c] += float(
                        std::exp(-medium.sigma_t_per_density[int(c)] * targets.value[n]) / double(directions.size()));
        });
    }
    if (report) {
        if (o.fidelity == Fidelity::Lattice && light.kind == LightKind::Directional && o.error_samples > 0)
            compare(bricks, medium, light, directions, o, targets, wanted, transmittance, channels, found);
        *report = found;
    }

    GridBasePtr grid;
    if (channels == 1) grid = make_grid<openvdb::FloatGrid>(mask, transmittance);
    else grid = make_grid<openvdb::Vec3SGrid>(mask, transmittance);
    grid->setName(transmittance_name(light));
    grid->setTransform(density.transform().copy());
    grid->setGridClass(openvdb::GRID_UNKNOWN);
    write_light(*grid, light);
    write_medium(*grid, medium);
    set_text(*grid, schema::density_digest, grid_digest(density));
    return grid;
}

}  // namespace vdbcloud
