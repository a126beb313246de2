// Solids beside a medium as P1 and sweeps see them: what they hide of a sun, and what they take of the medium.
#include "support/fields.h"
#include "support/grids.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace vdbcloud {
namespace {

using namespace test;

FloatGridPtr cube()
{
    return box({16, 16, 16}, 1, [](openvdb::Coord) { return 1.0; });
}

Medium medium(double sigma_t, double albedo, double g)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    m.albedo = Vec3d(albedo);
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

CollidedLight solved(const FloatGrid& density, const Medium& m, const std::vector<Light>& lights,
                     const ScatterOptions& o, ScatterReport& report)
{
    return scatter_p1(density, nullptr, nullptr, m, lights, o, {}, report);
}

double at(const CollidedLight& light, int i, int j, int k)
{
    return openvdb::gridPtrCast<FloatGrid>(light.phi)->tree().getValue(openvdb::Coord(i, j, k));
}

/// Hides the sun from the columns x = 8 .. 15.
Solid half_roof() { return make_box(Vec3d(7.5, 40, -50), Vec3d(50, 41, 50)); }

TEST(Solids, HideOneHalfOfTheSunsPower)
{
    const auto density = cube();
    for (const int iterations : {0, 2}) {
        ScatterOptions o;
        o.closure.iterations = iterations;
        const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
        ScatterReport all, half, none;
        solved(*density, medium(0.2, 0.9, 0.5), sun, o, all);
        o.solids = {half_roof()};
        const CollidedLight light = solved(*density, medium(0.2, 0.9, 0.5), sun, o, half);
        // Columns of voxels are lit or hidden, each whole: to the rounding of float depths.
        EXPECT_NEAR(half.channel[0].deposited, all.channel[0].deposited / 2, 1e-6 * all.channel[0].deposited);
        EXPECT_NEAR(half.channel[0].beam_in, all.channel[0].beam_in / 2, 1e-6 * all.channel[0].beam_in);
        EXPECT_GT(at(light, 2, 8, 8), 3 * at(light, 13, 8, 8)) << "light diffuses into the shadow from its edge alone";
        EXPECT_EQ(half.channel[0].lines, -1) << "lines do not know shadows";
        ASSERT_TRUE(half.solids);
        EXPECT_EQ(get_text(*light.phi, schema::solids, ""), solids_digest(o.solids, true));

        o.solids = {make_box(Vec3d(-50, 40, -50), Vec3d(50, 41, 50))};
        const CollidedLight dark = solved(*density, medium(0.2, 0.9, 0.5), sun, o, none);
        EXPECT_EQ(none.channel[0].deposited, 0);
        EXPECT_EQ(at(dark, 8, 8, 8), 0);
    }
}

TEST(Solids, ShadowedLightIsThatOfTheLitHalfAlone)
{
    // Light is linear in its sources: the light of the lit half and, mirrored, that of the other half make up the light
    // without a roof.
    const auto density = cube();
    ScatterOptions o;
    o.solve.tolerance = 1e-9;
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
    ScatterReport report;
    const CollidedLight all = solved(*density, medium(0.2, 0.9, 0.5), sun, o, report);
    o.solids = {half_roof()};
    ScatterReport shadowed;
    const CollidedLight half = solved(*density, medium(0.2, 0.9, 0.5), sun, o, shadowed);
    for (const int i : {0, 3, 7, 8, 12, 15})
        EXPECT_NEAR(at(half, i, 5, 6) + at(half, 15 - i, 5, 6), at(all, i, 5, 6), 1e-5 * at(all, i, 5, 6)) << i;
}

TEST(Solids, TakeTheirVoxelsAndKeepTheFurnace)
{
    const auto density = cube();
    for (const int iterations : {0, 3}) {
        ScatterOptions o;
        o.closure.iterations = iterations;
        o.solve.tolerance = 1e-9;
        o.sky = Sky::constant(Vec3d(2.0));
        o.solids = {make_ball(Vec3d(8, 8, 8), 3.2)};
        ScatterReport report;
        const CollidedLight light = solved(*density, medium(0.3, 1, 0.6), {}, o, report);
        size_t within = 0;
        for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j)
                for (int k = 0; k < 16; ++k) within += (Vec3d(i, j, k) - Vec3d(8, 8, 8)).length() <= 3.2;
        EXPECT_EQ(report.voxels, 4096 - within);
        EXPECT_GT(within, 100u);
        for (const int i : {0, 4, 12}) EXPECT_NEAR(at(light, i, 8, 8), 8 * pi, 1e-5 * 8 * pi) << i;
    }
}

TEST(Solids, AreRefusedBesideAMediumThatRepeats)
{
    ScatterOptions o;
    o.periodic = {true, false, true};
    o.solids = {half_roof()};
    ScatterReport report;
    EXPECT_NE(sentence<InputError>([&] {
                  solved(*cube(), medium(0.2, 0.9, 0), {make_sun(Vec3d(0, 1, 0))}, o, report);
              }).find("solids beside a medium that repeats"),
              std::string::npos);
}

}  // namespace
}  // namespace vdbcloud
