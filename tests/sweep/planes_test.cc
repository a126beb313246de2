// Light through the planes of the box about a medium: the fast sweep against the reference, and closed forms.
#include "support/voxel_field.h"
#include "sweep/swept_medium.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

using test::set_of;
using Medium = test::SweptMedium;

double clumps(const Vec3i& p, uint64_t seed)
{
    const double s = std::sin(0.31 * p.x() + double(seed)) + std::sin(0.27 * p.y()) + std::sin(0.36 * p.z());
    return s > 0.9 ? 0.3 + uniform(hash_bits(seed, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z()))) : 0.0;
}

double sum(const std::vector<float>& values)
{
    double total = 0;
    for (float v : values) total += v;
    return total;
}

/// Directions of unit weight with inflow 1, without moments.
SweepSet along(const std::vector<Vec3d>& directions)
{
    SweepSet set = test::one_by_one(directions);
    std::fill(set.inflow.begin(), set.inflow.end(), 1.0f);
    return set;
}

TEST(PlanesOfASweep, FastEqualsReferenceAcrossVoidsAndCutBlocks)
{
    // The box ends within blocks, and clumps leave whole blocks of its planes empty.
    Medium m(test::voxel_field(Vec3i(45, 38, 52), Vec3d(0.5, 0.7, 0.6), [](const Vec3i& p) { return clumps(p, 3); }));
    m.add_source([](const Vec3i& p) { return 1 + std::sin(0.7 * p.x() - 0.2 * p.z()); });
    SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0);
    for (size_t n = 0; n < set.count(); ++n) set.inflow[n] = float(0.1 + 0.02 * double(n));
    for (const Vec3d& axis : {Vec3d(0, 1, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, -1).unit()}) {
        set.direction.push_back(axis);
        set.weight.push_back(0.2f);
        set.source_basis.push_back(1);
        set.moment_basis.push_back(1);
        set.inflow.push_back(0.7f);
    }
    SweepResult result;
    PlaneLight fast, slow;
    TransportSweep sweep(m.index, m.faces);
    sweep.run(set, m.fields(), result, &fast);
    reference_sweep(m.index, m.faces, set, m.fields(), result, &slow);
    const ActiveBox box(m.index.blocks());
    double from_sky = 0;
    for (size_t face = 0; face < 6; ++face) {
        ASSERT_EQ(fast.from_medium[face].size(), box.cells(int(face)));
        ASSERT_EQ(slow.from_medium[face].size(), box.cells(int(face)));
        EXPECT_GT(sum(slow.from_medium[face]), 10) << face;
        from_sky += sum(slow.from_sky[face]);
        EXPECT_NEAR(fast.sky_in[face], slow.sky_in[face], 1e-6 * slow.sky_in[face]);
        const double largest = *std::max_element(slow.from_medium[face].begin(), slow.from_medium[face].end());
        for (size_t cell = 0; cell < box.cells(int(face)); ++cell) {
            ASSERT_NEAR(fast.from_medium[face][cell], slow.from_medium[face][cell], 1e-5 * largest) << face;
            ASSERT_NEAR(fast.from_sky[face][cell], slow.from_sky[face][cell], 1e-5 * largest) << face;
        }
    }
    EXPECT_GT(from_sky, 100);
    SweepResult alone;
    TransportSweep(m.index, m.faces).run(set, m.fields(), alone);
    sweep.run(set, m.fields(), result, &fast);
    EXPECT_EQ(alone.moments, result.moments) << "the planes do not change the sweep";
}

TEST(PlanesOfASweep, AreUniformInTheWhiteFurnace)
{
    Medium m(test::voxel_field(Vec3i(30, 41, 26), Vec3d(0.7), [](const Vec3i& p) { return clumps(p, 5); }));
    m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });  // Y_00 times this is 1
    SweepResult result;
    PlaneLight planes;
    TransportSweep(m.index, m.faces)
        .run(set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 1.0), m.fields(), result, &planes);
    for (size_t face = 0; face < 6; ++face) {
        EXPECT_NEAR(planes.of_unit_radiance[face], pi, face / 2 == 1 ? 1e-6 : 0.13) << "half-range Gauss about y";
        EXPECT_NEAR(planes.sky_in[face], planes.of_unit_radiance[face], 1e-6);
        for (size_t cell = 0; cell < planes.from_sky[face].size(); ++cell)
            ASSERT_NEAR(planes.from_medium[face][cell] + planes.from_sky[face][cell], planes.sky_in[face], 2e-5);
    }
}

TEST(PlanesOfASweep, ABlackTowerShadesTheBaseWhereItsShadowFalls)
{
    // A tower of 8 x 40 x 8 voxels and a low black wall at x = 80: the box spans the ground between. Light falls along
    // (0.6, -0.8, 0), so the shadow on the base reaches 0.75 x 40 = 30 voxels beyond the tower's far side.
    Medium m(
        test::voxel_clouds({{Vec3i(0, 0, 0), Vec3i(7, 39, 7)}, {Vec3i(80, 0, 0), Vec3i(87, 7, 15)}}, Vec3d(1.0), 1e4));
    m.add_source([](const Vec3i&) { return 0.0; });
    SweepResult result;
    PlaneLight planes;
    TransportSweep(m.index, m.faces).run(along({Vec3d(0.6, -0.8, 0)}), m.fields(), result, &planes);
    const ActiveBox box(m.index.blocks());
    EXPECT_EQ(box.first, Vec3i(0, 0, 0));
    EXPECT_EQ(box.last, Vec3i(87, 39, 15));
    const auto light = [&](int x, int z) {
        const size_t cell = box.cell(Blocks::YMinus, Vec3i(x, 0, z));
        return double(planes.from_medium[Blocks::YMinus][cell]) + planes.from_sky[Blocks::YMinus][cell];
    };
    for (int x = 0; x < 80; ++x) {
        const bool dark = x < 8 + 30;
        EXPECT_NEAR(light(x, 3), dark ? 0 : 0.8, 1e-6) << x;
        EXPECT_NEAR(light(x, 12), 0.8, 1e-6) << x << ": beside the tower";
    }
    EXPECT_NEAR(sum(planes.from_medium[Blocks::YPlus]), 0, 1e-5) << "no light goes up";
    EXPECT_EQ(sum(planes.from_sky[Blocks::YPlus]), 0);
    EXPECT_NEAR(planes.sky_in[Blocks::YPlus], 0.8, 1e-6);
    EXPECT_NEAR(planes.sky_in[Blocks::XMinus], 0.6, 1e-6);
    EXPECT_EQ(planes.sky_in[Blocks::YMinus], 0);
}

TEST(PlanesOfASweep, CarryThePowerThatABallEmits)
{
    // A ball with a soft edge glows in the middle of its box: what passes the planes is emission less absorption. The
    // sweep is not conservative: 2 % at 32 voxels, as through the ball's own faces.
    const int n = 32;
    const double h = 1.0 / n;
    Medium m(test::voxel_field(Vec3i(n), Vec3d(h), [&](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) * h - Vec3d(0.5);
        return 20 * std::max(0.0, 1 - x.dot(x) / 0.2);
    }));
    m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });
    SweepResult result;
    PlaneLight planes;
    TransportSweep(m.index, m.faces)
        .run(set_of(ordinates(OrdinateKind::LevelSymmetric, 80, 1), 0, 0, 0), m.fields(), result, &planes);
    double gain = 0, out = 0;
    for (size_t slot = 0; slot < m.index.blocks().count() * 512; ++slot)
        gain += m.sigma[slot] * h * std::sqrt(4 * pi) * (std::sqrt(4 * pi) - result.moments[0][slot]);
    for (size_t face = 0; face < 6; ++face) {
        EXPECT_NEAR(sum(planes.from_medium[face]) / sum(planes.from_medium[0]), 1, 1e-5) << "planes are alike";
        out += sum(planes.from_medium[face]);
        EXPECT_EQ(sum(planes.from_sky[face]), 0);
    }
    EXPECT_NEAR(out / gain, 1, 0.02);
}

TEST(PlanesOfASweep, OfALayerHaveNoSides)
{
    // Layer of optical depth 2 without a source under inflow 1: each ray leaves with exp(-2 / mu).
    const int n = 16;
    Medium m(test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 2.0; }), {true, false, true});
    m.add_source([](const Vec3i&) { return 0.0; });
    SweepResult result;
    PlaneLight planes;
    reference_sweep(m.index, m.faces, along({Vec3d(0.48, 0.8, 0.36), Vec3d(0.6, -0.8, 0)}), m.fields(), result,
                    &planes);
    for (const size_t face : {0, 1, 4, 5}) EXPECT_TRUE(planes.from_medium[face].empty());
    for (const size_t face : {2, 3}) {
        ASSERT_EQ(planes.from_medium[face].size(), 64u);
        for (float out : planes.from_medium[face]) EXPECT_NEAR(out, 0.8 * std::exp(-2 / 0.8), 1e-6);
        EXPECT_EQ(sum(planes.from_sky[face]), 0);
        EXPECT_NEAR(planes.sky_in[face], 0.8, 1e-6);
    }
}

/// The sum over the cells of power per direction, against the values of the cells.
void expect_sums_of_cells(const PlaneLight& planes)
{
    for (size_t face = 0; face < 6; ++face) {
        const double medium = sum(planes.from_medium[face]), sky = sum(planes.from_sky[face]);
        double medium_along = 0, sky_along = 0;
        for (const double power : planes.medium_along[face]) medium_along += power;
        for (const double power : planes.sky_along[face]) sky_along += power;
        EXPECT_NEAR(medium_along, medium, 1e-6 * (medium + sky)) << face;  // cells are in single precision
        EXPECT_NEAR(sky_along, sky, 1e-6 * (medium + sky)) << face;
    }
}

TEST(PlanesOfASweep, SumsWithoutCellsAreThoseOfTheReference)
{
    Medium m(test::voxel_field(Vec3i(45, 38, 52), Vec3d(0.5, 0.7, 0.6), [](const Vec3i& p) { return clumps(p, 3); }));
    m.add_source([](const Vec3i& p) { return 1 + std::sin(0.7 * p.x() - 0.2 * p.z()); });
    SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0);
    for (size_t n = 0; n < set.count(); ++n) set.inflow[n] = float(0.1 + 0.02 * double(n));
    SweepResult result;
    PlaneLight sums, cells, slow;
    sums.by_cell = false;
    TransportSweep sweep(m.index, m.faces);
    sweep.run(set, m.fields(), result, &sums);
    sweep.run(set, m.fields(), result, &cells);
    reference_sweep(m.index, m.faces, set, m.fields(), result, &slow);
    expect_sums_of_cells(cells);
    expect_sums_of_cells(slow);
    EXPECT_LE(sums.traced, cells.traced) << "rays from the shadows of blocks alone";
    EXPECT_GT(sums.traced, 100u);
    for (size_t face = 0; face < 6; ++face) {
        EXPECT_TRUE(sums.from_medium[face].empty() && sums.from_sky[face].empty());
        for (size_t n = 0; n < set.count(); ++n) {
            const double whole = slow.medium_along[face][n] + slow.sky_along[face][n];
            ASSERT_NEAR(sums.medium_along[face][n], slow.medium_along[face][n], 1e-5 * whole) << face << ' ' << n;
            ASSERT_NEAR(sums.sky_along[face][n], slow.sky_along[face][n], 1e-5 * whole) << face << ' ' << n;
        }
    }
}

/// Two cubes of 8 voxels `away` from each other along each axis, of radiance 1.
Medium cubes(int away)
{
    Medium m(test::voxel_clouds({{Vec3i(3), Vec3i(10)}, {Vec3i(away), Vec3i(away + 7)}}, Vec3d(1.0), 0.5));
    m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });
    return m;
}

PlaneLight light_of(const Medium& m, double sky)
{
    SweepResult result;
    PlaneLight planes;
    planes.by_cell = false;
    TransportSweep(m.index, m.faces)
        .run(set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, sky), m.fields(), result, &planes);
    return planes;
}

TEST(PlanesOfASweep, CostTheBlocksAndNotTheBox)
{
    // A block's shadow along a direction covers a few tiles, wherever the plane lies. Both cubes together shine as
    // twice one of them does; a shadow is sampled at the middles of cells, and rays take light from a face half a voxel
    // before it, so single directions differ by some per cent.
    const auto power = [](const PlaneLight& planes, size_t m) {
        double all = 0;
        for (size_t face = 0; face < 6; ++face) all += planes.medium_along[face][m];
        return all;
    };
    Medium alone(test::voxel_clouds({{Vec3i(3), Vec3i(10)}}, Vec3d(1.0), 0.5));
    alone.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });
    const PlaneLight one = light_of(alone, 0);
    const uint64_t near = light_of(cubes(203), 0).traced;
    EXPECT_GT(near, 32u * 2 * 3);
    EXPECT_LT(near, 32u * 16 * 3 * 12) << "16 blocks, 3 planes, 12 tiles of a shadow at most";
    for (const int away : {20003, 200003, 1000000003}) {
        const PlaneLight two = light_of(cubes(away), 0);
        EXPECT_LT(double(two.traced), 1.2 * double(near)) << away;
        EXPECT_GT(double(two.traced), 0.8 * double(near)) << away;
        double both = 0, twice = 0;
        for (size_t m = 0; m < one.direction.size(); ++m) {
            both += power(two, m);
            twice += 2 * power(one, m);
            EXPECT_NEAR(power(two, m) / (2 * power(one, m)), 1, 0.15) << away << ' ' << m;
        }
        EXPECT_NEAR(both / twice, 1, 0.03) << away;
    }
}

TEST(PlanesOfASweep, WithoutCellsKeepTheWhiteFurnace)
{
    // What the cubes hide of the sky they send themselves.
    for (const int away : {203, 3003}) {
        const Medium m = cubes(away);
        const PlaneLight planes = light_of(m, 1);
        const ActiveBox box(m.index.blocks());
        const SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 1);
        for (int face = 0; face < 6; ++face)
            for (size_t n = 0; n < set.count(); ++n) {
                const double out = set.weight[n] * set.direction[n][face / 2] * (face % 2 ? 1 : -1);
                const double found = planes.medium_along[size_t(face)][n] + planes.sky_along[size_t(face)][n];
                EXPECT_NEAR(found, std::max(out, 0.0) * double(box.cells(face)), 1e-4 * 16 * 64) << face << ' ' << n;
                if (out > 0) {
                    EXPECT_LT(planes.sky_along[size_t(face)][n], out * double(box.cells(face)) + 1e-9);
                }
            }
    }
}

}  // namespace
}  // namespace vdbcloud
