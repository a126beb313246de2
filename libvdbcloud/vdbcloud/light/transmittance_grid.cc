#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/optics/periodic_light.h"
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/sweep/light_lattice.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/extend.h"
#include "vdbcloud/voxels/lattice.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <optional>

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

    Wanted(const FloatGrid& density, int refine_by, const Period& period) : refine(refine_by)
    {
        const FloatGridPtr coarse = voxels_with_fringe(density, period);
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

/// A medium that light crosses, as rays need it.
struct Crossed {
    const BrickMap& density;
    Vec3d sigma_t;  ///< extinction at density 1 [1/world unit]
    /// From a voxel of the wanted points' density to that place in `density`'s lattice; none: another lattice.
    std::optional<Vec3d> shift;
};

/// Depths on the lattice of `density`, at voxels that lie `shift` from the voxels of the blocks `wanted`.
std::vector<float> shifted_depths(const BrickMap& density, const Vec3d& to_light, const std::vector<Vec3i>& wanted,
                                  const Vec3d& shift, int rays_per_voxel, const Progress& progress)
{
    const Vec3i by(int(std::floor(shift[0])), int(std::floor(shift[1])), int(std::floor(shift[2])));
    const auto before = [](const Vec3i& p, const Vec3i& q) {
        return p[0] != q[0] ? p[0] < q[0] : p[1] != q[1] ? p[1] < q[1] : p[2] < q[2];
    };
    std::vector<Vec3i> blocks;
    for (const Vec3i& b : wanted)
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3i last = b * 8 + by + Vec3i(corner & 1, corner >> 1 & 1, corner >> 2) * 7;
            blocks.push_back({last[0] >> 3, last[1] >> 3, last[2] >> 3});
        }
    std::sort(blocks.begin(), blocks.end(), before);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    const std::vector<float> there =
        lattice_depths(density, to_light, blocks, {rays_per_voxel, shift - Vec3d(by[0], by[1], by[2]), 1}, progress);
    std::vector<float> depth(wanted.size() * 512);
    tbb::parallel_for(size_t(0), wanted.size(), [&](size_t b) {
        for (int k = 0; k < 512; ++k) {
            const Vec3i voxel = wanted[b] * 8 + Vec3i(k >> 6, k >> 3 & 7, k & 7) + by;
            const Vec3i block(voxel[0] >> 3, voxel[1] >> 3, voxel[2] >> 3);
            const auto place = size_t(std::lower_bound(blocks.begin(), blocks.end(), block, before) - blocks.begin());
            depth[b * 512 + size_t(k)] =
                there[place * 512 + size_t((voxel[0] & 7) << 6 | (voxel[1] & 7) << 3 | (voxel[2] & 7))];
        }
    });
    return depth;
}

/// Depths at all wanted points to one light without extent, through one medium. `centres`: the density whose voxels the
/// points belong to.
std::vector<float> find_depths(const Crossed& medium, const BrickMap& centres, const LightModel& light,
                               const TransmittanceOptions& o, const Wanted& wanted, const Progress& progress,
                               std::atomic<size_t>* products = nullptr)
{
    const BrickMap& density = medium.density;
    const auto to_light = light.common_direction();
    if (to_light && o.fidelity == Fidelity::Lattice && medium.shift && !density.repeats()) {
        if (*medium.shift == Vec3d(0.0))
            return lattice_depths(density, *to_light, wanted.leaf, {o.rays_per_voxel, Vec3d(0), o.refine, products},
                                  progress);
        if (o.refine == 1)
            return shifted_depths(density, *to_light, wanted.leaf, *medium.shift, o.rays_per_voxel, progress);
    }
    std::vector<float> depth(wanted.leaf.size() * 512, 0.0f);
    std::atomic<size_t> done{0};
    tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
        for (size_t n = b * 512; n < (b + 1) * 512; ++n)
            if (wanted.has(n)) depth[n] = float(depth_to_light(density, light, wanted.world(n, centres)));
        report(progress, double(++done) / double(wanted.leaf.size()));
    });
    return depth;
}

/// True if the depth is above 0 at a wanted point.
bool shades(const std::vector<float>& depth, const Wanted& wanted)
{
    for (size_t n = 0; n < depth.size(); ++n)
        if (depth[n] > 0 && wanted.has(n)) return true;
    return false;
}

/// Whether solids hide a light without extent from x.
bool hidden(const SolidRays& solids, const LightModel& light, const Vec3d& x)
{
    const Sight sight = light.towards(x);
    return solids.blocked({x, sight.direction}, sight.distance);
}

/// The mean over the light's parts of exp(-tau), 0 for those that solids hide, at all wanted points, `channels` values
/// a point. media[0] is the medium that the points belong to. Empty if `only_if_shaded` and no other medium shades a
/// point.
std::vector<float> find_transmittance(const std::vector<Crossed>& media,
                                      const std::vector<std::shared_ptr<const LightModel>>& parts, size_t channels,
                                      bool only_if_shaded, const SolidRays& solids, const TransmittanceOptions& o,
                                      const Wanted& wanted, const Progress& progress,
                                      std::atomic<size_t>* products = nullptr)
{
    const double steps = double(parts.size() * media.size());
    const auto depths = [&](size_t p, size_t m) {
        const double before = double(p * media.size() + m);
        const Progress of_step =
            progress ? Progress([&, before](double f) { return progress((before + f) / steps); }) : Progress();
        return find_depths(media[m], media[0].density, *parts[p], o, wanted, of_step, products);
    };
    std::vector<float> transmittance(wanted.leaf.size() * 512 * channels, 0.0f);
    bool shaded = !only_if_shaded;
    for (size_t p = 0; p < parts.size(); ++p) {
        std::vector<std::vector<float>> depth(media.size());
        for (size_t m = 1; m < media.size(); ++m) {
            depth[m] = depths(p, m);
            shaded = shaded || shades(depth[m], wanted);
        }
        if (!shaded && parts.size() == 1) return {};
        depth[0] = depths(p, 0);
        tbb::parallel_for(size_t(0), wanted.leaf.size(), [&](size_t b) {
            for (size_t n = b * 512; n < (b + 1) * 512; ++n) {
                if (!solids.empty() && wanted.has(n) && hidden(solids, *parts[p], wanted.world(n, media[0].density)))
                    continue;
                for (size_t c = 0; c < channels; ++c) {
                    double tau = 0;
                    for (size_t m = 0; m < media.size(); ++m) tau += media[m].sigma_t[int(c)] * depth[m][n];
                    transmittance[n * channels + c] += float(std::exp(-tau) / double(parts.size()));
                }
            }
        });
    }
    if (!shaded) transmittance.clear();
    return transmittance;
}

/// Compares with exact rays at voxels spread evenly over the targets.
void compare(const BrickMap& density, const Medium& medium, const std::vector<std::shared_ptr<const LightModel>>& parts,
             const SolidRays& solids, const TransmittanceOptions& o, const Wanted& wanted,
             const std::vector<float>& transmittance, size_t channels, TransmittanceReport& report)
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
        const Vec3d x = wanted.world(sample[s], density);
        for (const auto& part : parts)
            if (solids.empty() || !hidden(solids, *part, x))
                exact += std::exp(-medium.sigma_t_per_density[0] * depth_to_light(density, *part, x));
        error[s] = std::abs(exact / double(parts.size()) - transmittance[sample[s] * channels]);
    });
    report.compared = int(error.size());
    for (const double e : error) {
        report.mean_error += e / double(error.size());
        report.max_error = std::max(report.max_error, e);
    }
}

/// Wanted points that none of the light reaches.
int64_t dark_points(const std::vector<float>& transmittance, size_t channels, const Wanted& wanted)
{
    int64_t dark = 0;
    for (size_t n = 0; n < wanted.leaf.size() * 512; ++n)
        dark += wanted.has(n) && std::all_of(&transmittance[n * channels], &transmittance[n * channels] + channels,
                                             [](float t) { return t == 0; });
    return dark;
}

/// Steps of a ray from a wanted point to a light, the mean of some hundred points.
double mean_steps(const BrickMap& density, const LightModel& light, const Wanted& wanted)
{
    const size_t step = std::max<size_t>(1, size_t(wanted.voxels) / 300);
    size_t seen = 0, rays = 0, steps = 0;
    for (size_t n = 0; n < wanted.leaf.size() * 512; ++n) {
        if (!wanted.has(n) || seen++ % step != step / 2) continue;
        const Vec3d x = wanted.world(n, density);
        const Sight sight = light.towards(x);
        ++rays;
        steps += count_steps(density, IndexRay(density.index_from_world(), {x, sight.direction}), 0, sight.distance);
    }
    return rays ? double(steps) / double(rays) : 0;
}

template<typename TreeT>
void set_leaves(TreeT& tree, const std::vector<float>& value)
{
    using Value = typename TreeT::ValueType;
    constexpr size_t channels = openvdb::VecTraits<Value>::Size;
    std::vector<typename TreeT::LeafNodeType*> leaves;
    tree.getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t b) {
        for (auto v = leaves[b]->beginValueOff(); v; ++v) v.setValue(Value(1.0f));
        for (auto v = leaves[b]->beginValueOn(); v; ++v) {
            const float* from = &value[(b * 512 + v.pos()) * channels];
            if constexpr (channels == 1)
                v.setValue(*from);
            else
                v.setValue(Value(from[0], from[1], from[2]));
        }
    });
}

/// A grid with the topology of `tree`, its leaf values from `value` (channels per voxel, leaves in tree order), 1
/// elsewhere. A grid of one channel takes the tree itself.
GridBasePtr make_grid(const openvdb::FloatTree::Ptr& tree, const std::vector<float>& value, size_t channels)
{
    if (channels == 1) {
        tree->root().setBackground(1.0f, /*updateChildNodes=*/true);
        set_leaves(*tree, value);
        return FloatGrid::create(tree);
    }
    const Vec3f one(1.0f);
    auto coloured = std::make_shared<openvdb::Vec3STree>(*tree, one, one, openvdb::TopologyCopy());
    set_leaves(*coloured, value);
    return Vec3SGrid::create(coloured);
}

void check(const TransmittanceOptions& o)
{
    if (o.refine < 1 || o.refine > 8) throw InputError("refine " + std::to_string(o.refine) + ": expected 1 to 8");
    if (o.rays_per_voxel < 1 || o.rays_per_voxel > 8)
        throw InputError("rays per voxel " + std::to_string(o.rays_per_voxel) + ": expected 1 to 8");
}

/// The grid of the wanted points of a density, which takes their tree, with the metadata of its light and medium.
GridBasePtr made_grid(const FloatGrid& density, const Medium& medium, const Light& light, const Wanted& wanted,
                      const std::vector<float>& transmittance, size_t channels, const TransmittanceOptions& o)
{
    const GridBasePtr grid = make_grid(wanted.tree, transmittance, channels);
    grid->setName(transmittance_name(light));
    grid->setTransform(density.transform().copy());
    if (wanted.refine > 1) grid->transform().preScale(1.0 / wanted.refine);
    grid->setGridClass(openvdb::GRID_UNKNOWN);
    write_light(*grid, light);
    write_medium(*grid, medium);
    write_periodic(*grid, o.periodic);
    if (!o.solids.empty()) set_text(*grid, schema::solids, solids_digest(o.solids, /*materials=*/false));
    return grid;
}

/// The shift from the voxels of `at` to those of `other` where both lattices have the same axes.
std::optional<Vec3d> shift_between(const FloatGrid& at, const FloatGrid& other)
{
    const auto box = at.evalActiveVoxelBoundingBox();
    if (box.empty()) return std::nullopt;
    return lattice_shift(index_map(at.transform(), other.transform()), box.min().asVec3d(), box.max().asVec3d());
}

}  // namespace

Accuracy accuracy_of(const TransmittanceReport& report)
{
    Accuracy accuracy;
    if (report.compared > 0) {
        accuracy.add("mean_transmittance_error", report.mean_error);
        accuracy.add("max_transmittance_error", report.max_error);
    }
    return accuracy;
}

namespace {

/// transmittance_grid() of one medium. `report` is null, or empty.
GridBasePtr find_grid(const FloatGrid& density, const Medium& medium, const Light& light, const TransmittanceOptions& o,
                      const Progress& progress, TransmittanceReport* report)
{
    check(o);
    require_light_that_leaves(light, index_from_world(density.transform(), density.getName()), o.periodic);
    const Period period = period_of(density, o.periodic);
    const Wanted wanted(density, o.refine, period);
    std::optional<BrickMap> bricks(std::in_place, density, 0.0f, BrickMap::Map(), period);
    const size_t channels = medium.grey() ? 1 : 3;
    const auto parts = light.parts(o.disc_samples);
    const SolidRays solids(o.solids);
    std::atomic<size_t> products{0};
    const std::vector<float> transmittance =
        find_transmittance({{*bricks, medium.sigma_t_per_density, Vec3d(0.0)}}, parts, channels, false, solids, o,
                           wanted, progress, &products);
    if (report) {
        report->work.add("light_point", double(wanted.leaf.size() * 512 * parts.size()));
        report->work.add("lattice_product", double(products));
        report->voxels = wanted.voxels;
        if (!o.solids.empty()) {
            report->work.add("solid_ray", double(wanted.voxels) * double(parts.size()) * double(o.solids.size()));
            report->hidden = dark_points(transmittance, channels, wanted);
        }
        if (o.fidelity == Fidelity::Lattice && light->common_direction() && !period.any() && o.error_samples > 0)
            compare(*bricks, medium, parts, solids, o, wanted, transmittance, channels, *report);
    }
    bricks.reset();
    GridBasePtr grid = made_grid(density, medium, light, wanted, transmittance, channels, o);
    set_text(*grid, schema::density_digest, grid_digest(density));
    return grid;
}

void add_fields(EffectCosts& costs, const GridBase& grid, const TransmittanceOptions& o, const Workload& work)
{
    const double bytes = double(grid.memUsage());
    costs.hold(Effect::Lights, 1, bytes);
    if (!grid.isType<FloatGrid>()) {
        costs.enter(Effect::Colour);
        costs.hold(Effect::Colour, 2, bytes * 2 / 3);
    }
    if (!o.solids.empty()) {
        costs.enter(Effect::Solids, work.of("solid_ray"));
        costs.hold(Effect::Solids, o.solids.size(), bytes_of(o.solids));
    }
    if (o.periodic != std::array<bool, 3>{}) costs.enter(Effect::Periodic);
}

}  // namespace

GridBasePtr transmittance_grid(const FloatGrid& density, const Medium& medium, const Light& light,
                               const TransmittanceOptions& o, const Progress& progress, TransmittanceReport* report)
{
    TransmittanceReport found;
    GridBasePtr grid;
    {
        const EffectCosts::Timer timer(found.costs, Effect::Lights);
        grid = find_grid(density, medium, light, o, progress, report ? &found : nullptr);
    }
    add_fields(found.costs, *grid, o, found.work);
    if (report) *report = found;
    return grid;
}

GridBasePtr unlit_grid(const FloatGrid& density, const Light& light)
{
    const FloatGridPtr grid = FloatGrid::create(1.0f);
    grid->setName(transmittance_name(light));
    grid->setTransform(density.transform().copy());
    write_light(*grid, light);
    return grid;
}

TransmittancePlan transmittance_plan(const FloatGrid& density, const Medium& medium, const Light& light,
                                     const TransmittanceOptions& o, bool count)
{
    check(o);
    const Period period = period_of(density, o.periodic);
    const size_t channels = medium.grey() ? 1 : 3;
    const double parts = double(light.parts(o.disc_samples).size());
    const bool lattice = o.fidelity == Fidelity::Lattice && light->common_direction() && !period.any();
    // The fringe meets further blocks; with `count` these are found.
    const double occupied = double(density.tree().leafCount()) + double(density.tree().activeTileCount());
    TreeSize size = tree_size(density);
    size.leaves = occupied * std::pow(o.refine, 3);
    TransmittancePlan plan;
    if (count) {
        plan.work.add("solid_ray", double(density.activeVoxelCount()) * parts * double(o.solids.size()));
        const BrickMap map(density, 0, {}, period);
        const Wanted wanted(density, o.refine, period);
        size = tree_size(*FloatGrid::create(wanted.tree));
        plan.work.add("light_point", 512 * size.leaves * parts);
        if (lattice)
            for (const auto& part : light.parts(o.disc_samples))
                plan.work.add("lattice_product", double(lattice_products(map, *part->common_direction(),
                                                                         refined_offsets(o.refine), o.rays_per_voxel)));
        else
            plan.work.add("exact_cell", parts * double(wanted.voxels) * mean_steps(map, *light, wanted));
    }
    // Bricks of the density, the topology and the transmittance; then the depths, and after them the grid.
    const double value = 4.0 * double(channels), leaves = size.leaves, topologies = period.any() ? 3 : 2;
    plan.value_bytes = size.values(value);
    plan.grid_bytes = size.memory(value);
    plan.bytes = 1.2 * double(density.tree().leafCount()) * 4 * 729 + leaves * (2144 + 512 * value) +
                 (topologies - 1) * size.table_memory(4) + std::max(plan.grid_bytes, leaves * 2048);
    return plan;
}

GridBasePtr transmittance_grid(const std::vector<CrossedMedium>& media, size_t at, const Light& light,
                               const TransmittanceOptions& o, const GridBasePtr& own, const Progress& progress)
{
    check(o);
    const FloatGrid& density = *media.at(at).density;
    const Wanted wanted(density, o.refine, period_of(density, o.periodic));
    std::deque<BrickMap> bricks;
    std::vector<Crossed> crossed;
    size_t channels = 1;
    const auto add = [&](const CrossedMedium& medium, const std::optional<Vec3d>& shift) {
        const FloatGrid& crossed_density = *medium.density;
        require_light_that_leaves(light, index_from_world(crossed_density.transform(), crossed_density.getName()),
                                  o.periodic);
        bricks.emplace_back(crossed_density, 0.0f, BrickMap::Map(), period_of(crossed_density, o.periodic));
        crossed.push_back({bricks.back(), medium.medium.sigma_t_per_density, shift});
        if (!medium.medium.grey()) channels = 3;
    };
    add(media[at], Vec3d(0.0));
    for (size_t m = 0; m < media.size(); ++m)
        if (m != at && !media[m].density->empty()) add(media[m], shift_between(density, *media[m].density));
    const std::vector<float> transmittance = find_transmittance(crossed, light.parts(o.disc_samples), channels,
                                                                bool(own), SolidRays(o.solids), o, wanted, progress);
    if (transmittance.empty() && own) return own;
    return made_grid(density, media[at].medium, light, wanted, transmittance, channels, o);
}

}  // namespace vdbcloud
