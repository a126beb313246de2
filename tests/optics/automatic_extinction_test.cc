// The automatic extinction: closed forms, and invariance under the grid's transform.
#include "vdbcloud/optics/automatic_extinction.h"

#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

FloatGridPtr sphere(int radius, float value, const openvdb::math::Transform::Ptr& transform)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    for (int x = -radius; x <= radius; ++x)
        for (int y = -radius; y <= radius; ++y)
            for (int z = -radius; z <= radius; ++z)
                if (x * x + y * y + z * z <= radius * radius) accessor.setValue(Coord(x, y, z), value);
    return grid;
}

openvdb::math::Transform::Ptr scaled(double h) { return openvdb::math::Transform::createLinearTransform(h); }

TEST(TypicalDepth, SphereIsThreeHalvesRadiusTimesDensity)
{
    // Columns of 8 x 8 voxels average over the rim: within a few per cent at R = 40, and better when finer.
    const double h = 0.05;
    EXPECT_NEAR(typical_depth(*sphere(40, 2.0f, scaled(h))) / (2 * 1.5 * 40 * h), 1, 0.03);
}

TEST(TypicalDepth, BoxIsTheMeanEdgeForTilesAndVoxels)
{
    for (const bool tiles : {true, false}) {
        auto grid = openvdb::FloatGrid::create(0.0f);
        grid->setTransform(scaled(0.5));
        grid->sparseFill(CoordBBox(Coord(0, 0, 0), Coord(255, 127, 15)), 3.0f);
        if (!tiles) grid->tree().voxelizeActiveTiles();
        EXPECT_NEAR(typical_depth(*grid), 3.0 * 0.5 * (256 + 128 + 16) / 3.0, 1e-9) << tiles;
    }
}

TEST(TypicalDepth, IgnoresEmptySurroundings)
{
    auto grid = sphere(16, 1.0f, scaled(1));
    const double alone = typical_depth(*grid);
    grid->sparseFill(CoordBBox(Coord(100, 100, 100), Coord(500, 500, 500)), 0.0f);
    EXPECT_DOUBLE_EQ(typical_depth(*grid), alone);
}

TEST(AutomaticExtinction, TypicalOpticalDepthEqualsTheTarget)
{
    const auto grid = sphere(20, 0.3f, scaled(2));
    EXPECT_NEAR(automatic_extinction(*grid, 7) * typical_depth(*grid), 7, 1e-12);
}

TEST(AutomaticExtinction, FollowsGridScaleAndIgnoresRotationAndTranslation)
{
    auto moved = scaled(3);
    moved->postRotate(0.7, openvdb::math::Y_AXIS);
    moved->postRotate(0.4, openvdb::math::X_AXIS);
    moved->postTranslate(Vec3d(100, -20, 5));
    const double rest = automatic_extinction(*sphere(12, 0.5f, scaled(1)));
    EXPECT_NEAR(automatic_extinction(*sphere(12, 0.5f, moved)) * 3 / rest, 1, 1e-12);
}

TEST(AutomaticExtinction, EmptyDensityGivesOne)
{
    EXPECT_EQ(automatic_extinction(*openvdb::FloatGrid::create(0.0f)), 1);
    EXPECT_EQ(typical_depth(*openvdb::FloatGrid::create(0.0f)), 0);
}

}  // namespace
}  // namespace vdbcloud
