#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/sweep/light_lattice.h"
#include "vdbcloud/voxels/brick_map.h"

#include <openvdb/tools/Morphology.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>

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

/// Where transmittance is wanted: the leaves of a mask in the light grid's own index space, `refine` points a voxel of
/// density. Point n of leaf b is wanted where its bit is set.
struct Wanted {
    openvdb::MaskTree mask;
    int refine;
    std::vector<Vec3i> leaf;     // origins / 8
    std::vector<uint64_t> bits;  // 8 words of 64 a leaf
    int64_t voxels = 0;

    Wanted(const FloatGrid& density, int refine_by) : mask(false), refine(refine_by)
    {
        openvdb::MaskTree coarse(density.tree(), false, true, openvdb::TopologyCopy());
        coarse.voxelizeActiveTiles();
        openvdb::tools::dilateActiveValues(coarse, 1, openvdb::tools::NN_FACE_EDGE_VERTEX,
                                           openvdb::tools::IGNORE_TILES);
        if (refine == 1)
            mask.topologyUnion(coarse);
        else {
            openvdb::tree::ValueAccessor<openvdb::MaskTree> fine(mask);
            for (auto v = coarse.cbeginValueOn(); v; ++v)
                for (int n = 0; n < refine * refine * refine; ++n)
                    fine.setValueOn(openvdb::Coord(v.getCoord()[0] * refine + n / (refine * refine),
                                                   v.getCoord()[1] * refine + n / refine % refine,
                                                   v.getCoord()[2] * refine + n % refine));
        }
        for (auto it = mask.cbeginLeaf(); it; ++it) {
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
    /// The same in density's index space.
    Vec3d index(size_t n) const
    {
        const Vec3i p = point(n);
        return Vec3d(p[0], p[1], p[2]) / refine;
    }
};

/// Lattice depths: for each of the refine^3 offsets within a voxel the lattice is asked at density's voxels.
void lattice_depths(const BrickMap& density, const Vec3d& direction, const TransmittanceOptions& o,
                    const Wanted& wanted, std::vector<float>& depth, const Progress& progress)
{
    const int m = wanted.refine, offsets = m * m * m;
    const auto part = [&](int n) {
        return progress ? Progress([&progress, n, offsets](double f) { return progress((n + f) / offsets); })
                        : Progress();
    };
    VoxelBlocks targets;
    if (m == 1) {
        targets.block = wanted.leaf;
        lattice_depth(density, direction, {o.rays_per_voxel, Vec3d(0)}, targets, part(0));
        depth.swap(targets.value);
        return;
    }
    std::map<std::array<int, 3>, size_t> place;  // of density's blocks that hold wanted points
    for (const auto& leaf : wanted.leaf)
        for (int n = 0; n < 8; ++n) {
            const auto block = [&](int a) {  // of the leaf's first or last point
                return int(std::floor(double(leaf[a] * 8 + ((n >> a) & 1) * 7) / m)) >> 3;
            };
            const std::array<int, 3> b{block(0), block(1), block(2)};
            if (place.emplace(b, targets.block.size()).second) targets.block.push_back({b[0], b[1], b[2]});
        }
    for (int n = 0; n < offsets; ++n) {
        const Vec3i a(n / (m * m), n / m % m, n % m);
        lattice_depth(density, direction, {o.rays_per_voxel, Vec3d(a[0], a[1], a[2]) / m}, targets, part(n));
        tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t leaf) {
            for (size_t k = leaf * 512; k < (leaf + 1) * 512; ++k) {
                const Vec3i p = wanted.point(k);
                const auto low = [&](int axis) { return (p[axis] - a[axis]) / m; };
                if (!wanted.has(k) || low(0) * m + a[0] != p[0] || low(1) * m + a[1] != p[1] ||
                    low(2) * m + a[2] != p[2])
                    continue;
                const auto at = place.find({low(0) >> 3, low(1) >> 3, low(2) >> 3});
                depth[k] =
                    targets.value[at->second * 512 + size_t((low(0) & 7) << 6 | (low(1) & 7) << 3 | (low(2) & 7))];
            }
        });
    }
}

/// Depths at all wanted points from one direction.
void find_depths(const BrickMap& density, const Light& light, const Vec3d& direction, const TransmittanceOptions& o,
                 const Wanted& wanted, std::vector<float>& depth, const Progress& progress)
{
    depth.assign(wanted.leaf.size() * 512, 0.0f);
    if (light.kind == LightKind::Directional && o.fidelity == Fidelity::Lattice) {
        lattice_depths(density, direction, o, wanted, depth, progress);
        return;
    }
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
        for (size_t n = b * 512; n < (b + 1) * 512; ++n)
            if (wanted.has(n)) depth[n] = float(exact_depth(density, light, direction, wanted.index(n)));
        report(progress, double(++done) / double(wanted.leaf.size()));
    });
}

/// Compares with exact rays at voxels spread evenly over the targets.
void compare(const BrickMap& density, const Medium& medium, const Light& light, const std::vector<Vec3d>& directions,
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
        for (const auto& d : directions)
            exact += std::exp(-medium.sigma_t_per_density[0] * exact_depth(density, light, d, wanted.index(sample[s])));
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
    const auto directions = directions_of(light, o.disc_samples);
    std::vector<float> depth, transmittance(wanted.leaf.size() * 512 * channels, 0.0f);
    for (size_t d = 0; d < directions.size(); ++d) {
        const Progress part =
            progress ? Progress([&](double f) { return progress((double(d) + f) / double(directions.size())); })
                     : Progress();
        find_depths(bricks, light, directions[d], o, wanted, depth, part);
        tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
            for (size_t n = b * 512; n < (b + 1) * 512; ++n)
                for (size_t c = 0; c < channels; ++c)
                    transmittance[n * channels + c] +=
                        float(std::exp(-medium.sigma_t_per_density[int(c)] * depth[n]) / double(directions.size()));
        });
    }
    if (report) {
        if (o.fidelity == Fidelity::Lattice && light.kind == LightKind::Directional && o.error_samples > 0)
            compare(bricks, medium, light, directions, o, wanted, transmittance, channels, found);
        *report = found;
    }

    GridBasePtr grid;
    if (channels == 1)
        grid = make_grid<openvdb::FloatGrid>(wanted.mask, transmittance);
    else
        grid = make_grid<openvdb::Vec3SGrid>(wanted.mask, transmittance);
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
