// The slab solution that others are tested against, held to published numbers and to limits in closed form.
#include "vdbcloud/core/constants.h"

#include "support/slab_exact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

/// H(mu) of conservative isotropic scattering, by iterating 1/H = int_0^1 mu' H(mu') / (2 (mu + mu')) dmu' (w0 = 1).
double h_function(double mu)
{
    constexpr int n = 500;
    static const std::vector<double> h = [] {
        std::vector<double> value(n, 1.0);
        for (int pass = 0; pass < 100; ++pass) {
            std::vector<double> next(n);
            for (int i = 0; i < n; ++i) {
                double sum = 0;
                for (int j = 0; j < n; ++j) sum += (j + 0.5) * value[j] / ((i + 0.5) + (j + 0.5)) / n;
                next[i] = 0.5 * (value[i] + 2 / sum);
            }
            value = next;
        }
        return value;
    }();
    double sum = 0;
    for (int j = 0; j < n; ++j) {
        const double x = (j + 0.5) / n;
        sum += x * h[j] / (mu + x) / n;
    }
    return 2 / sum;
}

TEST(SlabExact, AgreesWithVanDeHulstsHenyeyGreensteinSlab)
{
    // van de Hulst 1980, vol. 2, table 35 (g = 0.75, albedo 0.9, tau 2, normal incidence): total reflectance 0.09739,
    // total transmittance 0.66096. Taken from those who quote the table, Wang, Jacques & Zheng 1995
    // (doi 10.1016/0169-2607(95)01640-F) and Monte Carlo programs checked against them; the book was not at hand.
    SlabExact slab({2.0, 0.9, 0.75, 1.0, {}, 24});
    EXPECT_NEAR(slab.reflected(), 0.09739, 1e-5);
    EXPECT_NEAR(slab.transmitted() + std::exp(-2.0), 0.66096, 1e-5);
}

TEST(SlabExact, OfGreatDepthHasTheHFunctionsRadianceAndMilnesExtrapolation)
{
    // Chandrasekhar 1960: I(mu) = (1 / 4 pi) mu0 / (mu + mu0) H(mu) H(mu0) for irradiance 1. H solves its own equation
    // here; its first moment is 2 / sqrt(3) in closed form, and his table ends with H(1) = 2.9078.
    double moment = 0;
    for (int i = 0; i < 200; ++i) moment += (i + 0.5) / 200 * h_function((i + 0.5) / 200) / 200;
    EXPECT_NEAR(moment, 2 / std::sqrt(3.0), 1e-3);
    EXPECT_NEAR(h_function(1), 2.9078, 2e-3);
    const double tau = 3e4;  // transmits 4e-5
    SlabExact slab({tau, 1, 0, 0.6, {0.2, 1.0}, 24});
    EXPECT_NEAR(slab.emergent_top(0) / (0.6 / 0.8 * h_function(0.2) * h_function(0.6) / (4 * pi)), 1, 2e-3);
    EXPECT_NEAR(slab.emergent_top(1) / (0.6 / 1.6 * h_function(1.0) * h_function(0.6) / (4 * pi)), 1, 2e-3);
    // T of isotropic inflow = (4/3) / (tau + 2 q), q = 0.7104461 (Hopf).
    SlabExact thick({64, 1, 0, 1, {}, 24});
    EXPECT_NEAR(4.0 / 3 / thick.transmitted_of_isotropic() - 64, 2 * 0.710446, 1e-4);
}

TEST(SlabExact, ConservesEnergyAndIsContinuousInside)
{
    for (double g : {0.0, 0.85})
        for (double tau : {0.1, 1.0, 16.0}) {
            SlabExact slab({tau, 1, g, 0.7, {}, 24});
            EXPECT_NEAR(slab.reflected() + slab.transmitted() + 0.7 * std::exp(-tau / 0.7), 0.7, 1e-6)
                << tau << ' ' << g;
            for (double part : {0.25, 0.5}) {
                const auto in = slab.at(part * tau);  // net flux of everything is the same at all depths
                EXPECT_NEAR(in.flux + 0.7 * std::exp(-part * tau / 0.7), 0.7 - slab.reflected(), 1e-6);
            }
            EXPECT_NEAR(slab.at(1e-7 * tau).phi / slab.at(0).phi, 1, 1e-3);
        }
}

TEST(SlabExact, OfThinSlabsScattersOnce)
{
    SlabExact slab({1e-4, 0.8, 0, 0.5, {0.5}, 24});
    const double expected = 0.8 / (4 * pi) * 1e-4 / 0.5;  // w0 p tau / mu
    EXPECT_NEAR(slab.emergent_top(0) / expected, 1, 1e-3);
    EXPECT_NEAR(slab.emergent_bottom(0) / expected, 1, 1e-3);
}

}  // namespace
}  // namespace vdbcloud::test
