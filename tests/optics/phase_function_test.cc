// Phase functions by quadrature: what they must integrate to, and which way is forward.
#include "vdbcloud/optics/phase_function.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// 2 pi int_-1^1 p(c) f(c) dc by the midpoint rule in theta, c = cos theta. Its error is 2 pi h^2/24 times
/// the change of the integrand's slope, p(1) f(1) + p(-1) f(-1): 4e-5 for the sharpest p here (g = 0.95),
/// below 1e-6 for g = 0.
template<typename F>
double over_sphere(const PhaseFunction& p, F f)
{
    const int n = 2000;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
        const double theta = pi * (k + 0.5) / n;
        sum += p(std::cos(theta)) * f(std::cos(theta)) * std::sin(theta);
    }
    return 2 * pi * sum * pi / n;
}

struct Case {
    PhaseKind kind;
    double g, mean_cosine;
};

class AnyPhaseFunction : public testing::TestWithParam<Case> {};

TEST_P(AnyPhaseFunction, IsNormalisedAndHasItsMeanCosine)
{
    const auto [kind, g, mean_cosine] = GetParam();
    const PhaseFunction p(kind, g);
    EXPECT_NEAR(over_sphere(p, [](double) { return 1.0; }), 1.0, 1e-4);
    EXPECT_NEAR(over_sphere(p, [](double c) { return c; }), mean_cosine, 1e-4);
    EXPECT_DOUBLE_EQ(p.mean_cosine(), mean_cosine);
}

TEST_P(AnyPhaseFunction, HasTheLegendreMomentsItNames)
{
    const auto [kind, g, mean_cosine] = GetParam();
    const PhaseFunction p(kind, g);
    for (unsigned l = 0; l <= 6; ++l)
        EXPECT_NEAR(over_sphere(p, [l](double c) { return std::legendre(l, c); }), p.moment(int(l)), 1e-4)
            << "l = " << l;
}

INSTANTIATE_TEST_SUITE_P(Kinds, AnyPhaseFunction,
                         testing::Values(Case{PhaseKind::Isotropic, 0.5, 0}, Case{PhaseKind::Rayleigh, 0.5, 0},
                                         Case{PhaseKind::HenyeyGreenstein, 0, 0},
                                         Case{PhaseKind::HenyeyGreenstein, 0.85, 0.85},
                                         Case{PhaseKind::HenyeyGreenstein, -0.6, -0.6},
                                         Case{PhaseKind::HenyeyGreenstein, 0.95, 0.95}));

TEST(HenyeyGreenstein, ScattersForwardForPositiveG)
{
    const double g = 0.7;
    const PhaseFunction p(PhaseKind::HenyeyGreenstein, g);
    EXPECT_NEAR(p(1), (1 + g) / (4 * pi * (1 - g) * (1 - g)), 1e-13);
    EXPECT_NEAR(p(-1), (1 - g) / (4 * pi * (1 + g) * (1 + g)), 1e-15);
    EXPECT_GT(p(1), p(-1));
}

TEST(HenyeyGreenstein, KeepsItsDigitsInTheForwardPeak)
{
    // p(1) in closed form; the textbook denominator 1 + g^2 - 2g loses eight digits here.
    const double g = 1 - 1e-8, a = 1 - g;
    EXPECT_NEAR(PhaseFunction(PhaseKind::HenyeyGreenstein, g)(1) * 4 * pi * a * a / (1 + g), 1, 1e-12);
}

TEST(HenyeyGreenstein, AtZeroIsIsotropic)
{
    const PhaseFunction p(PhaseKind::HenyeyGreenstein, 0), q(PhaseKind::Isotropic);
    for (double c = -1; c <= 1; c += 0.25) EXPECT_DOUBLE_EQ(p(c), q(c));
}

TEST(Rayleigh, SendsTwiceAsMuchForwardAsSideways)
{
    const PhaseFunction p(PhaseKind::Rayleigh);
    EXPECT_NEAR(p(1) / p(0), 2, 1e-14);
    EXPECT_DOUBLE_EQ(p(1), p(-1));
}

TEST(PhaseFunction, RefusesAMeanCosineThatCannotBe)
{
    for (const double g : {1.0, -1.0, 1.5, std::nan("")})
        EXPECT_THROW(PhaseFunction(PhaseKind::HenyeyGreenstein, g), InputError) << g;
}

}  // namespace
}  // namespace vdbcloud
