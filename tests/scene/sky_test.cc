// Skies: continuity, and their irradiance against quadrature.
#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(Sky, ConstantHasOneRadiance)
{
    const Vec3d radiance(0.1, 0.2, 0.7);
    const Sky sky = Sky::constant(radiance);
    for (const Vec3d& w : {Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(0.6, 0, 0.8), Vec3d(0, 0.6, -0.8)})
        EXPECT_LT((sky.radiance(w) - radiance).length(), 1e-15);
    for (const Vec3d& n : {Vec3d(0, 1, 0), Vec3d(0.36, 0.48, 0.8)})
        EXPECT_LT((sky.mean_inflow(n) - radiance).length(), 1e-14);
}

TEST(Sky, HasItsThreeColoursAndIsContinuousAtTheHorizon)
{
    const GradientSky day = GradientSky::clear_day(Vec3d(3, 3, 3), Vec3d(0, 0, 2));
    const Sky sky = day;
    EXPECT_LT((sky.radiance(Vec3d(0, 0, 1)) - day.zenith).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 0, -1)) - day.ground).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 1, 0)) - day.horizon).length(), 1e-15);
    const double e = 1e-7, level = std::sqrt(1 - e * e);
    EXPECT_LT((sky.radiance(Vec3d(level, 0, e)) - sky.radiance(Vec3d(level, 0, -e))).length(), 1e-5);
    EXPECT_GT(day.zenith[2], 2 * day.zenith[0]);  // blue
}

TEST(Sky, ClearDayHasTheIlluminanceOfTheClearSkyOfTheIesna)
{
    // IESNA: sky 0.8 + 15.5 sin(h)^0.5 klx on a level surface, sun 127.5 exp(-0.21 m) klx across its beam, at h = 45.
    const double sky = 0.8 + 15.5 * std::sqrt(std::sqrt(0.5)), sun = 127.5 * std::exp(-0.21 * std::sqrt(2.0));
    const Vec3d level = M_PI * Sky(GradientSky::clear_day(Vec3d(1), Vec3d(0, 1, 0))).mean_inflow(Vec3d(0, 1, 0));
    EXPECT_NEAR(0.2126 * level[0] + 0.7152 * level[1] + 0.0722 * level[2], sky / sun, 0.002);
}

TEST(Sky, MeanInflowIsTheIntegralOverTheHalfSphere)
{
    GradientSky g{Vec3d(0.1, 0.4, 1), Vec3d(2, 1, 0.5), Vec3d(0.3, 0, 0.05), 0, Vec3d(0.6, 0, 0.8)};
    for (double haze : {0.0, 1.0, 2.5, 4.0}) {
        g.haze = haze;
        const Sky sky = g;
        // int_0^1 s (1 - s)^haze ds = 1 / ((haze + 1)(haze + 2))
        const double share = 2 / ((haze + 1) * (haze + 2));
        EXPECT_LT((sky.mean_inflow(g.up) - (g.zenith + (g.horizon - g.zenith) * share)).length(), 3e-5);
        EXPECT_LT((sky.mean_inflow(-g.up) - (g.ground + (g.horizon - g.ground) * share)).length(), 3e-5);
        const Vec3d net = (g.zenith - g.ground) * (1 - share);  // int w L dw = pi net up: for any normal
        for (const Vec3d& n : {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0, 0.6, -0.8), Vec3d(0.36, 0.48, 0.8)}) {
            EXPECT_LT((sky.mean_inflow(n) - sky.mean_inflow(-n) - n.dot(g.up) * net).length(), 3e-5);
            // A surface and its mirror image across the horizon together receive from both halves of the sky.
            const Vec3d mirrored = n - 2 * n.dot(g.up) * g.up;
            GradientSky flipped = g;
            std::swap(flipped.zenith, flipped.ground);
            EXPECT_LT((sky.mean_inflow(n) - Sky(flipped).mean_inflow(mirrored)).length(), 1e-12);
        }
        // A wall sees half of the sky and half of the ground: 2/pi int sqrt(1 - s^2) L ds, midpoint rule in the angle.
        Vec3d wall(0.0);
        const int count = 4000;
        for (int k = 0; k < count; ++k) {
            const double a = -M_PI / 2 + M_PI * (k + 0.5) / count;
            wall += 2 / M_PI * std::cos(a) * std::cos(a) * M_PI / count *
                    sky.radiance(std::sin(a) * g.up + std::cos(a) * Vec3d(0, 1, 0));
        }
        EXPECT_LT((sky.mean_inflow(Vec3d(0, 1, 0)) - wall).length(), 3e-5);
    }
}

TEST(Sky, RoundTripsThroughMetadata)
{
    GradientSky day = GradientSky::clear_day(Vec3d(3, 4, 5), Vec3d(0, 0, 1));
    day.haze = 2;
    const Sky preetham = preetham_sky(Vec3d(1, 2, 3), Vec3d(3, 4, 5), 3.5, Vec3d(0, 0, 1));
    MetaMap none;
    EXPECT_FALSE(read_sky(none));
    write_sky(none, Sky{});
    EXPECT_FALSE(read_sky(none)) << "a black sky counts as none";
    for (const Sky& sky : {Sky(day), preetham}) {
        MetaMap meta;
        write_sky(meta, sky);
        const auto back = read_sky(meta);
        ASSERT_TRUE(back);
        EXPECT_TRUE(*back == sky);
        for (const Vec3d& w : {Vec3d(0, 0, 1), Vec3d(0.6, 0, 0.8), Vec3d(0, 0.6, -0.8)})
            EXPECT_LT((back->radiance(w) - sky.radiance(w)).length(), 1e-15);
    }
    EXPECT_FALSE(preetham == preetham.above_horizon());
    EXPECT_FALSE(Sky(day) == preetham);
    MetaMap unknown;
    set_text(unknown, schema::lit_sky_kind, "moonlit");
    EXPECT_THROW(read_sky(unknown), InputError);
}

TEST(Sky, RefusesNegativeOrInfiniteValues)
{
    EXPECT_NO_THROW(Sky(GradientSky{}));
    GradientSky sky;
    sky.horizon[1] = -0.1;
    EXPECT_THROW((void)Sky(sky), InputError);
    sky.horizon[1] = std::nan("");
    EXPECT_THROW((void)Sky(sky), InputError);
    sky = {};
    sky.haze = -1;
    EXPECT_THROW((void)Sky(sky), InputError);
    sky = {};
    sky.up = Vec3d(0);
    EXPECT_THROW((void)Sky(sky), InputError);
}

}  // namespace
}  // namespace vdbcloud
