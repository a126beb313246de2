// compare_grids() and compare_files() against differences in closed form.
#include "vdbcloud/grid/compare.h"
#include "vdbcloud/grid/metadata.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include "support/grids.h"
#include "support/run.h"

#include <openvdb/io/Stream.h>

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;
using openvdb::CoordBBox;

TEST(Compare, EqualGridsHaveZeroDifference)
{
    const auto d = compare_grids(*ball("density"), *ball("density"));
    EXPECT_TRUE(d.comparable);
    EXPECT_EQ(d.voxels, ball("density")->activeVoxelCount());
    EXPECT_EQ(d.max, 0);
    EXPECT_EQ(d.rms, 0);
    EXPECT_EQ(d.relative, 0);
    EXPECT_EQ(d.only_a + d.only_b, 0u);
    EXPECT_TRUE(d.metadata.empty());
}

TEST(Compare, MatchesClosedFormOfThreeChangedVoxels)
{
    const auto a = FloatGrid::create(0.0f), b = FloatGrid::create(0.0f);
    // Both grids have two leaves with 512 active voxels each. Each grid also has one voxel that the other grid lacks.
    for (const auto& grid : {a, b}) grid->tree().fill(CoordBBox(Coord(0), Coord(7, 7, 15)), 2.0f);
    b->tree().setValue(Coord(3, 4, 5), 5.0f);
    a->tree().setValue(Coord(-200, 0, 0), 0.5f);
    b->tree().setValue(Coord(5000, 1, 1), 0.25f);
    const auto d = compare_grids(*a, *b);
    EXPECT_EQ(d.voxels, 1026u);
    EXPECT_EQ(d.only_a, 1u);
    EXPECT_EQ(d.only_b, 1u);
    EXPECT_EQ(d.max, 3);
    EXPECT_EQ(d.where, (std::array<int, 3>{3, 4, 5}));
    const double sum = 3 * 3 + 0.5 * 0.5 + 0.25 * 0.25;
    EXPECT_DOUBLE_EQ(d.rms, std::sqrt(sum / 1026));
    EXPECT_DOUBLE_EQ(d.relative, std::sqrt(sum / (1024 * 4 + 0.25)));
}

TEST(Compare, TileEqualsTheVoxelsThatTheTileCovers)
{
    const auto tiles = FloatGrid::create(0.0f), voxels = FloatGrid::create(0.0f);
    tiles->tree().addTile(2, Coord(0), 1.5f, true);  // 128^3
    tiles->tree().addTile(1, Coord(256, 0, 0), 1.0f, true);
    voxels->tree().fill(CoordBBox(Coord(0), Coord(127)), 1.5f);
    voxels->tree().fill(CoordBBox(Coord(256, 0, 0), Coord(263, 7, 7)), 1.0f);
    voxels->tree().voxelizeActiveTiles();
    ASSERT_EQ(voxels->tree().activeTileCount(), 0u);
    auto d = compare_grids(*tiles, *voxels);
    EXPECT_EQ(d.voxels, 128u * 128 * 128 + 512);
    EXPECT_EQ(d.max, 0);
    EXPECT_EQ(d.only_a + d.only_b, 0u);
    voxels->tree().setValueOff(Coord(100, 100, 100));
    voxels->tree().setValue(Coord(1, 2, 3), 1.0f);
    for (const bool swapped : {false, true}) {
        d = swapped ? compare_grids(*voxels, *tiles) : compare_grids(*tiles, *voxels);
        EXPECT_EQ(swapped ? d.only_b : d.only_a, 1u);
        EXPECT_EQ(swapped ? d.only_a : d.only_b, 0u);
        EXPECT_EQ(d.max, 0.5);
    }
    // A tile of the root node: its 4096^3 voxels are compared at once.
    const auto huge = FloatGrid::create(0.0f), same = FloatGrid::create(0.0f);
    for (const auto& grid : {huge, same}) grid->tree().addTile(3, Coord(0), 1.0f, true);
    EXPECT_EQ(compare_grids(*huge, *same).voxels, uint64_t(1) << 36);
}

TEST(Compare, IncludesBackgroundAndNonFiniteValues)
{
    EXPECT_EQ(compare_grids(*FloatGrid::create(1.0f), *FloatGrid::create(0.25f)).max, 0.75);
    const auto a = FloatGrid::create(0.0f), b = FloatGrid::create(0.0f);
    a->tree().setValue(Coord(1), NAN);
    b->tree().setValue(Coord(1), NAN);
    EXPECT_EQ(compare_grids(*a, *b).max, 0);
    b->tree().setValue(Coord(1), 1.0f);
    EXPECT_EQ(compare_grids(*a, *b).max, INFINITY);
    EXPECT_FALSE(beyond(compare_files(file_of({a}), file_of({b})), {1e30, INFINITY, INFINITY, 1}).empty());
}

template<typename GridT>
double changed(const typename GridT::ValueType& a, const typename GridT::ValueType& b)
{
    const auto p = registered<GridT>(), q = registered<GridT>();
    p->tree().setValue(Coord(1, 2, 3), a);
    q->tree().setValue(Coord(1, 2, 3), b);
    return compare_grids(*p, *q).max;
}

TEST(Compare, SubtractsEachSupportedValueType)
{
    EXPECT_EQ(changed<openvdb::DoubleGrid>(1, 1 + 1e-12), 1 + 1e-12 - 1);
    EXPECT_EQ(changed<Vec3SGrid>(Vec3f(0), Vec3f(3, 4, 0)), 5);
    EXPECT_EQ(changed<openvdb::Vec3DGrid>(Vec3d(0), Vec3d(0, 3, 4)), 5);
    EXPECT_EQ(changed<openvdb::BoolGrid>(true, false), 1);
    EXPECT_EQ(changed<openvdb::Int32Grid>(-3, 4), 7);
    EXPECT_EQ(changed<openvdb::Int64Grid>(-3, 4), 7);
    const auto a = registered<openvdb::MaskGrid>(), b = registered<openvdb::MaskGrid>();
    a->tree().setValueOn(Coord(5));
    EXPECT_EQ(compare_grids(*a, *b).only_a, 1u);
    EXPECT_FALSE(compare_grids(*a, *FloatGrid::create()).comparable);
}

TEST(Compare, ReportsTransformAndMetadataButNotVolatileKeys)
{
    const auto a = ball("density"), b = ball("density");
    b->setTransform(Transform::createLinearTransform(1 + 1e-6));
    set_number(*a, "vdbcloud:g", 0.5);
    set_number(*b, "vdbcloud:g", 0.75);
    a->insertMeta("file_voxel_count", openvdb::Int64Metadata(3));
    b->setSaveFloatAsHalf(true);
    const auto d = compare_grids(*a, *b);
    EXPECT_NEAR(d.transform, 1e-6, 1e-9);
    EXPECT_EQ(d.metadata, std::vector<std::string>{"vdbcloud:g"});

    auto first = file_of({ball("density")}), second = file_of({ball("density")});
    set_text(*first.metadata, "history", "one");
    set_text(*second.metadata, "up_axis", "Z");
    EXPECT_EQ(compare_files(first, second).metadata, std::vector<std::string>{"up_axis"});
}

TEST(Compare, MatchesGridsByLabel)
{
    const auto a = file_of({ball("density"), ball("density", 5), ball("heat")});
    const auto b = file_of({ball("density"), ball("density", 4), ball("flame")});
    const auto d = compare_files(a, b);
    ASSERT_EQ(d.grids.size(), 2u);
    EXPECT_EQ(d.grids[0].max, 0);
    EXPECT_EQ(d.grids[1].label, "density[1]");
    EXPECT_GT(d.grids[1].max, 0);
    EXPECT_EQ(d.only_a, std::vector<std::string>{"heat"});
    EXPECT_EQ(d.only_b, std::vector<std::string>{"flame"});
    EXPECT_EQ(compare_files(a, b, {"density[0]"}).grids.size(), 1u);
    EXPECT_TRUE(beyond(compare_files(a, b, {"density[0]"}), {}).empty());
    EXPECT_EQ(beyond(compare_files(a, b, {"heat"}), {}).size(), 1u);
    EXPECT_THROW(compare_files(a, b, {"nothing"}), InputError);
}

TEST(Compare, AppliesEachToleranceSeparately)
{
    const auto a = ball("density"), b = ball("density");
    b->tree().setValue(Coord(0), a->tree().getValue(Coord(0)) + 0.125f);
    b->tree().setValue(Coord(50, 0, 0), 0.0f);
    const auto d = compare_files(file_of({a}), file_of({b}));
    const double all = INFINITY, found_rms = d.grids[0].rms, found_relative = d.grids[0].relative;
    const auto count = [&](const Tolerances& t) { return beyond(d, t).size(); };
    EXPECT_EQ(count({}), 4u);
    EXPECT_EQ(count({0.125, found_rms, found_relative, 0.01}), 0u);
    EXPECT_EQ(count({0.12, all, all, 1}), 1u);
    EXPECT_EQ(count({all, found_rms * 0.99, all, 1}), 1u);
    EXPECT_EQ(count({all, all, found_relative * 0.99, 1}), 1u);
    EXPECT_EQ(count({all, all, all, 1e-5}), 1u);
}

}  // namespace
}  // namespace vdbcloud
