#include "vdbcloud/voxels/coarser.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <algorithm>
#include <optional>

namespace vdbcloud {

namespace {

template<typename GridT>
typename GridT::Ptr empty_on(const FloatGrid& density, const std::string& name)
{
    auto grid = GridT::create();
    grid->setTransform(density.transform().copy());
    grid->setName(name);
    return grid;
}

/// Adds a grid of vectors, read at the voxels of `from`, to the voxels of a coarser one.
class VectorSums {
public:
    VectorSums(const Vec3SGrid& of, const FloatGrid& from, const FloatGrid& to)
        : grid(empty_on<Vec3SGrid>(to, of.getName())), read_(of, from.transform()), write_(grid->getAccessor())
    {
    }
    void add(const openvdb::Coord& from, const openvdb::Coord& to, float weight)
    {
        write_.setValueOn(to, write_.getValue(to) + weight * read_(Vec3i(from.x(), from.y(), from.z())));
    }
    Vec3SGridPtr grid;

private:
    VoxelMean read_;
    Vec3SGrid::Accessor write_;
};

}  // namespace

CoarserMedium coarser(const FloatGrid& density, const Vec3SGrid* tint, const Vec3SGrid* emission)
{
    const openvdb::Coord first = density.evalActiveVoxelBoundingBox().min();
    CoarserMedium to;
    to.density = empty_on<FloatGrid>(density, density.getName());
    to.density->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto transform = density.transform().copy();
    transform->preTranslate(first.asVec3d() + Vec3d(0.5));
    transform->preScale(2.0);
    to.density->setTransform(transform);
    std::optional<VectorSums> tints, emissions;
    if (tint) tints.emplace(*tint, density, *to.density);
    if (emission) emissions.emplace(*emission, density, *to.density);
    auto sum = to.density->getAccessor();
    const auto add = [&](const openvdb::Coord& from, float value) {
        if (!(value / 8 > 0)) return;  // nothing, or below what a float holds
        const openvdb::Coord at = (from - first) >> 1;
        sum.setValueOn(at, sum.getValue(at) + value / 8);
        if (tints) tints->add(from, at, value / 8);
        if (emissions) emissions->add(from, at, 0.125f);
    };
    for (auto v = density.cbeginValueOn(); v; ++v) {
        openvdb::CoordBBox box;
        v.getBoundingBox(box);
        for (auto p = box.begin(); p; ++p) add(*p, *v);
    }
    if (tints) {
        for (auto v = tints->grid->beginValueOn(); v; ++v) v.setValue(*v / sum.getValue(v.getCoord()));
        to.tint = tints->grid;
    }
    if (emissions) to.emission = emissions->grid;
    return to;
}

}  // namespace vdbcloud
