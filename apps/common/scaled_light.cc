#include "scaled_light.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <algorithm>

namespace vdbcloud::app {

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
        if (!all) {
            all = Vec3SGrid::create(Vec3f(1.0f));
            all->setTree(std::make_shared<openvdb::Vec3STree>(one->tree(), Vec3f(1.0f), openvdb::TopologyCopy()));
            all->setTransform(one->transform().copy());
        }
        auto from = one->getConstAccessor();
        for (auto v = all->beginValueOn(); v; ++v) {
            Vec3f value = *v;
            value[c] = from.getValue(v.getCoord());
            v.setValue(value);
        }
    }
    return all;
}

}  // namespace vdbcloud::app
