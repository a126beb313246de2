#include "vdbcloud/scatter/beam_medium.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/optical_depth.h"

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
        if (index.blocks().active(slot)) v.setValue(float(*v * p1.scaling(slot).extinction));
    }
    return BrickMap(*scaled);
}

}  // namespace

double beam_extinction(const P1Operator& p1)
{
    return p1.medium().sigma_t_per_density * (p1.uniform_albedo() ? p1.scaling(0).extinction : 1);
}

BeamMedium::BeamMedium(const VoxelIndex& index, const FloatGrid& grid, const std::vector<float>& density,
                       const P1Operator& p1)
    : index_(index), density_(density), extinction_(beam_extinction(p1))
{
    if (index.blocks().period() == Vec3i(0, 0, 0))
        bricks_.emplace(p1.uniform_albedo() ? BrickMap(grid) : scaled_bricks(index, grid, p1));
    if (p1.uniform_albedo()) return;
    scaled_ = density;
    for (size_t slot = 0; slot < scaled_.size(); ++slot)
        if (index.blocks().active(slot)) scaled_[slot] *= float(p1.scaling(slot).extinction);
}

BeamDepths BeamMedium::depths(const std::vector<ExposedVoxel>& exposed, const Light& light, int rays_per_voxel,
                              std::vector<float>* centres, const Progress& progress,
                              std::atomic<size_t>* products) const
{
    if (bricks_) return beam_depths(index_, exposed, *bricks_, light, rays_per_voxel, centres, progress, products);
    if (centres) *centres = periodic_centre_depths(index_, values(), light);
    return periodic_beam_depths(index_, exposed, values(), light);
}

LineDepths BeamMedium::lines(const Light& light) const
{
    return bricks_ ? line_depths(index_, values(), light) : periodic_line_depths(index_, values(), light);
}

double BeamMedium::depth(const Vec3d& voxel, const Light& light) const
{
    return bricks_ ? depth_to_light(*bricks_, *light, index_.world(voxel))
                   : periodic_depth(index_, values(), light, voxel);
}

}  // namespace vdbcloud
