// Values of a vector grid at the voxels of another: exact for fields that the rule integrates exactly.
#include "vdbcloud/voxels/voxel_mean.h"

#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::math::Transform;

/// value(world position) on [-reach, reach]^3 voxels.
template<typename F>
Vec3SGridPtr field(const Transform::Ptr& transform, int reach, const F& value)
{
    const auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setTransform(transform);
    auto at = grid->getAccessor();
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k)
                at.setValue(Coord(i, j, k), Vec3f(value(transform->indexToWorld(Coord(i, j, k)))));
    return grid;
}

Vec3d linear(const Vec3d& p) { return {1 + 0.1 * p[0], 2 - 0.2 * p[1], 3 + 0.05 * p[0] + 0.3 * p[2]}; }

TEST(VoxelMean, IsTheVoxelsOwnValueWhereTransformsAgree)
{
    const auto transform = Transform::createLinearTransform(0.3);
    const auto grid = field(transform, 4, [](const Vec3d& p) { return Vec3d(std::sin(99 * p[0]), p[1], p[2]); });
    const VoxelMean mean(*grid, *transform->copy());
    for (const Coord& p : {Coord(0, 0, 0), Coord(-4, 3, 2), Coord(9, 9, 9)})
        EXPECT_EQ(mean(Vec3i(p.asPointer())), grid->tree().getValue(p));
}

/// Trilinear samples and means over symmetric points are exact for a linear field: only float rounds, 6e-8 of values
/// below 8, summed over the mean.
TEST(VoxelMean, IsExactForALinearFieldOnVoxelsOfAnySizeAndDirection)
{
    const auto voxels = Transform::createLinearTransform(1.0);
    voxels->preScale(Vec3d(0.5, 1.0, 1.5));
    voxels->postTranslate(Vec3d(0.2, -0.1, 0.3));
    for (const double size : {0.21, 0.8, 2.5}) {
        const auto own = Transform::createLinearTransform(size);
        own->preRotate(0.5, openvdb::math::Y_AXIS);
        const auto grid = field(own, int(14 / size), linear);
        const VoxelMean mean(*grid, *voxels);
        for (const Coord& p : {Coord(0, 0, 0), Coord(2, -3, 1), Coord(-4, 2, -2)}) {
            const Vec3d expected = linear(voxels->indexToWorld(p)), found(mean(Vec3i(p.asPointer())));
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 4e-6) << size << " " << p;
        }
    }
}

/// The sum over voxels times their volume is that of a finer grid: four voxels along an edge, one of which shines.
TEST(VoxelMean, KeepsTheTotalOfASourceSmallerThanAVoxel)
{
    const auto fine = Transform::createLinearTransform(0.25), voxels = Transform::createLinearTransform(1.0);
    const auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setTransform(fine);
    grid->tree().setValue(Coord(5, -2, 7), Vec3f(3, 2, 1));
    const VoxelMean mean(*grid, *voxels);
    Vec3d total(0, 0, 0);
    for (int i = -4; i <= 4; ++i)
        for (int j = -4; j <= 4; ++j)
            for (int k = -4; k <= 4; ++k) total += Vec3d(mean(Vec3i(i, j, k)));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(total[c], (3 - c) / 64.0, 1e-7);
}

}  // namespace
}  // namespace vdbcloud
