// Arrays over voxels: blocks, bricks, the voxel index and the fringe, against closed forms.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/blocks.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/extend.h"
#include "vdbcloud/voxels/voxel_index.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;

FloatGridPtr box_of(const Coord& low, const Coord& high, float value)
{
    const auto grid = FloatGrid::create(0.0f);
    for (auto p = openvdb::CoordBBox(low, high).begin(); p; ++p) grid->tree().setValueOn(*p, value);
    return grid;
}

TEST(Fringe, EqualsTheMeanOfActiveNeighbours)
{
    const auto grid = FloatGrid::create(0.0f);
    grid->setName("name");
    grid->tree().setValueOn(Coord(0, 0, 0), 1);
    grid->tree().setValueOn(Coord(2, 0, 0), 4);
    const auto wide = with_fringe(*grid);
    EXPECT_EQ(wide->activeVoxelCount(), 27u + 27 - 9);
    EXPECT_EQ(wide->getName(), "name");
    EXPECT_EQ(wide->tree().getValue(Coord(0, 0, 0)), 1);
    EXPECT_EQ(wide->tree().getValue(Coord(1, 0, 0)), 2.5f);
    EXPECT_EQ(wide->tree().getValue(Coord(1, 1, -1)), 2.5f);
    EXPECT_EQ(wide->tree().getValue(Coord(-1, -1, 1)), 1);
    EXPECT_EQ(wide->tree().getValue(Coord(3, 1, 1)), 4);
    EXPECT_FALSE(wide->tree().isValueOn(Coord(4, 0, 0)));
    EXPECT_EQ(grid->activeVoxelCount(), 2u) << "the grid itself is left";
}

TEST(Fringe, KeepsAConstantExactlyAndVoxelisesTiles)
{
    const auto grid = box_of(Coord(-3, 1, 2), Coord(4, 6, 9), 0.1f);
    grid->tree().setValueOff(Coord(0, 3, 4));
    grid->tree().addTile(1, Coord(64, 0, 0), 0.1f, true);
    const auto vectors = Vec3SGrid::create(Vec3f(0.0f));
    for (auto v = grid->cbeginValueOn(); v; ++v)
        if (v.isVoxelValue()) vectors->tree().setValueOn(v.getCoord(), Vec3f(0.1f, 0.7f, -0.3f));
    const auto wide = with_fringe(*grid);
    EXPECT_EQ(wide->activeVoxelCount(), 10u * 8 * 10 + 10 * 10 * 10);
    for (auto v = wide->cbeginValueOn(); v; ++v) ASSERT_EQ(*v, 0.1f) << v.getCoord();
    const auto wide_vectors = with_fringe(*vectors);
    for (auto v = wide_vectors->cbeginValueOn(); v; ++v) ASSERT_EQ(*v, Vec3f(0.1f, 0.7f, -0.3f)) << v.getCoord();
}

TEST(Blocks, NumberVoxelsAndFindNeighbours)
{
    const Blocks blocks = box_blocks(Vec3i(20, 9, 8));
    EXPECT_EQ(blocks.count(), 3u * 2);
    EXPECT_EQ(blocks.active_count(), 20u * 9 * 8);
    EXPECT_EQ(blocks.slots(), 7u * 512);
    for (const Vec3i& p : {Vec3i(0, 0, 0), Vec3i(7, 7, 7), Vec3i(8, 7, 3), Vec3i(19, 8, 5)}) {
        const size_t slot = blocks.slot(p);
        ASSERT_TRUE(blocks.active(slot));
        EXPECT_EQ(blocks.voxel(slot), p);
        for (int face = 0; face < 6; ++face) {
            Vec3i q = p;
            q[face / 2] += face % 2 ? 1 : -1;
            const size_t beside = blocks.neighbour(slot, face);
            const bool inside = q[0] >= 0 && q[1] >= 0 && q[2] >= 0 && q[0] < 20 && q[1] < 9 && q[2] < 8;
            EXPECT_EQ(blocks.active(beside), inside) << p << " face " << face;
            if (inside) {
                EXPECT_EQ(blocks.voxel(beside), q);
            }
        }
    }
    EXPECT_FALSE(blocks.active(blocks.slot(Vec3i(-1, 0, 0))));
    EXPECT_FALSE(blocks.active(blocks.slot(Vec3i(20, 0, 0))));
}

TEST(Blocks, WrapOnlyOnPeriodicAxes)
{
    const Blocks blocks = box_blocks(Vec3i(24, 8, 8), {true, false, false});
    EXPECT_EQ(blocks.voxel(blocks.neighbour(blocks.slot(Vec3i(0, 3, 4)), Blocks::XMinus)), Vec3i(23, 3, 4));
    EXPECT_EQ(blocks.voxel(blocks.neighbour(blocks.slot(Vec3i(23, 3, 4)), Blocks::XPlus)), Vec3i(0, 3, 4));
    EXPECT_EQ(blocks.slot(Vec3i(-1, 0, 0)), blocks.slot(Vec3i(23, 0, 0)));
    EXPECT_FALSE(blocks.active(blocks.neighbour(blocks.slot(Vec3i(0, 7, 4)), Blocks::YPlus)));
    EXPECT_THROW(box_blocks(Vec3i(20, 8, 8), {true, false, false}), InputError);
}

TEST(BrickMap, InterpolatesALinearFieldExactly)
{
    const auto f = [](const Vec3d& p) { return 3 + p[0] / 8 - p[1] / 4 + p[2] / 2; };  // exact in floats
    const auto grid = FloatGrid::create(0.0f);
    for (auto p = openvdb::CoordBBox(Coord(-10, -3, 5), Coord(9, 12, 20)).begin(); p; ++p)
        grid->tree().setValueOn(*p, float(f((*p).asVec3d())));
    const BrickMap map(*grid, -1);
    for (const Vec3d& p : {Vec3d(-9.75, -2.5, 5.25), Vec3d(-0.5, 7.5, 7.75), Vec3d(0, 0, 8), Vec3d(8.5, 11.5, 19.5)})
        EXPECT_DOUBLE_EQ(map.sample(p), f(p)) << p;
    EXPECT_EQ(map.sample(Vec3d(30, 0, 8)), -1);
    EXPECT_EQ(map.sample(Vec3d(NAN, 0, 8)), -1);
    // Half a voxel beyond the last centre: the mean of the last voxel's value and the outside value.
    EXPECT_DOUBLE_EQ(map.sample(Vec3d(9.5, 0, 8)), (f(Vec3d(9, 0, 8)) - 1) / 2);
    EXPECT_DOUBLE_EQ(map.sample(Vec3d(-10.5, 0, 8)), (f(Vec3d(-10, 0, 8)) - 1) / 2);
}

TEST(BrickMap, MapsVoxelsAndTilesAndInterpolatesEachChannel)
{
    const auto grid = box_of(Coord(0), Coord(3), 2);
    grid->tree().addTile(1, Coord(16, 0, 0), 4, true);
    const BrickMap squares(*grid, 1, [](float v) { return v * v; });
    EXPECT_EQ(squares.sample(Vec3d(1.5)), 4);
    EXPECT_EQ(squares.sample(Vec3d(20.5, 3, 3)), 16);
    EXPECT_EQ(squares.sample(Vec3d(15.5, 3, 3)), (16.0 + 1) / 2);
    const auto vectors = Vec3SGrid::create(Vec3f(0.0f));
    for (int x = 0; x < 2; ++x)
        for (int y = 0; y < 2; ++y)
            for (int z = 0; z < 2; ++z) vectors->tree().setValueOn(Coord(x, y, z), Vec3f(float(x), float(y), float(z)));
    EXPECT_EQ(BrickMap(*vectors).sample3(Vec3d(0.25, 0.5, 0.75)), Vec3d(0.25, 0.5, 0.75));
    EXPECT_EQ(squares.sample3(Vec3d(1.5)), Vec3d(4.0));
}

TEST(VoxelIndex, IndexesPositiveVoxelsAndKeepsTheirGeometry)
{
    const auto grid = box_of(Coord(-4, 3, 5), Coord(6, 8, 9), 1);
    grid->tree().setValueOn(Coord(0, 5, 6), 0);
    grid->tree().setValueOn(Coord(1, 5, 6), -1);
    grid->tree().addTile(1, Coord(40, 0, 0), 2, true);
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m.preRotate(openvdb::math::X_AXIS, 0.3);
    m.preScale(Vec3d(0.5, 2, 3));
    m.setTranslation(Vec3d(10, 20, 30));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    const VoxelIndex index(*grid);
    EXPECT_EQ(index.blocks().active_count(), 11u * 6 * 5 - 2 + 512);
    for (int a = 0; a < 3; ++a) {
        Vec3d unit(0, 0, 0);
        unit[a] = 1;
        const Vec3d edge = grid->indexToWorld(unit) - grid->indexToWorld(Vec3d(0.0));
        EXPECT_NEAR(index.spacing()[a], edge.length(), 1e-12);
        EXPECT_NEAR((index.axis(a) - edge.unit()).length(), 0, 1e-12);
    }
    EXPECT_NEAR((index.world(Vec3d(1, 2, 3)) - grid->indexToWorld(Vec3d(1, 2, 3))).length(), 0, 1e-12);
    const auto values = index.gather(*grid);
    const auto back = index.to_grid(values.data(), "back");
    EXPECT_EQ(back->getName(), "back");
    EXPECT_EQ(back->transform(), grid->transform());
    EXPECT_EQ(back->tree().getValue(Coord(-4, 3, 5)), 1);
    EXPECT_EQ(back->tree().getValue(Coord(44, 4, 4)), 2);
    EXPECT_EQ(back->tree().getValue(Coord(-5, 2, 4)), 1) << "the fringe";
    EXPECT_FALSE(back->tree().isValueOn(Coord(-6, 3, 5)));
    const auto scaled = index.to_grid({values.data(), values.data(), values.data()}, "v", Vec3d(1, 2, -3));
    EXPECT_EQ(scaled->tree().getValue(Coord(44, 4, 4)), Vec3f(2, 4, -6));
    EXPECT_EQ(index.gather(*scaled, 2)[index.blocks().slot(Vec3i(44, 4, 4))], -6);
}

TEST(VoxelIndex, RefusesShearAndPeriodicExtentsNotMultipleOf8)
{
    const auto grid = box_of(Coord(0), Coord(9, 7, 7), 1);
    EXPECT_THROW(VoxelIndex(*grid, {{true, false, false}}), InputError);
    const VoxelIndex repeated(*grid, {{false, true, false}});
    EXPECT_EQ(repeated.blocks().period(), Vec3i(0, 1, 0));
    const auto shifted = box_of(Coord(3, 5, 0), Coord(10, 7, 7), 1);
    EXPECT_EQ(VoxelIndex(*shifted, {{true, false, false}}).origin(), Vec3i(3, 0, 0));
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m(1, 0) = 0.01;
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    EXPECT_THROW(VoxelIndex{*grid}, InputError);
}

}  // namespace
}  // namespace vdbcloud
