// Light of hot matter against Planck's law, the published chromaticities of black bodies, and the old candela.
#include "vdbcloud/scene/blackbody.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scene/atmosphere.h"
#include "vdbcloud/scene/colour.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// The integral of f over wavelengths [nm], in steps of one hundredth of an e-fold; its rest is below 1e-9 for Planck's
/// law.
template<typename F>
double over_spectrum(double from, double to, const F& f)
{
    const int n = 2 * int(std::ceil(50 * std::log(to / from)));
    const double h = std::log(to / from) / n;
    double sum = 0;
    for (int k = 0; k <= n; ++k) {
        const double wavelength = from * std::exp(h * k);
        sum += (k == 0 || k == n ? 1 : k % 2 ? 4 : 2) * wavelength * f(wavelength);
    }
    return sum * h / 3;
}

TEST(Blackbody, PowerIsThatOfStefanAndBoltzmann)
{
    constexpr double sigma = 5.670374419e-8;  // [W m^-2 K^-4], CODATA 2018
    for (const double t : {300.0, 1500.0, 5772.0, 1e5}) {
        const double total = over_spectrum(2e5 / t, 1e10 / t, [&](double l) { return planck(l, t); });
        EXPECT_NEAR(total * pi / (sigma * std::pow(t, 4)), 1, 2e-6) << t;  // 1e-6 lies beyond the ends
    }
    // Wien: b = 2897771.955 nm K. A parabola through three points of 1 nm errs by 1e-4 nm.
    const double t = 3000, peak = 2897771.955 / t;
    const double below = planck(peak - 1, t), at = planck(peak, t), above = planck(peak + 1, t);
    EXPECT_NEAR(0.5 * (below - above) / (below - 2 * at + above), 0, 2e-3);
}

TEST(Blackbody, ChromaticitiesAreThePublishedOnes)
{
    // Wyszecki & Stiles, Color Science, 2nd ed. 1982, Planckian radiators. They have c2 = 14388 um K, ours 14387.77.
    const double published[][3] = {{1500, 0.5857, 0.3931}, {3000, 0.4369, 0.4041}, {6500, 0.3135, 0.3237}};
    for (const auto& [t, x, y] : published) {
        const Vec3d v = blackbody_xyz(t);
        EXPECT_NEAR(v[0] / (v[0] + v[1] + v[2]), x, 2e-4) << t;
        EXPECT_NEAR(v[1] / (v[0] + v[1] + v[2]), y, 2e-4) << t;
    }
    // Within the gamut the colour is that of X, Y, Z; without, the luminance.
    const auto colour = [](double t) { return blackbody(t) / luminance(blackbody(t)); };
    const Vec3d inside = rec709_of_xyz(blackbody_xyz(3000) / blackbody_xyz(3000)[1]);
    EXPECT_LT((colour(3000) - inside).length(), 1e-6);
    EXPECT_GT(colour(3000)[2], 0);
    EXPECT_EQ(colour(1500)[2], 0);
    EXPECT_NEAR(luminance(colour(1500)), 1, 1e-9);
    EXPECT_GT(colour(1500)[0], colour(1500)[1]);
    EXPECT_GT(colour(10000)[2], colour(10000)[0]);
}

TEST(Blackbody, LuminanceIsPlancksIntegral)
{
    // The fit of Wyman, Sloan, Shirley 2013 to the eye, which errs by 0.5 % of these integrals.
    const auto eye = [](double l) {
        const auto lobe = [l](double m, double b, double a) {
            return std::exp(-0.5 * std::pow((l - m) / (l < m ? b : a), 2));
        };
        return 0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1);
    };
    const auto integral = [&](double t) {
        return over_spectrum(380, 780, [&](double l) { return planck(l, t) * eye(l); });
    };
    for (const double t : {1500.0, 2000.0, 3000.0, 6500.0})
        EXPECT_NEAR(luminance(blackbody(t)) / luminance(blackbody(2500)), integral(t) / integral(2500),
                    0.005 * integral(t) / integral(2500))
            << t;
    // Freezing platinum, 2041.4 K, has 60 cd/cm^2: the candela of 1948.
    EXPECT_NEAR(luminance(blackbody(2041.4)) * unit_of_light(), 600, 6);
}

TEST(Blackbody, TableIsTheSum)
{
    const BlackbodyTable table(4000);
    for (double t = 500; t < 9000; t *= 1.0137) {
        const Vec3d exact = blackbody(t), found = table(t);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], exact[c], 1e-5 * exact[0]) << t << " channel " << c;
    }
}

TEST(Blackbody, OddTemperatures)
{
    const BlackbodyTable table(1e9);
    for (const double t : {0.0, -1.0, -1e9, 1e-300, 499.0, std::nan("")}) {
        EXPECT_EQ(blackbody(t), Vec3d(0.0)) << t;
        EXPECT_EQ(table(t), Vec3d(0.0)) << t;
    }
    EXPECT_GT(luminance(blackbody(coldest_light)), 0);
    EXPECT_LT(luminance(blackbody(coldest_light)), 1e-11);
    // Rayleigh and Jeans: in proportion to T, to h c / (2 lambda k T) = 1.3e-5 of it.
    EXPECT_NEAR(luminance(table(2e9)) / luminance(table(1e9)), 2, 5e-5);
    EXPECT_TRUE(std::isfinite(luminance(table(1e30))));
}

}  // namespace
}  // namespace vdbcloud
