// The value of a grid at a point of the world.
#include "vdbcloud/grid/probe.h"

#include "support/grids.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

/// A linear function of index space, active in 4^3 voxels, in voxels of 0.5 that begin at (10, 0, 0).
double linear(const Vec3d& i) { return 1 + 2 * i[0] - 3 * i[1] + 0.5 * i[2]; }

template<typename GridT, typename Value>
std::shared_ptr<GridT> with_values(const Value& value)
{
    auto grid = registered<GridT>();
    grid->setName("field");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->transform().postTranslate(Vec3d(10, 0, 0));
    auto set = grid->getAccessor();
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k) set.setValue(Coord(i, j, k), value(Vec3d(i, j, k)));
    return grid;
}

TEST(Probe, ALinearFieldIsInterpolatedExactly)
{
    const auto single = with_values<FloatGrid>([](const Vec3d& i) { return float(linear(i)); });
    const auto twice = with_values<openvdb::DoubleGrid>([](const Vec3d& i) { return linear(i); });
    const Vec3d index(1.25, 2.5, 0.75), world = 0.5 * index + Vec3d(10, 0, 0);
    for (const GridBase* grid :
         {static_cast<const GridBase*>(single.get()), static_cast<const GridBase*>(twice.get())}) {
        const ProbedValue value = value_at(*grid, world);
        ASSERT_EQ(value.components.size(), 1u);
        EXPECT_NEAR(value.components[0], linear(index), 1e-6);
        EXPECT_TRUE(value.inside);
    }
}

TEST(Probe, AVectorHasThreeComponentsAndAStaggeredOneStandsAtFaces)
{
    const auto at = [](const Vec3d& i) { return Vec3f(float(linear(i)), float(i[1]), 7); };
    const auto grid = with_values<Vec3SGrid>(at);
    const Vec3d index(1.25, 1.5, 1.75), world = 0.5 * index + Vec3d(10, 0, 0);
    const ProbedValue centred = value_at(*grid, world);
    ASSERT_EQ(centred.components.size(), 3u);
    EXPECT_NEAR(centred.components[0], linear(index), 1e-6);
    EXPECT_NEAR(centred.components[1], 1.5, 1e-6);
    EXPECT_NEAR(centred.components[2], 7, 1e-6);
    grid->setGridClass(openvdb::GRID_STAGGERED);
    const ProbedValue staggered = value_at(*grid, world);  // values stand half a voxel lower along their own axis
    EXPECT_NEAR(staggered.components[0], linear(index + Vec3d(0.5, 0, 0)), 1e-6);
    EXPECT_NEAR(staggered.components[1], 2, 1e-6);
}

TEST(Probe, OutsideTheActiveVoxelsTheBackgroundIsSaidToBeOutside)
{
    const auto grid = with_values<FloatGrid>([](const Vec3d&) { return 1.0f; });
    const ProbedValue edge = value_at(*grid, Vec3d(10 - 0.125, 0.5, 0.5));  // a quarter of a voxel before the first
    EXPECT_NEAR(edge.components[0], 0.75, 1e-6);
    EXPECT_TRUE(edge.inside);
    const ProbedValue far = value_at(*grid, Vec3d(0, 0, 0));
    EXPECT_EQ(far.components[0], 0);
    EXPECT_FALSE(far.inside);
}

TEST(Probe, RefusesAGridWithoutRealNumbers)
{
    const auto grid = registered<openvdb::BoolGrid>();
    grid->setName("mask");
    const std::string said = sentence<InputError>([&] { value_at(*grid, Vec3d(0.0)); });
    EXPECT_NE(said.find("'mask' holds bool: expected float"), std::string::npos) << said;
}

}  // namespace
}  // namespace vdbcloud::test
