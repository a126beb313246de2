#include "scaled_light.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/mixture.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <algorithm>
#include <array>

namespace vdbcloud::app {

namespace {

/// Sets channel c of `all`, which is made with the voxels of `one` where it is null.
void set_channel(const FloatGrid& one, int c, Vec3SGridPtr& all)
{
    if (!all) {
        all = Vec3SGrid::create(Vec3f(1.0f));
        all->setTree(std::make_shared<openvdb::Vec3STree>(one.tree(), Vec3f(1.0f), openvdb::TopologyCopy()));
        all->setTransform(one.transform().copy());
    }
    auto from = one.getConstAccessor();
    for (auto v = all->beginValueOn(); v; ++v) {
        Vec3f value = *v;
        value[c] = from.getValue(v.getCoord());
        v.setValue(value);
    }
}

}  // namespace

GridBasePtr scaled_light_grid(App& app, const FloatGrid& density, const Vec3SGrid* colour, const Medium& medium,
                              const DeltaScaling& delta, const Light& light, const TransmittanceOptions& asked)
{
    TransmittanceOptions options = asked;
    options.error_samples = 0;
    TransmittanceReport found;
    Medium scaled = medium;
    if (!colour) {
        for (int c = 0; c < 3; ++c) scaled.sigma_t_per_density[c] *= delta.extinction(medium.albedo[c]);
        const GridBasePtr grid = transmittance_grid(density, scaled, light, options, app.progress("light"), &found);
        app.add_work(found.work);
        return grid;
    }
    Vec3SGridPtr all;
    for (int c = 0; c < 3; ++c) {
        auto scaled_density = density.deepCopy();
        scaled_density->tree().voxelizeActiveTiles();
        const VoxelMean tint(*colour, density.transform());
        for (auto v = scaled_density->beginValueOn(); v; ++v) {
            const double w0 = std::clamp(medium.albedo[c] * tint(Vec3i(v.getCoord().asPointer()))[c], 0.0, 1.0);
            v.setValue(float(*v * delta.extinction(w0)));
        }
        scaled.sigma_t_per_density = Vec3d(medium.sigma_t_per_density[c]);
        const auto one = openvdb::gridPtrCast<FloatGrid>(
            transmittance_grid(*scaled_density, scaled, light, options, app.progress("light"), &found));
        app.add_work(found.work);
        set_channel(*one, c, all);
    }
    return all;
}

GridBasePtr mixed_light_grid(App& app, const std::vector<MediumPart>& parts, const std::vector<DeltaScaling>& scalings,
                             const Light& light, const TransmittanceOptions& asked)
{
    TransmittanceOptions options = asked;
    options.error_samples = 0;
    TransmittanceReport found;
    Medium unit;
    unit.sigma_t_per_density = Vec3d(1);
    std::array<FloatGridPtr, 3> of;
    for (int c = 0; c < 3; ++c) {
        int same = 0;
        while (same < c && !same_extinction(parts, scalings, c, same)) ++same;
        if (same < c) {
            of[size_t(c)] = of[size_t(same)];
            continue;
        }
        of[size_t(c)] = openvdb::gridPtrCast<FloatGrid>(transmittance_grid(
            *extinction_of(parts, scalings, c), unit, light, options, app.progress("light"), &found));
        app.add_work(found.work);
    }
    GridBasePtr grid = of[0];
    if (of[1] != of[0] || of[2] != of[0]) {
        Vec3SGridPtr all;
        for (int c = 0; c < 3; ++c) set_channel(*of[size_t(c)], c, all);
        all->insertMeta(*of[0]);
        grid = all;
    }
    grid->removeMeta(schema::sigma_t_per_density);
    set_text(*grid, schema::density_digest, sources_of(parts, nullptr).density);
    set_text(*grid, schema::mixture, mixture_text(parts, scalings));
    return grid;
}

}  // namespace vdbcloud::app
