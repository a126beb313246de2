// Clouds of constant cells: where their voxels are, and the optical depths that they keep.
#include "vdbcloud/voxels/cloud_table.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

using openvdb::Coord;

const CloudCells cells_z{Vec3d(50, 20, 45), 200, 2}, cells_y{Vec3d(50, 20, 45), 200, 1};

TEST(CloudTable, ASectionHasItsCellsWhereTheTableSays)
{
    const auto extinction = [](size_t column, size_t layer) { return column == 2 && layer == 1 ? 0.25 : 0.0; };
    for (const CloudCells& cells : {cells_z, cells_y}) {
        const auto grid = section_cloud(3, 4, 5, cells, extinction);
        EXPECT_EQ(grid->activeVoxelCount(), 5u) << "cells without cloud are not there";
        for (int side = 0; side < 5; ++side) {
            Coord at(2, 0, 0);
            at[3 - cells.up] = side;
            at[cells.up] = 1;
            EXPECT_EQ(grid->tree().getValue(at), 0.25f);
            const Vec3d centre = grid->indexToWorld(at);
            EXPECT_NEAR(centre[0], 125, 1e-9);
            EXPECT_NEAR(centre[3 - cells.up], 20 * side + 10, 1e-9);
            EXPECT_NEAR(centre[cells.up], 200 + 1.5 * 45, 1e-9);
        }
    }
}

TEST(CloudTable, AColumnKeepsItsOpticalDepthWhereverItsTopIs)
{
    const double tops[] = {10, 45, 100, 135.5};
    const auto grid = column_cloud(
        4, 2, cells_z, [](size_t x, size_t y) { return y == 1 ? 0.0 : 3.0 + double(x); },
        [&](size_t x, size_t) { return tops[x]; });
    for (int x = 0; x < 4; ++x) {
        double depth = 0;
        int layers = 0;
        for (int layer = 0; layer < 6; ++layer) {
            depth += 45 * double(grid->tree().getValue(Coord(x, 0, layer)));
            layers += grid->tree().isValueOn(Coord(x, 0, layer));
        }
        EXPECT_NEAR(depth, 3 + x, 1e-6);
        EXPECT_EQ(layers, int(std::ceil(tops[x] / 45)));
        EXPECT_FALSE(grid->tree().isValueOn(Coord(x, 1, 0))) << "a column without cloud";
    }
    EXPECT_NEAR(grid->tree().getValue(Coord(3, 0, 0)), 6 / 135.5, 1e-7) << "constant below the top";
}

TEST(CloudTable, RefusesWhatIsNoCloud)
{
    const auto one = [](size_t, size_t) { return 1.0; };
    for (const double bad : {-1.0, double(NAN), double(INFINITY)}) {
        const auto value = [&](size_t, size_t) { return bad; };
        EXPECT_THROW(section_cloud(1, 1, 1, cells_z, value), InputError);
        EXPECT_THROW(column_cloud(1, 1, cells_z, value, one), InputError);
        EXPECT_THROW(column_cloud(1, 1, cells_z, one, value), InputError);
    }
    const auto nothing = [](size_t, size_t) { return 0.0; };
    const auto high = [](size_t, size_t) { return 1e12; };
    EXPECT_THROW(column_cloud(1, 1, cells_z, one, nothing), InputError);
    EXPECT_THROW(column_cloud(1, 1, cells_z, one, high), InputError);
    EXPECT_THROW(section_cloud(1 << 15, 1 << 15, 1 << 4, cells_z, one), InputError);
}

}  // namespace
}  // namespace vdbcloud::test
