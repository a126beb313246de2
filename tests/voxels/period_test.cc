// Media that repeat: the rule of the period, layers about it, sampling and marching across the seam.
#include "vdbcloud/core/error.h"
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/voxels/active_box.h"
#include "vdbcloud/voxels/extend.h"
#include "vdbcloud/voxels/period.h"
#include "vdbcloud/voxels/voxel_index.h"

#include "support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

constexpr std::array<bool, 3> xz{true, false, true};
const Vec3i size(11, 6, 9);  // no multiple of a brick

/// A clumpy body at `low`, with holes.
FloatGridPtr body(const Vec3i& low)
{
    const auto grid = FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    for (int x = 0; x < size[0]; ++x)
        for (int y = 0; y < size[1]; ++y)
            for (int z = 0; z < size[2]; ++z)
                if (const double v = clumps(Coord(x, y, z), 3, 2); v > 0 || (x + y + z) % 5 == 0)
                    grid->tree().setValueOn(Coord(low[0] + x, low[1] + y, low[2] + z), float(v));
    // The corners make the extent.
    grid->tree().setValueOn(Coord(low[0], low[1], low[2]), 1.5f);
    grid->tree().setValueOn(Coord(low[0] + size[0] - 1, low[1] + size[1] - 1, low[2] + size[2] - 1), 0.5f);
    return grid;
}

/// Copies of a body side by side, from `first` to `last` along x and z.
FloatGridPtr tiling(const FloatGrid& of, int first, int last)
{
    const auto grid = FloatGrid::create(0.0f);
    grid->setTransform(of.transform().copy());
    for (auto v = of.cbeginValueOn(); v; ++v)
        for (int i = first; i <= last; ++i)
            for (int k = first; k <= last; ++k)
                grid->tree().setValueOn(v.getCoord().offsetBy(i * size[0], 0, k * size[2]), *v);
    return grid;
}

TEST(Period, IsTheExtentOfActiveVoxelsAlongTheAxesAskedFor)
{
    const Period p = period_of(*body(Vec3i(-3, 2, 5)), xz);
    EXPECT_EQ(p.first, Vec3i(-3, 0, 5));
    EXPECT_EQ(p.length, Vec3i(11, 0, 9));
    EXPECT_TRUE(p.any());
    EXPECT_FALSE(period_of(*body(Vec3i(0)), {}).any());
    EXPECT_FALSE(period_of(*FloatGrid::create(0.0f), xz).any());
    EXPECT_EQ(p.home(Vec3i(8, 77, 4)), Vec3i(-3, 77, 13));
    EXPECT_EQ(p.home(Vec3i(-4 - 22, 77, 14)), Vec3i(7, 77, 5));
    EXPECT_EQ(p.home(Vec3d(8, 77, 4.75)), Vec3d(-3, 77, 13.75));
    const Vec3d seam = p.home(Vec3d(std::nextafter(-3.0, -4.0), 0, 5));
    EXPECT_TRUE(seam[0] >= -3 && seam[0] < 8) << seam[0];
}

TEST(Period, IsTheSameLengthInFinerAndCoarserVoxels)
{
    const auto density = box(Vec3i(16, 4, 8), 0.5, [](Coord) { return 1.0; });
    const Period p = period_of(*density, xz);
    const auto other = FloatGrid::create(0.0f);
    other->setName("other");
    other->setTransform(density->transform().copy());
    other->transform().preScale(0.5);
    EXPECT_EQ(period_in(p, density->transform(), *other).length, Vec3i(32, 0, 16));
    // Voxels of twice the edge, whose faces are the density's.
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m.postTranslate(openvdb::Vec3d(0.25));
    m.postScale(openvdb::Vec3d(1.0));
    other->setTransform(openvdb::math::Transform::createLinearTransform(m));
    EXPECT_EQ(period_in(p, density->transform(), *other).length, Vec3i(8, 0, 4));
    EXPECT_EQ(period_in(p, density->transform(), *other).first, Vec3i(0));
    EXPECT_EQ(period_in(p, density->transform(), *density).first, p.first);
    other->transform().preScale(0.9);
    EXPECT_THROW(period_in(p, density->transform(), *other), InputError);
    other->setTransform(density->transform().copy());
    other->transform().postRotate(0.2, openvdb::math::Y_AXIS);
    EXPECT_THROW(period_in(p, density->transform(), *other), InputError);
}

TEST(Period, WrappedHoldsTheVoxelsOfTheTilingAndOneLayerAbout)
{
    auto grid = body(Vec3i(-3, 2, 5));
    const Period p = period_of(*grid, xz);
    const auto tiles = tiling(*grid, -1, 1);
    grid->tree().setValueOn(Coord(8, 3, 6), 9);  // outside the period
    const auto copy = wrapped(*grid, p);
    for (int x = -6; x < 12; ++x)
        for (int y = 0; y < 10; ++y)
            for (int z = 2; z < 18; ++z) {
                const bool inside = x >= -4 && x <= 8 && z >= 4 && z <= 14;
                const Coord at(x, y, z);
                ASSERT_EQ(copy->tree().isValueOn(at), inside && tiles->tree().isValueOn(at)) << at;
                if (inside) {
                    ASSERT_EQ(copy->tree().getValue(at), tiles->tree().getValue(at)) << at;
                }
            }
}

TEST(Period, WrappedCopiesTiles)
{
    const auto grid = FloatGrid::create(0.0f);
    grid->tree().addTile(1, Coord(0, 0, 0), 2.5f, true);
    grid->tree().setValueOn(Coord(20, 3, 3), 1.0f);
    const auto copy = wrapped(*grid, period_of(*grid, {true, false, false}));
    EXPECT_EQ(copy->tree().getValue(Coord(21, 7, 7)), 2.5f);
    EXPECT_TRUE(copy->tree().isValueOn(Coord(21, 0, 5)));
    EXPECT_EQ(copy->tree().getValue(Coord(-1, 3, 3)), 1.0f);
    EXPECT_EQ(copy->activeVoxelCount(), 512u + 1 + 64 + 1);
}

TEST(Period, FringeIsThatOfTheTiling)
{
    const auto grid = body(Vec3i(-3, 2, 5));
    const auto fringe = with_fringe(*grid, period_of(*grid, xz)), tiles = with_fringe(*tiling(*grid, -1, 1));
    size_t beyond = 0;
    for (auto v = fringe->cbeginValueOn(); v; ++v) {
        ASSERT_TRUE(tiles->tree().isValueOn(v.getCoord())) << v.getCoord();
        ASSERT_EQ(*v, tiles->tree().getValue(v.getCoord())) << v.getCoord();
        beyond += v.getCoord()[1] > 7;
    }
    EXPECT_GT(beyond, 0u);
    EXPECT_EQ(fringe->evalActiveVoxelBoundingBox(), openvdb::CoordBBox(Coord(-4, 1, 4), Coord(8, 8, 14)));
}

TEST(Period, FringeHoldsNoTiles)
{
    // Transmittance grids go through the leaves of a fringe.
    const auto grid = box(Vec3i(8, 24, 8), 1, [](Coord) { return 1.0; });
    const auto fringe = with_fringe(*grid, period_of(*grid, xz));
    EXPECT_EQ(fringe->tree().activeTileCount(), 0u);
    EXPECT_EQ(fringe->activeVoxelCount(), 10u * 26 * 10);
}

TEST(Period, ActiveBoxCoversEmptyColumns)
{
    // Density above 0 in the middle third of a period of 24 active voxels.
    const auto grid = box(Vec3i(24, 5, 8), 1, [](Coord c) { return c[0] >= 8 && c[0] < 16 ? 1.0 : 0.0; });
    const ActiveBox periodic(VoxelIndex(*grid, {xz}).blocks());
    EXPECT_EQ(periodic.first, Vec3i(0, 0, 0));
    EXPECT_EQ(periodic.last, Vec3i(23, 4, 7));
    EXPECT_EQ(periodic.cells(3), 24u * 8);
    const ActiveBox alone(VoxelIndex(*grid).blocks());
    EXPECT_EQ(alone.size(0), 8);
}

TEST(Period, SamplesAreThoseOfTheTiling)
{
    for (const Vec3i& low : {Vec3i(-3, 2, 5), Vec3i(0), Vec3i(4093, 0, -4090)}) {  // the last ones span two roots
        const auto grid = body(low);
        const BrickMap map(*grid, 0, {}, period_of(*grid, xz)), tiles(*tiling(*grid, -2, 2));
        double sum = 0;
        for (int n = 0; n < 3000; ++n) {
            Vec3d at;
            for (int a = 0; a < 3; ++a) {
                const double u = uniform(hash_bits(5, uint64_t(n), uint64_t(a)));
                at[a] = low[a] + (a == 1 ? -2 + u * (size[1] + 3) : (4 * u - 1.5) * size[a]);
            }
            ASSERT_NEAR(map.sample(at), tiles.sample(at), 1e-12) << at;
            sum += map.sample(at);
        }
        EXPECT_GT(sum, 300);
        for (const double x : {0.0, 10.0, 10.5, 11.0, -0.5, -1.0})  // on and across the seam
            EXPECT_NEAR(map.sample(Vec3d(low) + Vec3d(x, 0.25, -0.25)),
                        tiles.sample(Vec3d(low) + Vec3d(x, 0.25, -0.25)), 1e-12);
    }
}

TEST(Period, AWrappedGridHoldsLeavesOfItsVoxelsAlone)
{
    // A box and a voxel far from it: along one axis, along two, with all else without end.
    auto grid = body(Vec3i(3, 4, 5));
    grid->tree().setValueOn(Coord(40, 9000, 70), 1.0f);
    grid->tree().addTile(1, Coord(128, 128, 128), 0.5f, true);
    const std::array<bool, 3> x{true, false, false}, y{false, true, false}, z{false, false, true};
    for (const auto& axes : {x, y, z, xz}) {
        const Period period = period_of(*grid, axes);
        const auto out = wrapped(*grid, period);
        // Leaves of the grid, and those of the layers before and after a period: of the tile 16^2 a face of 128^2.
        EXPECT_LT(out->tree().leafCount(), 2000u);
        EXPECT_GE(out->activeVoxelCount(), grid->activeVoxelCount());
        for (auto v = grid->cbeginValueOn(); v; ++v) {
            ASSERT_EQ(out->tree().getValue(v.getCoord()), *v);
            ASSERT_TRUE(out->tree().isValueOn(v.getCoord()));
        }
    }
    // Of a shorter period the voxels beyond it are left out.
    const auto part = wrapped(*body(Vec3i(0)), {Vec3i(0), Vec3i(5, 0, 0)});
    EXPECT_EQ(part->evalActiveVoxelBoundingBox().min()[0], -1);
    EXPECT_EQ(part->evalActiveVoxelBoundingBox().max()[0], 5);
}

TEST(Period, RaysMeetTheCellsOfTheTiling)
{
    for (const Vec3i& low : {Vec3i(-3, 2, 5), Vec3i(4093, 0, -4090)}) {
        const auto grid = body(low);
        const BrickMap map(*grid, 0, {}, period_of(*grid, xz));
        const auto tiles = tiling(*grid, -3, 3);
        for (int n = 0; n < 300; ++n) {
            // Steep enough to stay on the tiling from top to base, upwards and downwards.
            Vec3d w = direction(uint64_t(n));
            w[1] = w[1] > 0 ? std::max(w[1], 0.3) : std::min(w[1], -0.3);
            if (n % 7 == 0) w[0] = 0;
            if (n % 11 == 0) w[2] = 0;
            w.normalize();
            Vec3d middle;
            for (int a = 0; a < 3; ++a)
                middle[a] = 0.5 * (low[a] + size[a] * uniform(hash_bits(6, uint64_t(n), uint64_t(a))));
            const WorldRay ray{middle - 9 * w, w};
            const double expected = integral_of_interpolant(*tiles, ray, 0, 100);
            ASSERT_NEAR(density_depth(map, ray, 0, 100), expected, 1e-9) << n;
            ASSERT_NEAR(density_depth(map, ray, 0, std::numeric_limits<double>::infinity()), expected, 1e-9) << n;
            // From and to points within.
            ASSERT_NEAR(density_depth(map, ray, 8.7, 9.9), integral_of_interpolant(*tiles, ray, 8.7, 9.9), 1e-9) << n;
            // Bricks cover the ray between the same ends, without overlap.
            const IndexRay index(map.index_from_world(), ray);
            double last = -1, covered = 0;
            march_bricks(map, index, 0, 100, [&](double t0, double t1, int32_t, const Vec3i&) {
                EXPECT_GE(t0, last - 1e-9);
                covered += t1 - t0;
                last = t1;
                return true;
            });
            double cells = 0;
            march_cells(map, index, 0, 100, [&](double t0, double t1, const float*, const Vec3i& cell) {
                const Vec3d p = index.at((t0 + t1) / 2) - Vec3d(cell);
                for (int a = 0; a < 3; ++a) EXPECT_TRUE(p[a] > -1e-9 && p[a] < 1 + 1e-9) << p;
                cells += t1 - t0;
                return true;
            });
            EXPECT_GE(covered, cells - 1e-9);
        }
    }
}

TEST(Period, RaysAlongTheRepeatingAxesEnd)
{
    const auto grid = box(Vec3i(8, 4, 8), 1, [](Coord c) { return c[1] == 1 ? 0.0 : 1.0; });
    const BrickMap map(*grid, 0, {}, period_of(*grid, xz));
    const double far = std::numeric_limits<double>::infinity();
    // 100000 periods of 8; density 1 at y = 0 and 0 at y = 1, a slanting ray meets 0.5 in the mean.
    EXPECT_NEAR(density_depth(map, {Vec3d(0, 0, 0.3), Vec3d(1, 0, 0)}, 0, far), 8e5, 1);
    EXPECT_NEAR(density_depth(map, {Vec3d(0, 0.5, 0.3), Vec3d(-1, 0, 0)}, 0, far), 4e5, 5);  // begins with no period
    EXPECT_EQ(density_depth(map, {Vec3d(0, 1, 0.3), Vec3d(0, 0, 1)}, 0, far), 0);
    EXPECT_GT(density_depth(map, {Vec3d(0.1, 0.2, 0.3), Vec3d(1, 0, 0.7).unit()}, 0, far), 1e5);
    // From so far that an index has no room for the copy.
    EXPECT_EQ(density_depth(map, {Vec3d(0, 5e11, 0), Vec3d(1, -1, 0).unit()}, 0, far), 0);
    EXPECT_NEAR(density_depth(map, {Vec3d(0, 5e8, 0), Vec3d(1, -1, 0).unit()}, 0, far), 3 * std::sqrt(2.0), 1e-5);
}

}  // namespace
}  // namespace vdbcloud
