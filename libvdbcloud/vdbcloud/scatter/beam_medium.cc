#include "vdbcloud/scatter/beam_medium.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/optical_depth.h"

#include <tbb/parallel_for.h>

#include <limits>

namespace vdbcloud {

namespace {

/// The density times sigma_t' / sigma_t.
BrickMap scaled_bricks(const VoxelIndex& index, const FloatGrid& grid, const P1Operator& p1)
{
    auto scaled = grid.deepCopy();
    scaled->tree().voxelizeActiveTiles();
    for (auto v = scaled->beginValueOn(); v; ++v) {
        const openvdb::Coord p = v.getCoord();
        const size_t slot = index.blocks().slot(Vec3i(p.x(), p.y(), p.z()) - index.origin());
        if (index.blocks().active(slot)) v.setValue(float(p1.density()[slot] * p1.scaling(slot).extinction));
    }
    return BrickMap(*scaled);
}

}  // namespace

double beam_extinction(const P1Operator& p1)
{
    return p1.medium().sigma_t_per_density * (p1.uniform() ? p1.scaling(0).extinction : 1);
}

BeamMedium::BeamMedium(const VoxelIndex& index, const FloatGrid& grid, const P1Operator& p1, const SolidRays* solids)
    : index_(index), density_(p1.density()), extinction_(beam_extinction(p1)), solids_(solids)
{
    if (index.blocks().period() == Vec3i(0, 0, 0))
        bricks_.emplace(p1.uniform() ? BrickMap(grid) : scaled_bricks(index, grid, p1));
    if (p1.uniform()) return;
    scaled_ = density_;
    for (size_t slot = 0; slot < scaled_.size(); ++slot)
        if (index.blocks().active(slot)) scaled_[slot] *= float(p1.scaling(slot).extinction);
}

BeamDepths BeamMedium::depths(const std::vector<ExposedVoxel>& exposed, const Light& light, int rays_per_voxel,
                              std::vector<float>* centres, const Progress& progress,
                              std::atomic<size_t>* products) const
{
    if (!bricks_) {
        if (centres) *centres = periodic_centre_depths(index_, values(), light);
        return periodic_beam_depths(index_, exposed, values(), light);
    }
    BeamDepths found = beam_depths(index_, exposed, *bricks_, light, rays_per_voxel, centres, progress, products);
    if (!solids_) return found;
    const Blocks& blocks = index_.blocks();
    found.seen.assign(blocks.slots(), 0);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
            const Vec3i at = blocks.voxel(slot);
            found.seen[slot] = blocks.active(slot) && !hidden(index_.world(Vec3d(at[0], at[1], at[2])), light);
        }
    });
    return found;
}

bool BeamMedium::hidden(const Vec3d& x, const Light& light) const
{
    const Sight sight = light->towards(x);
    return solids_->blocked({x, sight.direction}, sight.distance);
}

LineDepths BeamMedium::lines(const Light& light) const
{
    return bricks_ ? line_depths(index_, values(), light) : periodic_line_depths(index_, values(), light);
}

double BeamMedium::depth(const Vec3d& voxel, const Light& light) const
{
    return bricks_ ? depth_from(index_.world(voxel), light) : periodic_depth(index_, values(), light, voxel);
}

double BeamMedium::depth_from(const Vec3d& x, const Light& light) const
{
    if (solids_ && hidden(x, light)) return std::numeric_limits<double>::infinity();
    return depth_to_light(*bricks_, *light, x);
}

}  // namespace vdbcloud
