// The share of light that is scattered more than once, against closed forms and an exact slab.
#include "vdbcloud/scatter/expected_share.h"

#include "support/slab_exact.h"
#include "support/voxel_field.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

Medium medium_of(double sigma_t, double albedo, double g)
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(sigma_t);
    medium.albedo = Vec3d(albedo);
    medium.phase = PhaseFunction::henyey_greenstein(g);
    return medium;
}

/// 10 layers of 1 / 10 each, which repeat along x and z. The optical depth is sigma_t whatever the profile.
FloatGridPtr layers()
{
    return test::voxel_field(Vec3i(8, 10, 8), Vec3d(0.1), [](const Vec3i&) { return 1.0; });
}

ShareOptions sharp(bool periodic)
{
    ShareOptions options;
    options.error = 0.002;
    options.most_paths = 20000;
    options.periodic = {periodic, false, periodic};
    return options;
}

// In a sky of radiance 1 and without absorption the radiance is 1 everywhere, and by reciprocity the mean fluence that
// has not collided is 4 pi times the probability P to leave of light that starts anywhere: the share is 1 - P for any
// phase function.
TEST(ExpectedShare, InAFurnaceIsTheCollisionProbability)
{
    for (const double g : {0.0, 0.85})
        for (const double a : {0.2, 1.0, 5.0}) {
            // Case, de Hoffmann & Placzek 1953, section 10: a sphere of optical radius a.
            const double leaves = 3 / (8 * a * a * a) * (2 * a * a - 1 + (1 + 2 * a) * std::exp(-2 * a));
            const double radius = 24;  // the edge is blurred over one voxel
            const FloatGridPtr ball = test::voxel_field(Vec3i(52), Vec3d(1 / radius), [&](const Vec3i& p) {
                const double r = (Vec3d(p.x(), p.y(), p.z()) - Vec3d(25.5)).length();
                return std::clamp(radius - r + 0.5, 0.0, 1.0);
            });
            const ExpectedShare found =
                expected_share(*ball, nullptr, medium_of(a, 1, g), {}, Sky::constant(Vec3d(1)), sharp(false));
            EXPECT_LE(found.error, 0.002);
            EXPECT_NEAR(found.share, 1 - leaves, 4 * 0.002) << "optical radius " << a << ", g " << g;
        }
}

/// The exponential integral E3, by quadrature over the cosine: int_0^1 mu exp(-tau / mu) dmu.
double e3(double tau)
{
    double sum = 0;
    for (int n = 0; n < 20000; ++n) {
        const double mu = (n + 0.5) / 20000;
        sum += mu * std::exp(-tau / mu) / 20000;
    }
    return sum;
}

TEST(ExpectedShare, InALayerThatRepeatsIsExact)
{
    for (const double tau : {0.3, 2.0, 10.0}) {
        const double leaves = (1 - 2 * e3(tau)) / (2 * tau);
        const ExpectedShare found =
            expected_share(*layers(), nullptr, medium_of(tau, 1, 0.5), {}, Sky::constant(Vec3d(0.3)), sharp(true));
        EXPECT_NEAR(found.share, 1 - leaves, 4 * std::max(found.error, 5e-4)) << tau;
    }
}

// Of the sun's power 1 - exp(-tau / mu) collides for the first time. All collisions are the absorbed power over 1 -
// albedo.
TEST(ExpectedShare, UnderASunIsThatOfTheExactSlab)
{
    const double mu = 0.6;
    for (const double tau : {0.2, 1.0, 8.0})
        for (const double albedo : {0.5, 0.9, 0.999})
            for (const double g : {0.0, 0.85}) {
                test::SlabExact::Options o;
                o.tau = tau;
                o.w0 = albedo;
                o.g = g;
                o.mu0 = mu;
                o.n = 32;
                const test::SlabExact slab(o);
                const double direct = std::exp(-tau / mu),
                             absorbed = 1 - direct - (slab.reflected() + slab.transmitted()) / mu,
                             share = 1 - (1 - direct) * (1 - albedo) / absorbed;
                const std::vector<Light> sun{make_sun(Vec3d(0.8, mu, 0), Vec3d(2))};
                const ExpectedShare found =
                    expected_share(*layers(), nullptr, medium_of(tau, albedo, g), sun, Sky(), sharp(true));
                EXPECT_NEAR(found.share, share, 4 * std::max(found.error, 5e-4))
                    << "tau " << tau << ", albedo " << albedo << ", g " << g;
            }
}

TEST(ExpectedShare, TheDefaultErrorHoldsInFewPaths)
{
    for (const double tau : {0.01, 1.0, 100.0}) {
        const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
        const ExpectedShare found = expected_share(*layers(), nullptr, medium_of(tau, 0.9999, 0.85), sun, Sky());
        EXPECT_LE(found.error, 0.005) << tau;
        EXPECT_LE(found.paths, 4096) << tau;
        EXPECT_GE(found.paths, 128) << tau;
    }
}

TEST(ExpectedShare, IsZeroWhereNothingScattersAndTheLargestOfTheChannels)
{
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
    EXPECT_EQ(expected_share(*layers(), nullptr, medium_of(3, 0, 0), sun, Sky()).share, 0);
    EXPECT_EQ(expected_share(*layers(), nullptr, medium_of(3, 0.9, 0), {}, Sky()).share, 0) << "dark";
    EXPECT_EQ(expected_share(*FloatGrid::create(), nullptr, medium_of(3, 0.9, 0), sun, Sky()).share, 0) << "empty";
    Medium red = medium_of(3, 0.2, 0);
    const double grey = expected_share(*layers(), nullptr, red, sun, Sky()).share;
    red.albedo[0] = 0.9;
    EXPECT_GT(expected_share(*layers(), nullptr, red, sun, Sky()).share, 2 * grey);
}

// What decides is on which side of a limit the share is: a thick cloud needs few paths for that, and a thin one all of
// them.
TEST(ExpectedShare, EndsWhereTheShareIsSurelyAboveTheLimit)
{
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
    ShareOptions plain = sharp(true), limited = plain;
    limited.enough = 0.02;
    const ExpectedShare whole = expected_share(*layers(), nullptr, medium_of(3, 0.99, 0), sun, Sky(), plain),
                        early = expected_share(*layers(), nullptr, medium_of(3, 0.99, 0), sun, Sky(), limited);
    EXPECT_LT(early.paths, whole.paths / 4);
    EXPECT_GT(early.share - 4 * early.error, 0.02);
    EXPECT_NEAR(early.share, whole.share, 5 * early.error);
    const Medium thin = medium_of(0.01, 0.9, 0);
    EXPECT_EQ(expected_share(*layers(), nullptr, thin, sun, Sky(), limited).share,
              expected_share(*layers(), nullptr, thin, sun, Sky(), plain).share);
}

}  // namespace
}  // namespace vdbcloud
