// Light scattered again within the forward peak, against a sum over orders of scattering in closed form.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/render/forward_peak.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// 4 pi times Henyey-Greenstein.
double lobe(double g, double c) { return (1 - g * g) / std::pow(1 + g * g - 2 * g * c, 1.5); }

/// R by orders: off the forward direction the sum over all l of (2l+1) P_l e^(x g^l) is sum over n >= 1 of x^n / n!
/// lobe(g^n), as a lobe convolved with itself has g^2; what degrees up to L have of it is taken off.
double by_orders(double g, int degree, double c, double x)
{
    const double f = std::pow(g, degree + 1);
    double sum = 0, factor = std::exp(-x * f);
    for (int n = 1; n < 300; ++n) {
        factor *= x / n;
        sum += factor * lobe(std::pow(g, n), c);
    }
    sum -= x * lobe(g, c);
    double before = 0, legendre = 1;
    for (int l = 0; l <= degree; ++l) {
        const double u = x * (std::pow(g, l) - f);
        sum -= (2 * l + 1) * legendre * (std::exp(u) - 1 - u);
        const double next = ((2 * l + 1) * c * legendre - l * before) / (l + 1);
        before = legendre;
        legendre = next;
    }
    return 1 + sum / (x * lobe(g, c));
}

ForwardPeak peak_of(const PhaseFunction& phase, int degree) { return ForwardPeak(phase, delta_scaling(phase, degree)); }

TEST(ForwardPeak, IsTheSumOverOrdersOfScattering)
{
    for (double g : {0.5, 0.85, 0.99, 0.999, 0.9999, 0.999999, 1 - 1e-9})
        for (int degree : {1, 3, 7}) {
            const ForwardPeak peak = peak_of(PhaseFunction::henyey_greenstein(g), degree);
            for (double degrees : {1.0, 7.0, 20.0, 33.0, 44.0})
                for (double x : {0.1, 1.0, 5.0, 15.0}) {
                    const double c = std::cos(degrees * pi / 180), expected = by_orders(g, degree, c, x);
                    // Bilinear between 96 angles and 64 depths.
                    EXPECT_NEAR(peak(c, x), expected, 0.004) << g << ' ' << degree << ' ' << degrees << ' ' << x;
                }
        }
    EXPECT_NEAR(peak_of(PhaseFunction::henyey_greenstein(0.85), 1)(std::cos(20 * pi / 180), 8), 0.312, 0.003);
}

TEST(ForwardPeak, IsTheSumOverOrdersCloseToTheSun)
{
    // The table's first angle beyond 0 is 0.008 degrees, the second 0.033.
    for (const auto& [g, tolerance] : {std::pair(0.99, 5e-4), {0.999, 8e-3}, {0.9999, 0.02}})
        for (double degrees : {0.0, 0.01, 0.03, 0.1, 0.3})
            for (double x : {0.3, 3.0, 15.0}) {
                const double c = std::cos(degrees * pi / 180), expected = by_orders(g, 3, c, x);
                EXPECT_NEAR(peak_of(PhaseFunction::henyey_greenstein(g), 3)(c, x), expected, tolerance)
                    << g << ' ' << degrees << ' ' << x;
            }
}

TEST(ForwardPeak, IsOneWhereNothingScattersAgainAndFarFromTheSun)
{
    const ForwardPeak peak = peak_of(PhaseFunction::henyey_greenstein(0.85), 1);
    EXPECT_NEAR(peak(0.9, 0), 1, 1e-6);
    for (double c : {0.25, 0.0, -1.0}) EXPECT_EQ(peak(c, 10), 1);
    EXPECT_EQ(peak(0.95, 64), peak(0.95, 1e6));
    EXPECT_GE(peak(1, 50), 0);
}

}  // namespace
}  // namespace vdbcloud
