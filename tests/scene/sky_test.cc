// Skies: continuity, and the mean in closed form against quadrature.
#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

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
    EXPECT_LT((sky.mean_radiance() - radiance).length(), 1e-15);
}

TEST(Sky, HasItsThreeColoursAndIsContinuousAtTheHorizon)
{
    Sky sky = Sky::clear_day(Vec3d(3, 3, 3), Vec3d(0, 0, 2));
    EXPECT_LT((sky.radiance(Vec3d(0, 0, 1)) - sky.zenith).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 0, -1)) - sky.ground).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 1, 0)) - sky.horizon).length(), 1e-15);
    const double e = 1e-7, level = std::sqrt(1 - e * e);
    EXPECT_LT((sky.radiance(Vec3d(level, 0, e)) - sky.radiance(Vec3d(level, 0, -e))).length(), 1e-5);
    EXPECT_GT(sky.zenith[2], 2 * sky.zenith[0]);  // blue
}

TEST(Sky, MeanRadianceIsTheIntegralOverTheSphere)
{
    for (const double haze : {0.0, 1.0, 3.5, 8.0}) {
        Sky sky;
        sky.zenith = Vec3d(0.1, 0.3, 0.9);
        sky.horizon = Vec3d(0.8, 0.7, 0.6);
        sky.ground = Vec3d(0.2, 0.1, 0.05);
        sky.haze = haze;
        sky.up = Vec3d(0.6, 0, 0.8);
        // Uniform in s is uniform on the sphere; the midpoint rule's error is below haze / (12 n^2).
        const Vec3d aside(-0.8, 0, 0.6);
        const int n = 1000;
        Vec3d sum(0, 0, 0);
        for (int k = 0; k < n; ++k) {
            const double s = -1 + 2 * (k + 0.5) / n;
            sum += sky.radiance(s * sky.up + std::sqrt(1 - s * s) * aside) / n;
        }
        EXPECT_LT((sum - sky.mean_radiance()).length(), 1e-5) << haze;
    }
}

TEST(Sky, MeanInflowIsTheIntegralOverTheHalfSphere)
{
    Sky sky;
    sky.zenith = Vec3d(0.1, 0.4, 1);
    sky.horizon = Vec3d(2, 1, 0.5);
    sky.ground = Vec3d(0.3, 0, 0.05);
    sky.up = Vec3d(0.6, 0, 0.8);
    for (double haze : {0.0, 1.0, 2.5, 4.0}) {
        sky.haze = haze;
        // int_0^1 s (1 - s)^haze ds = 1 / ((haze + 1)(haze + 2))
        const double share = 2 / ((haze + 1) * (haze + 2));
        EXPECT_LT((sky.mean_inflow(sky.up) - (sky.zenith + (sky.horizon - sky.zenith) * share)).length(), 3e-5);
        EXPECT_LT((sky.mean_inflow(-sky.up) - (sky.ground + (sky.horizon - sky.ground) * share)).length(), 3e-5);
        const Vec3d net = (sky.zenith - sky.ground) * (1 - share);  // int w L dw = pi net up: for any normal
        for (const Vec3d& n : {Vec3d(0, 1, 0), Vec3d(1, 0, 0), Vec3d(0, 0.6, -0.8), Vec3d(0.36, 0.48, 0.8)}) {
            EXPECT_LT((sky.mean_inflow(n) - sky.mean_inflow(-n) - n.dot(sky.up) * net).length(), 3e-5);
            // A surface and its mirror image across the horizon together receive from both halves of the sky.
            const Vec3d mirrored = n - 2 * n.dot(sky.up) * sky.up;
            Sky flipped = sky;
            std::swap(flipped.zenith, flipped.ground);
            EXPECT_LT((sky.mean_inflow(n) - flipped.mean_inflow(mirrored)).length(), 1e-12);
        }
        // A wall sees half of the sky and half of the ground: 2/pi int sqrt(1 - s^2) L ds, midpoint rule in the angle.
        Vec3d wall(0.0);
        const int count = 4000;
        for (int k = 0; k < count; ++k) {
            const double a = -M_PI / 2 + M_PI * (k + 0.5) / count;
            wall += 2 / M_PI * std::cos(a) * std::cos(a) * M_PI / count *
                    sky.radiance(std::sin(a) * sky.up + std::cos(a) * Vec3d(0, 1, 0));
        }
        EXPECT_LT((sky.mean_inflow(Vec3d(0, 1, 0)) - wall).length(), 3e-5);
    }
    for (const Vec3d& n : {Vec3d(0, 1, 0), Vec3d(0.36, 0.48, 0.8)})
        EXPECT_LT((Sky::constant(Vec3d(0.7)).mean_inflow(n) - Vec3d(0.7)).length(), 1e-14);
}

TEST(Sky, RoundTripsThroughMetadata)
{
    Sky sky = Sky::clear_day(Vec3d(3, 4, 5), Vec3d(0, 0, 1));
    sky.haze = 2;
    MetaMap meta;
    EXPECT_FALSE(read_sky(meta));
    write_sky(meta, Sky{});
    EXPECT_FALSE(read_sky(meta)) << "a black sky counts as none";
    write_sky(meta, sky);
    const auto back = read_sky(meta);
    ASSERT_TRUE(back);
    for (const Vec3d& w : {Vec3d(0, 0, 1), Vec3d(0.6, 0, 0.8), Vec3d(0, 0.6, -0.8)})
        EXPECT_LT((back->radiance(w) - sky.radiance(w)).length(), 1e-15);
}

TEST(Sky, RefusesNegativeOrInfiniteValues)
{
    check(Sky{});
    Sky sky;
    sky.horizon[1] = -0.1;
    EXPECT_THROW(check(sky), InputError);
    sky.horizon[1] = std::nan("");
    EXPECT_THROW(check(sky), InputError);
    sky = Sky{};
    sky.haze = -1;
    EXPECT_THROW(check(sky), InputError);
}

}  // namespace
}  // namespace vdbcloud
