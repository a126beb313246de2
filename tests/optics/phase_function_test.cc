// Every phase function of the table by quadrature and by samples: norm, moments, sampler, forward direction.
#include "vdbcloud/optics/phase_function.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbcloud {
namespace {

/// 2 pi int_-1^1 p(c) f(c) dc by the midpoint rule in theta, c = cos theta. Its error is 2 pi h^2 / 24 times the change
/// of the slope of p f sin, below 4e-6 for the sharpest lobe here: droplets of 50 micrometres, p(0) = 2e4, h = pi /
/// 2e5.
template<typename F>
double over_sphere(const PhaseFunction& p, F f)
{
    const int n = 200000;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
        const double theta = pi * (k + 0.5) / n, c = std::cos(theta);
        sum += p(c) * f(c) * std::sin(theta);
    }
    return 2 * pi * sum * pi / n;
}

PhaseFunction hg(double g) { return PhaseFunction::henyey_greenstein(g); }

/// Add each new row of the table here; EveryRowOfTheTableIsTested fails otherwise.
std::vector<PhaseFunction> cases()
{
    return {PhaseFunction("isotropic"),
            PhaseFunction("rayleigh"),
            hg(0),
            hg(0.85),
            hg(-0.6),
            hg(0.97),
            PhaseFunction("double-henyey-greenstein", {0.9, -0.4, 0.8}),
            PhaseFunction("double-henyey-greenstein", {0.1, 0.7, 1}),
            PhaseFunction("hg-draine", {5}),
            PhaseFunction("hg-draine", {20}),
            PhaseFunction("hg-draine", {50})};
}

TEST(PhaseTable, EveryRowOfTheTableIsTested)
{
    std::set<std::string> tested;
    for (const PhaseFunction& p : cases()) tested.insert(p.name());
    for (const PhaseForm& form : phase_table()) EXPECT_TRUE(tested.count(form.name)) << form.name;
}

TEST(PhaseTable, WordsAndParametersAreDistinct)
{
    std::set<std::string> names, parameters;
    for (const PhaseForm& form : phase_table()) {
        EXPECT_TRUE(names.insert(form.name).second) << form.name;
        EXPECT_EQ(&phase_form(form.name), &form);
        for (const PhaseParameter& p : form.parameters) EXPECT_TRUE(parameters.insert(p.name).second) << p.name;
    }
}

class AnyPhaseFunction : public testing::TestWithParam<PhaseFunction> {};

TEST_P(AnyPhaseFunction, IntegratesToOne)
{
    EXPECT_NEAR(over_sphere(GetParam(), [](double) { return 1.0; }), 1.0, 1e-5);
}

TEST_P(AnyPhaseFunction, MomentsAreItsIntegralsAgainstLegendrePolynomials)
{
    const PhaseFunction& p = GetParam();
    for (unsigned l : {0u, 1u, 2u, 3u, 4u, 5u, 8u, 13u})
        EXPECT_NEAR(over_sphere(p, [l](double c) { return std::legendre(l, c); }), p.moment(int(l)), 1e-5)
            << p.text() << " l = " << l;
    EXPECT_EQ(p.mean_cosine(), p.moment(1));
}

TEST_P(AnyPhaseFunction, EqualsItsLegendreSeries)
{
    // Up to the degree above which moments are below 1e-12 (degree_below()).
    const PhaseFunction& p = GetParam();
    const int last = p.degree_below(1e-12);
    for (double c : {-1.0, -0.3, 0.0, 0.6, 0.95}) {
        double sum = 0, before = 0, legendre = 1;
        for (int l = 0; l <= last; ++l) {
            sum += (2 * l + 1) * p.moment(l) * legendre;
            const double next = ((2 * l + 1) * c * legendre - l * before) / (l + 1);
            before = legendre;
            legendre = next;
        }
        EXPECT_NEAR(sum / (4 * pi), p(c), 1e-8 + 1e-7 * p(c)) << p.text() << " cosine " << c;
    }
    EXPECT_LT(std::abs(p.moment(last)), 1e-12);
}

/// Sum of (found - expected)^2 / expected.
double chi_square(const std::vector<int>& found, double expected)
{
    double sum = 0;
    for (int n : found) sum += (n - expected) * (n - expected) / expected;
    return sum;
}

TEST_P(AnyPhaseFunction, SamplesHaveItsDensity)
{
    // Bins of equal probability by quadrature of the value, in the angle to the incoming direction and in azimuth.
    const PhaseFunction& p = GetParam();
    const int bins = 60, azimuths = 4, n = 400000, steps = 200000;
    std::vector<double> edge, below{0};
    for (int k = 0; k < steps; ++k) {
        const double theta = pi * (k + 0.5) / steps;
        below.push_back(below.back() + 2 * pi * p(std::cos(theta)) * std::sin(theta) * pi / steps);
    }
    for (int b = 1, k = 0; b < bins; ++b) {
        while (below[size_t(k) + 1] < below.back() * b / bins) ++k;
        const double part = (below.back() * b / bins - below[size_t(k)]) / (below[size_t(k) + 1] - below[size_t(k)]);
        edge.push_back(pi * (k + part) / steps);
    }
    const Vec3d in = Vec3d(0.3, -0.8, 0.52).unit(), x = in.cross(Vec3d(0.2, 0.1, 1)).unit(), y = in.cross(x);
    std::vector<int> found(size_t(bins) * azimuths);
    for (int k = 0; k < n; ++k) {
        const Vec3d out = p.sample(in, uniform(hash_bits(5, uint64_t(k))), uniform(hash_bits(6, uint64_t(k))));
        ASSERT_NEAR(out.length(), 1, 1e-12);
        const double theta = std::atan2(out.cross(in).length(), out.dot(in));
        const auto bin = std::upper_bound(edge.begin(), edge.end(), theta) - edge.begin();
        const int azimuth = int(std::floor((std::atan2(out.dot(y), out.dot(x)) + pi) / (2 * pi) * azimuths));
        ++found[size_t(bin) * azimuths + size_t(std::min(azimuth, azimuths - 1))];
    }
    // Chi-square of 239 degrees of freedom: mean 239, deviation 21.9; five deviations on either side.
    EXPECT_NEAR(chi_square(found, double(n) / (bins * azimuths)), 239, 5 * 21.9) << p.text();
}

TEST_P(AnyPhaseFunction, SamplesReachBothEndsOfTheSphere)
{
    const PhaseFunction& p = GetParam();
    const Vec3d in(0, 0, 1);
    for (double u : {0.0, 1e-300, 0.5, 1 - 1e-16})
        for (double v : {0.0, 0.25, 1 - 1e-16}) EXPECT_NEAR(p.sample(in, u, v).length(), 1, 1e-12) << u << ' ' << v;
    EXPECT_NEAR(p.sample(in, 0, 0.3)[2], -1, 1e-9);
    EXPECT_NEAR(p.sample(in, 1 - 1e-16, 0.3)[2], 1, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Table, AnyPhaseFunction, testing::ValuesIn(cases()));

TEST(PhaseLobe, SamplerInvertsTheCumulativeDistributionAtEveryG)
{
    // int_-1^cos of the lobe by the midpoint rule in t (a substitution that makes it flat) is u: also at small g, where
    // closed forms cancel.
    for (double g : {-0.9, -0.2, -1e-3, 0.0, 1e-9, 0.05, 0.199, 0.201, 0.6, 0.95})
        for (double alpha : {0.0, 1.0, 30.0})
            for (double u : {0.01, 0.3, 0.5, 0.9, 0.999}) {
                const PhaseLobe lobe{1, g, alpha};
                const double c = lobe.sample(u);
                const int n = 20000;
                double sum = 0;
                for (int k = 0; k < n; ++k) {
                    const double theta = std::acos(c) + (pi - std::acos(c)) * (k + 0.5) / n;
                    sum += 2 * pi * lobe.value(std::cos(theta)) * std::sin(theta) * (pi - std::acos(c)) / n;
                }
                EXPECT_NEAR(sum, u, 1e-5) << g << ' ' << alpha << ' ' << u;
            }
}

TEST(HenyeyGreenstein, ScattersForwardForPositiveG)
{
    const double g = 0.7;
    EXPECT_NEAR(hg(g)(1), (1 + g) / (4 * pi * (1 - g) * (1 - g)), 1e-13);
    EXPECT_NEAR(hg(g)(-1), (1 - g) / (4 * pi * (1 + g) * (1 + g)), 1e-15);
    EXPECT_GT(hg(g)(1), hg(g)(-1));
}

TEST(HenyeyGreenstein, ForwardPeakHasFullPrecision)
{
    // p(1) in closed form; the textbook denominator 1 + g^2 - 2g loses eight digits here.
    const double g = 1 - 1e-8, a = 1 - g;
    EXPECT_NEAR(hg(g)(1) * 4 * pi * a * a / (1 + g), 1, 1e-12);
}

TEST(HenyeyGreenstein, MomentsArePowersOfG)
{
    for (int l = 0; l < 20; ++l) EXPECT_EQ(hg(0.85).moment(l), std::pow(0.85, l));
}

TEST(HenyeyGreenstein, AtZeroIsIsotropic)
{
    for (double c = -1; c <= 1; c += 0.25) EXPECT_EQ(hg(0)(c), PhaseFunction()(c));
    EXPECT_DOUBLE_EQ(PhaseFunction()(0.4), 1 / (4 * pi));
}

TEST(Rayleigh, MatchesTheClosedFormAndSecondMomentOfOneTenth)
{
    const PhaseFunction p("rayleigh");
    for (double c : {-1.0, -0.2, 0.0, 0.7, 1.0}) EXPECT_NEAR(p(c), 3 / (16 * pi) * (1 + c * c), 1e-16);
    for (int l = 1; l < 8; ++l) EXPECT_NEAR(p.moment(l), l == 2 ? 0.1 : 0, 1e-16);
}

TEST(DoubleHenyeyGreenstein, IsTheWeightedSumOfItsLobes)
{
    const PhaseFunction p("double-henyey-greenstein", {0.9, -0.4, 0.8});
    for (double c : {-1.0, 0.1, 0.8}) EXPECT_NEAR(p(c), 0.8 * hg(0.9)(c) + 0.2 * hg(-0.4)(c), 1e-15);
    for (int l = 1; l < 6; ++l) EXPECT_NEAR(p.moment(l), 0.8 * std::pow(0.9, l) + 0.2 * std::pow(-0.4, l), 1e-15);
}

TEST(HgDraine, MatchesJendersieAndDEonAtTwentyMicrometres)
{
    // exp(-0.0990567 / 18.32846), exp(-2.20679 / 23.91029 - 0.428934), exp(3.62489 - 8.29288 / 25.52825),
    // exp(-0.599085 / 19.358417 - 0.665888), evaluated apart.
    const double g_hg = 0.99461005, g_d = 0.59379058, alpha = 27.113694, w = 0.4981595;
    const auto draine = [&](double c) {
        return (1 - g_d * g_d) / (4 * pi * std::pow(1 + g_d * g_d - 2 * g_d * c, 1.5)) * (1 + alpha * c * c) /
               (1 + alpha * (1 + 2 * g_d * g_d) / 3);
    };
    for (double c : {-1.0, -0.4, 0.0, 0.5, 0.9})
        EXPECT_NEAR(PhaseFunction("hg-draine", {20})(c) / ((1 - w) * hg(g_hg)(c) + w * draine(c)), 1, 1e-4) << c;
}

TEST(HgDraine, MeanCosineMatchesWaterDroplets)
{
    // Mie theory gives 0.84 to 0.89 in visible light for droplets of 5 to 50 micrometres, rising with the diameter.
    double before = 0.83;
    for (double d : {5.0, 10.0, 20.0, 50.0}) {
        const double g = PhaseFunction("hg-draine", {d}).mean_cosine();
        EXPECT_GT(g, before) << d;
        before = g;
    }
    EXPECT_LT(before, 0.9);
}

TEST(PhaseFunction, RefusesInvalidParameters)
{
    for (const double g : {1.0, -1.0, 1.5, std::nan("")}) EXPECT_THROW(hg(g), InputError) << g;
    EXPECT_THROW(PhaseFunction("mie"), InputError);
    EXPECT_THROW(PhaseFunction("rayleigh", {0.5}), InputError);
    EXPECT_THROW(PhaseFunction("hg-draine"), InputError);
    EXPECT_THROW(PhaseFunction("hg-draine", {4.9}), InputError);
    EXPECT_THROW(PhaseFunction("hg-draine", {50.1}), InputError);
    EXPECT_THROW(PhaseFunction("double-henyey-greenstein", {0.5, 0.1}), InputError);
    EXPECT_THROW(PhaseFunction("double-henyey-greenstein", {0.5, 0.1, 1.1}), InputError);
    EXPECT_THROW(PhaseFunction("double-henyey-greenstein", {0.5, 1, 0.5}), InputError);
}

TEST(PhaseFunction, EqualityComparesFormAndParameters)
{
    EXPECT_EQ(hg(0.5), hg(0.5 * (1 + 1e-12)));
    EXPECT_NE(hg(0.5), hg(0.5001));
    EXPECT_NE(hg(0), PhaseFunction("isotropic"));
    EXPECT_EQ(hg(0.5).text(), "henyey-greenstein, g 0.5");
}

}  // namespace
}  // namespace vdbcloud
