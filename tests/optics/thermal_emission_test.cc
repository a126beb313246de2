// The emission of hot media, voxel by voxel.
#include "vdbcloud/optics/thermal_emission.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/scene/blackbody.h"

#include "support/fields.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <functional>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::math::Transform;
using test::box;

Medium soot(const Vec3d& sigma_t, const Vec3d& albedo)
{
    Medium m;
    m.sigma_t_per_density = sigma_t;
    m.albedo = albedo;
    return m;
}

FloatGridPtr temperatures(const Vec3i& n, double h, const std::function<double(Coord)>& f)
{
    const auto grid = box(n, h, f);
    grid->setName("temperature");
    return grid;
}

Vec3d at(const Vec3SGridPtr& grid, const Coord& voxel) { return Vec3d(grid->tree().getValue(voxel)); }

void expect_close(const Vec3d& found, const Vec3d& expected, double relative)
{
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], relative * std::abs(expected[c])) << c;
}

TEST(ThermalEmission, IsAbsorptionTimesPlanck)
{
    const auto density = box({9, 9, 9}, 0.5, [](Coord c) { return 0.25 * (c[0] % 4); });
    const auto heat = temperatures({9, 9, 9}, 0.5, [](Coord c) { return 200.0 * c[1]; });
    const auto tint = Vec3SGrid::create(Vec3f(1.0f));
    tint->setTransform(density->transform().copy());
    tint->tree().setValue(Coord(3, 8, 3), Vec3f(0.5f, 4.0f, 0.0f));
    const Medium medium = soot({2, 3, 4}, {0.25, 0.5, 1});
    Fire fire;
    fire.temperature = heat;
    fire.intensity = 0.5;
    const auto j = thermal_emission(*density, medium, tint.get(), fire);
    ASSERT_TRUE(j);
    // The table of black bodies errs by 1e-5.
    expect_close(at(j, Coord(3, 8, 4)), 0.5 * 0.75 * Vec3d(2 * 0.75, 3 * 0.5, 0) * blackbody(1600), 2e-5);
    expect_close(at(j, Coord(3, 8, 3)), 0.5 * 0.75 * Vec3d(2 * 0.875, 0, 4) * blackbody(1600), 2e-5);
    expect_close(at(j, Coord(1, 5, 0)), 0.5 * 0.25 * Vec3d(2 * 0.75, 3 * 0.5, 0) * blackbody(1000), 2e-5);
    // Neither cold matter nor a void is active.
    EXPECT_FALSE(j->tree().isValueOn(Coord(1, 2, 0)));
    EXPECT_FALSE(j->tree().isValueOn(Coord(0, 8, 0)));
    EXPECT_TRUE(j->tree().isValueOn(Coord(1, 3, 0)));
    // The grid's own unit.
    fire.scale = 2;
    fire.offset = -100;
    expect_close(at(thermal_emission(*density, medium, nullptr, fire), Coord(3, 4, 4)),
                 0.5 * 0.75 * Vec3d(2 * 0.75, 3 * 0.5, 0) * blackbody(1500), 2e-5);
}

TEST(ThermalEmission, OfFlameNeedsNoSmoke)
{
    const auto density = box({4, 4, 4}, 1, [](Coord) { return 0.0; });
    density->tree().setValue(Coord(1, 1, 1), 2.0f);
    const auto flame = temperatures({6, 4, 4}, 1, [](Coord c) { return 0.1 * c[0]; });
    Fire fire;
    fire.flame = flame;
    fire.scale = 4000;
    fire.flame_absorption = 7;
    const Medium medium = soot({3, 6, 15}, Vec3d(0.0));
    auto j = thermal_emission(*density, medium, nullptr, fire);
    expect_close(at(j, Coord(5, 2, 2)), 7 * 0.5 * blackbody(2000), 2e-5);
    expect_close(at(j, Coord(3, 1, 1)), 7 * 0.3 * blackbody(1200), 2e-5);
    EXPECT_FALSE(j->tree().isValueOn(Coord(1, 1, 1))) << "400 K";
    // A temperature beside it; absorption of the medium where none is given.
    fire.temperature = temperatures({6, 4, 4}, 1, [](Coord) { return 1500.0; });
    fire.scale = 1;
    fire.flame_absorption = -1;
    j = thermal_emission(*density, medium, nullptr, fire);
    expect_close(at(j, Coord(1, 1, 1)), (Vec3d(6, 12, 30) + Vec3d(8 * 0.1)) * blackbody(1500), 2e-5);
    expect_close(at(j, Coord(5, 0, 3)), Vec3d(8 * 0.5) * blackbody(1500), 2e-5);
}

TEST(ThermalEmission, OnOtherLatticesIsSampled)
{
    // A temperature linear in space is sampled exactly, to the rounding of floats: 1e-7, and 17 times that of light.
    const auto density = box({8, 8, 8}, 1, [](Coord) { return 1.0; });
    const auto heat = temperatures({60, 60, 60}, 0.25, [](Coord c) { return 1000.0 + 10 * c[0] + 5 * c[1]; });
    Fire fire;
    fire.temperature = heat;
    const Medium medium = soot(Vec3d(1.0), Vec3d(0.0));
    const auto j = thermal_emission(*density, medium, nullptr, fire);
    expect_close(at(j, Coord(3, 2, 5)), blackbody(1000 + 10 * 12 + 5 * 8), 4e-5);
    // Flame on a lattice of its own is seen beyond the density.
    fire.flame = box({80, 4, 4}, 0.5, [](Coord) { return 1.0; });
    fire.temperature = temperatures({40, 8, 8}, 1, [](Coord) { return 1400.0; });
    fire.flame_absorption = 2;
    expect_close(at(thermal_emission(*density, medium, nullptr, fire), Coord(20, 1, 1)), 2 * blackbody(1400), 2e-5);
}

TEST(ThermalEmission, TilesStayTilesWhereAllIsOne)
{
    const auto density = FloatGrid::create(0.0f), heat = FloatGrid::create(0.0f);
    const CoordBBox all(Coord(0), Coord(127));
    density->sparseFill(all, 1.0f);
    heat->sparseFill(all, 1300.0f);
    heat->tree().setValue(Coord(3, 4, 5), 1700.0f);
    Fire fire;
    fire.temperature = heat;
    const auto j = thermal_emission(*density, soot(Vec3d(2.0), Vec3d(0.5)), nullptr, fire);
    EXPECT_EQ(j->tree().leafCount(), 1u);
    EXPECT_EQ(j->activeVoxelCount(), uint64_t(128 * 128 * 128));
    expect_close(at(j, Coord(100, 90, 3)), blackbody(1300), 2e-5);
    expect_close(at(j, Coord(3, 4, 5)), blackbody(1700), 2e-5);
    expect_close(at(j, Coord(3, 4, 6)), blackbody(1300), 2e-5);
    // A tile of matter about a small fire costs the fire alone.
    const auto spark = FloatGrid::create(0.0f);
    spark->tree().setValue(Coord(60, 60, 60), 1700.0f);
    fire.temperature = spark;
    EXPECT_EQ(thermal_emission(*density, soot(Vec3d(2.0), Vec3d(0.5)), nullptr, fire)->activeVoxelCount(), 1u);
}

TEST(ThermalEmission, InactiveTemperaturesShineWhereTheirBackgroundDoes)
{
    const auto density = FloatGrid::create(0.0f), rise = FloatGrid::create(0.0f);
    density->sparseFill(CoordBBox(Coord(0), Coord(15)), 1.0f);
    rise->tree().setValue(Coord(3, 4, 5), 400.0f);
    Fire fire;
    fire.temperature = rise;
    fire.offset = 1300;
    const auto j = thermal_emission(*density, soot(Vec3d(2.0), Vec3d(0.5)), nullptr, fire);
    EXPECT_EQ(j->tree().leafCount(), 1u);
    EXPECT_EQ(j->activeVoxelCount(), uint64_t(16 * 16 * 16));
    expect_close(at(j, Coord(3, 4, 5)), blackbody(1700), 2e-5);
    expect_close(at(j, Coord(3, 4, 6)), blackbody(1300), 2e-5);
    expect_close(at(j, Coord(12, 2, 9)), blackbody(1300), 2e-5);
}

TEST(ThermalEmission, OfColdOrOddTemperatures)
{
    const auto density = box({3, 3, 3}, 1, [](Coord) { return 1.0; });
    const Medium medium = soot(Vec3d(1.0), Vec3d(0.0));
    const auto with = [&](double t) {
        Fire fire;
        fire.temperature = temperatures({3, 3, 3}, 1, [t](Coord) { return t; });
        return thermal_emission(*density, medium, nullptr, fire);
    };
    for (const double t : {0.0, -300.0, 288.0, 499.0}) EXPECT_FALSE(with(t)) << t;
    expect_close(at(with(1e9), Coord(1)), blackbody(1e9), 1e-6);
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(at(with(3e38), Coord(1))[c]));
    EXPECT_FALSE(thermal_emission(*density, soot(Vec3d(1.0), Vec3d(1.0)), nullptr,
                                  [] {
                                      Fire fire;
                                      fire.temperature = temperatures({3, 3, 3}, 1, [](Coord) { return 1500.0; });
                                      return fire;
                                  }()))
        << "what absorbs nothing emits nothing";
    EXPECT_FALSE(thermal_emission(*density, medium, nullptr, {}));
}

TEST(ThermalEmission, AddsToAGridOfEmission)
{
    const auto density = box({4, 4, 4}, 1, [](Coord) { return 1.0; });
    const auto given = Vec3SGrid::create();
    given->setName("emission");
    given->tree().setValue(Coord(1, 2, 3), Vec3f(1, 2, 3));
    Fire fire;
    fire.temperature = temperatures({4, 4, 4}, 1, [](Coord) { return 1800.0; });
    const auto hot = thermal_emission(*density, soot(Vec3d(1.0), Vec3d(0.0)), nullptr, fire);
    const auto sum = sum_of_emission(given, hot);
    EXPECT_EQ(sum->getName(), "emission");
    expect_close(at(sum, Coord(1, 2, 3)), Vec3d(1, 2, 3) + blackbody(1800), 2e-5);
    expect_close(at(sum, Coord(0, 0, 0)), blackbody(1800), 2e-5);
    // Of two lattices the finer one is kept.
    const auto coarse = Vec3SGrid::create();
    coarse->setTransform(Transform::createLinearTransform(2));
    coarse->fill(CoordBBox(Coord(-3), Coord(5)), Vec3f(1, 2, 3));
    for (const auto& both : {sum_of_emission(coarse, hot), sum_of_emission(hot, coarse)}) {
        EXPECT_EQ(both->voxelSize(), Vec3d(1.0));
        expect_close(at(both, Coord(1, 2, 3)), Vec3d(1, 2, 3) + blackbody(1800), 2e-5);
        expect_close(at(both, Coord(-1, 2, 3)), Vec3d(1, 2, 3), 2e-5);
    }
    EXPECT_EQ(sum_of_emission(given, nullptr), given);
    EXPECT_EQ(sum_of_emission(nullptr, hot), hot);
}

TEST(ThermalEmission, DoesNotDependOnThreads)
{
    const auto density = box({40, 40, 40}, 1, [](Coord c) { return test::clumps(c, 3, 1.0); });
    Fire fire;
    fire.temperature = temperatures({40, 40, 40}, 1, [](Coord c) { return 2500 * test::clumps(c, 4, 1.0); });
    const auto with = [&](size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return grid_digest(*thermal_emission(*density, soot(Vec3d(1.0), Vec3d(0.3)), nullptr, fire));
    };
    EXPECT_EQ(with(1), with(2));
}

}  // namespace
}  // namespace vdbcloud
