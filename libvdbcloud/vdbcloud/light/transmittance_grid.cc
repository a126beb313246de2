#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/grid/tree_size.h"
#include "vdbcloud/light/lit_points.h"
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

/// Steps of a ray from a wanted point to a light, the mean of some hundred points.
double mean_steps(const BrickMap& density, const LightModel& light, const WantedPoints& wanted)
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
GridBasePtr made_grid(const FloatGrid& density, const Medium& medium, const Light& light, const WantedPoints& wanted,
                      const std::vector<float>& transmittance, size_t channels, const TransmittanceOptions& o)
{
    const GridBasePtr grid = make_grid(wanted.grid->treePtr(), transmittance, channels);
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
    const WantedPoints wanted(density, o.refine, period);
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
            compare_with_rays(*bricks, medium, parts, solids, o, wanted, transmittance, channels, *report);
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
        const WantedPoints wanted(density, o.refine, period);
        size = tree_size(*wanted.grid);
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
    const WantedPoints wanted(density, o.refine, period_of(density, o.periodic));
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
