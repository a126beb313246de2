// grid_statistics() and file_statistics() against known values.
#include "vdbcloud/grid/statistics.h"

#include "vdbcloud/core/vdb.h"

#include "support/grids.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(GridStatistics, WeightTilesByTheirVoxelsAndExcludeNaN)
{
    const auto grid = FloatGrid::create(5.0f);  // the background must not contribute
    grid->setName("density");
    grid->setTransform(Transform::createLinearTransform(0.25));
    grid->tree().addTile(/*level=*/1, openvdb::Coord(0, 0, 0), 2.0f, true);  // 8^3 voxels
    grid->tree().setValue(openvdb::Coord(-3, 40, 7), -6.0f);
    grid->tree().setValue(openvdb::Coord(100, 0, 0), NAN);
    const auto s = grid_statistics(*grid);
    EXPECT_EQ(s.label, "density");
    EXPECT_EQ(s.value_type, "float");
    EXPECT_EQ(s.active_voxels, 514u);
    EXPECT_EQ(s.active_tiles, 1u);
    EXPECT_EQ(s.box_min, (std::array<int, 3>{-3, 0, 0}));
    EXPECT_EQ(s.box_max, (std::array<int, 3>{100, 40, 7}));
    EXPECT_EQ(s.voxel_size, Vec3d(0.25));
    EXPECT_EQ(s.min, -6);
    EXPECT_EQ(s.max, 2);
    EXPECT_DOUBLE_EQ(s.mean, (512 * 2.0 - 6) / 513);
    EXPECT_EQ(s.not_finite, 1u);
}

TEST(GridStatistics, MeasureTheLengthOfVectors)
{
    const auto grid = Vec3SGrid::create(Vec3f(0));
    grid->tree().setValue(openvdb::Coord(0), Vec3f(3, 4, 0));
    const auto s = grid_statistics(*grid);
    EXPECT_TRUE(s.has_values);
    EXPECT_EQ(s.min, 5);
    EXPECT_EQ(s.mean, 5);
}

TEST(GridStatistics, LabelEqualNamesAndOmitValuesOfOtherTypes)
{
    const auto a = FloatGrid::create(), b = FloatGrid::create();
    const auto mask = test::registered<openvdb::BoolGrid>();
    for (const auto& grid : {a, b}) grid->setName("density");
    mask->setName("mask");
    mask->tree().setValue(openvdb::Coord(1, 1, 1), true);
    const auto all = file_statistics({"x", {a, mask, b}, std::make_shared<MetaMap>()});
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].label, "density[0]");
    EXPECT_EQ(all[1].label, "mask");
    EXPECT_EQ(all[2].label, "density[1]");
    EXPECT_FALSE(all[1].has_values);
    EXPECT_EQ(all[1].active_voxels, 1u);
    EXPECT_EQ(all[0].active_voxels, 0u);
}

}  // namespace
}  // namespace vdbcloud
