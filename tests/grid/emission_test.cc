// Where a grid of emission shines, beside a density.
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/emission.h"

#include <gtest/gtest.h>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

FloatGridPtr density_over(const CoordBBox& box, double voxel = 1)
{
    auto grid = FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    grid->fill(box, 2.0f);
    return grid;
}

Vec3SGridPtr emission_over(const CoordBBox& box, const Vec3f& value, double voxel = 1)
{
    auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(voxel));
    grid->fill(box, value);
    return grid;
}

TEST(Emission, ShinesWhereAnActiveValueIsNotZero)
{
    const CoordBBox box(Coord(0), Coord(3));
    EXPECT_FALSE(emits(nullptr));
    EXPECT_FALSE(emits(emission_over(box, Vec3f(0.0f)).get()));
    EXPECT_TRUE(emits(emission_over(box, Vec3f(0, 0, 1e-6f)).get()));
}

TEST(Emission, OutsideIsAVoxelWithoutDensity)
{
    const auto density = density_over({Coord(0), Coord(7)});
    const Vec3f blue(0, 0, 1);
    EXPECT_FALSE(emits_outside(*emission_over({Coord(0), Coord(7)}, blue), *density));
    EXPECT_TRUE(emits_outside(*emission_over({Coord(0), Coord(7, 7, 8)}, blue), *density));
    EXPECT_FALSE(emits_outside(*emission_over({Coord(0), Coord(7, 7, 8)}, Vec3f(0.0f)), *density)) << "it is dark";
}

TEST(Emission, OutsideIsATileThatReachesBeyondTheDensity)
{
    const auto emission = emission_over({Coord(0), Coord(127)}, Vec3f(1, 0, 0));
    ASSERT_EQ(emission->tree().leafCount(), 0u);
    EXPECT_FALSE(emits_outside(*emission, *density_over({Coord(0), Coord(127)})));
    EXPECT_TRUE(emits_outside(*emission, *density_over({Coord(0), Coord(126)})));
}

TEST(Emission, OutsideIsToldInWorldSpace)
{
    // Emission of half the voxel size: its voxels 0..15 have their centres at 0..7.5.
    const auto emission = emission_over({Coord(0), Coord(14)}, Vec3f(1, 1, 1), 0.5);
    EXPECT_FALSE(emits_outside(*emission, *density_over({Coord(0), Coord(7)})));
    EXPECT_TRUE(emits_outside(*emission, *density_over({Coord(0), Coord(6)})));
}

}  // namespace
}  // namespace vdbcloud::test
