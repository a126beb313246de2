// Skies: continuity, and the mean in closed form against quadrature.
#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(Sky, ConstantIsTheSameEverywhere)
{
    const Vec3d radiance(0.1, 0.2, 0.7);
    const Sky sky = Sky::constant(radiance);
    for (const Vec3d& w : {Vec3d(0, 1, 0), Vec3d(0, -1, 0), Vec3d(0.6, 0, 0.8), Vec3d(0, 0.6, -0.8)})
        EXPECT_LT((sky.radiance(w) - radiance).length(), 1e-15);
    EXPECT_LT((sky.mean_radiance() - radiance).length(), 1e-15);
}

TEST(Sky, HasItsColoursWhereItSaysAndNoJumpAtTheHorizon)
{
    Sky sky = Sky::clear_day(Vec3d(3, 3, 3), Vec3d(0, 0, 2));
    EXPECT_LT((sky.radiance(Vec3d(0, 0, 1)) - sky.zenith).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 0, -1)) - sky.ground).length(), 1e-15);
    EXPECT_LT((sky.radiance(Vec3d(0, 1, 0)) - sky.horizon).length(), 1e-15);
    const double e = 1e-7, level = std::sqrt(1 - e * e);
    EXPECT_LT((sky.radiance(Vec3d(level, 0, e)) - sky.radiance(Vec3d(level, 0, -e))).length(), 1e-5);
    EXPECT_GT(sky.zenith[2], 2 * sky.zenith[0]);  // blue
}

TEST(Sky, MeanIsItsIntegralOverTheSphere)
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

TEST(Sky, RefusesColoursBelowNothing)
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
