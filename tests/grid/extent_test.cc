// occupied_corners(): boxes around dense voxels, not around whole leaves, under any affine transform.
#include "vdbcloud/grid/extent.h"

#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

openvdb::BBoxd box_of(const std::vector<Vec3d>& points)
{
    openvdb::BBoxd box;
    for (const Vec3d& p : points) box.expand(p);
    return box;
}

TEST(OccupiedCorners, BoxesAreTightAroundVoxels)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->tree().setValueOn(Coord(3, 4, 5), 1.0f);
    grid->tree().setValueOn(Coord(10, 4, 5), 0.5f);
    const auto points = occupied_corners(*grid);
    EXPECT_EQ(points.size(), 16u);  // two leaves
    EXPECT_LT((box_of(points).min() - Vec3d(1.25, 1.75, 2.25)).length(), 1e-12);
    EXPECT_LT((box_of(points).max() - Vec3d(5.25, 2.25, 2.75)).length(), 1e-12);
}

/// How far points reach along a direction.
double support(const std::vector<Vec3d>& points, const Vec3d& along)
{
    double most = -1e300;
    for (const Vec3d& p : points) most = std::max(most, p.dot(along));
    return most;
}

TEST(OccupiedCorners, HaveTheHullOfAllVoxelsWhereverLeavesCutThem)
{
    // A body of 23 x 17 x 29 voxels with holes, by its place among the leaves. Along any direction the corners reach as
    // far as the boxes of all voxels do; along diagonals one box for each leaf would reach up to 7 voxels further.
    for (const Coord& at : {Coord(0, 0, 0), Coord(3, -5, 1), Coord(-8, 8, 15), Coord(-23, 6, -29)}) {
        auto grid = openvdb::FloatGrid::create(0.0f);
        std::vector<Vec3d> all;
        for (int n = 0; n < 23 * 17 * 29; ++n) {
            const Coord c(n / (17 * 29), n / 29 % 17, n % 29);
            const Vec3d from = (c.asVec3d() - Vec3d(11, 8, 14)) / Vec3d(11.6, 8.7, 14.6);
            if (from.length() > 1 || (c[0] * 7 + c[1] * 5 + c[2] * 3) % 4 == 0) continue;
            grid->tree().setValueOn(c + at, 1.0f);
            for (int corner = 0; corner < 8; ++corner)
                all.push_back((c + at).asVec3d() +
                              Vec3d(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5));
        }
        const auto points = occupied_corners(*grid);
        EXPECT_LT(points.size(), 8u * 23 * 25) << "an ellipse of integers has few corners";
        for (int i = -3; i <= 3; ++i)
            for (int j = -3; j <= 3; ++j)
                for (int k = -3; k <= 3; ++k) {
                    const Vec3d along(i, j + 0.1, k - 0.2);
                    EXPECT_NEAR(support(points, along), support(all, along), 1e-9) << along << " at " << at;
                }
    }
}

TEST(OccupiedCorners, OfManyVoxelsAreFew)
{
    // 64^3 voxels: 64 planes of 4 corners, whatever the order in which leaves come.
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->denseFill(CoordBBox(Coord(-5, 1, 2), Coord(58, 64, 65)), 1.0f);
    grid->tree().voxelizeActiveTiles();
    EXPECT_EQ(occupied_corners(*grid).size(), 8u * 4 * 64);
}

TEST(OccupiedCorners, ExcludeValuesBelowTheFraction)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->sparseFill(CoordBBox(Coord(0, 0, 0), Coord(127, 127, 127)), 0.01f);
    grid->tree().setValueOn(Coord(200, 0, 0), 1.0f);
    EXPECT_EQ(occupied_corners(*grid, 0.02).size(), 8u);
    const auto all = box_of(occupied_corners(*grid, 0.001));
    EXPECT_EQ(all.min(), Vec3d(-0.5, -0.5, -0.5));
    EXPECT_EQ(all.max(), Vec3d(200.5, 127.5, 127.5));
}

TEST(OccupiedCorners, FollowARotation)
{
    auto transform = openvdb::math::Transform::createLinearTransform(1.0);
    transform->postRotate(openvdb::math::pi<double>() / 2, openvdb::math::Z_AXIS);
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(transform);
    grid->tree().setValueOn(Coord(10, 0, 0), 1.0f);
    const Vec3d centre = box_of(occupied_corners(*grid)).getCenter();
    EXPECT_LT((centre - transform->indexToWorld(Vec3d(10, 0, 0))).length(), 1e-12);
    EXPECT_NEAR(std::abs(centre[1]), 10, 1e-12);
}

TEST(InterpolantCorners, ReachOneVoxelBeyondTheThinnestMatter)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    grid->tree().setValueOn(Coord(3, 4, 5), 1.0f);
    grid->tree().setValueOn(Coord(90, 4, 5), 1e-9f);
    grid->tree().setValueOn(Coord(200, 4, 5), 0.0f);
    const auto box = box_of(interpolant_corners(*grid));
    EXPECT_EQ(box.min(), Vec3d(1, 1.5, 2));
    EXPECT_EQ(box.max(), Vec3d(45.5, 2.5, 3));
    auto glow = openvdb::Vec3SGrid::create(openvdb::Vec3f(0.0f));
    glow->tree().setValueOn(Coord(0, 0, 0), openvdb::Vec3f(0, 0, 1e-9f));
    glow->tree().setValueOn(Coord(9, 0, 0), openvdb::Vec3f(0, 1, 0));
    EXPECT_EQ(box_of(interpolant_corners(*glow)).max(), Vec3d(10, 1, 1));
    EXPECT_EQ(box_of(interpolant_corners(*glow)).min(), Vec3d(-1, -1, -1));
    EXPECT_EQ(box_of(occupied_corners(*glow)).min(), Vec3d(8.5, -0.5, -0.5));
}

TEST(OccupiedCorners, AreEmptyIfNoValueIsAboveZero)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    EXPECT_TRUE(occupied_corners(*grid).empty());
    grid->tree().setValueOn(Coord(1, 1, 1), 0.0f);
    EXPECT_TRUE(occupied_corners(*grid).empty());
}

}  // namespace
}  // namespace vdbcloud
