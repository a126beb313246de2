// The harmonics' matrices against quadrature that integrates them exactly: Gauss-Legendre in z, uniform in azimuth.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/harmonics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud {
namespace {

/// Calls f(s, weight) for a rule that is exact for polynomials up to 2n-1 in s.
void sphere_rule(int n, const std::function<void(const Vec3d&, double)>& f)
{
    for (int i = 0; i < n; ++i) {
        double x = std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int newton = 0; newton < 50; ++newton) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1);
            x -= p1 / slope;
        }
        const double weight = 2 / ((1 - x * x) * slope * slope), r = std::sqrt(1 - x * x);
        for (int j = 0; j < 2 * n; ++j) {
            const double phi = pi * (j + 0.25) / n;
            f(Vec3d(r * std::cos(phi), r * std::sin(phi), x), weight * pi / n);
        }
    }
}

TEST(Harmonics, AreOrthonormal)
{
    const int degree = 6, n = harmonic_count(degree);
    std::vector<double> gram(n * n, 0.0), y(n);
    sphere_rule(degree + 1, [&](const Vec3d& s, double w) {
        evaluate_harmonics(degree, s, y.data());
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) gram[i * n + j] += w * y[i] * y[j];
    });
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) EXPECT_NEAR(gram[i * n + j], i == j, 1e-12) << i << ' ' << j;
}

TEST(Harmonics, DegreeOneIsProportionalToTheDirection)
{
    double y[4];
    const Vec3d s = Vec3d(0.3, -0.5, 0.2).unit();
    evaluate_harmonics(1, s, y);
    EXPECT_NEAR(y[0], std::sqrt(1 / (4 * pi)), 1e-15);
    EXPECT_NEAR(y[harmonic(1, 1)], std::sqrt(3 / (4 * pi)) * s.x(), 1e-15);
    EXPECT_NEAR(y[harmonic(1, -1)], std::sqrt(3 / (4 * pi)) * s.y(), 1e-15);
    EXPECT_NEAR(y[harmonic(1, 0)], std::sqrt(3 / (4 * pi)) * s.z(), 1e-15);
}

class Coupling : public testing::TestWithParam<int> {};

TEST_P(Coupling, MatchesQuadratureAndIsSymmetric)
{
    const int axis = GetParam(), degree = 6, n = harmonic_count(degree);
    const auto matrix = direction_coupling(degree, axis);
    std::vector<double> integral(n * n, 0.0), y(n);
    sphere_rule(degree + 2, [&](const Vec3d& s, double w) {
        evaluate_harmonics(degree, s, y.data());
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) integral[i * n + j] += w * y[i] * s[axis] * y[j];
    });
    double largest = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            EXPECT_NEAR(matrix[i * n + j], integral[i * n + j], 1e-12) << i << ' ' << j;
            EXPECT_DOUBLE_EQ(matrix[i * n + j], matrix[j * n + i]);
            largest = std::max(largest, std::abs(matrix[i * n + j]));
        }
    EXPECT_GT(largest, 0.5);
}

INSTANTIATE_TEST_SUITE_P(XYZ, Coupling, testing::Values(0, 1, 2));

TEST(Coupling, DegreeOneEntryIsOneOverRootThreeOnEveryAxis)
{
    const int of_axis[3] = {harmonic(1, 1), harmonic(1, -1), harmonic(1, 0)};
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(direction_coupling(1, axis)[of_axis[axis]], 1 / std::sqrt(3.0), 1e-15);
}

TEST(P1Closure, CoefficientsAreOneAndOneThird)
{
    EXPECT_NEAR(p1_closure().divergence, 1.0, 1e-15);
    EXPECT_NEAR(p1_closure().gradient, 1.0 / 3, 1e-15);
}

TEST(Harmonics, AreEigenfunctionsOfHenyeyGreensteinScattering)
{
    const double g = 0.4;  // low enough for the rule to resolve the lobe: g^120 is negligible
    const int degree = 5;
    const Vec3d in = Vec3d(0.2, 0.7, -0.4).unit();
    std::vector<double> sum(harmonic_count(degree), 0.0), y(sum.size()), at_in(sum.size());
    sphere_rule(60, [&](const Vec3d& s, double w) {
        evaluate_harmonics(degree, s, y.data());
        const double p = (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * s.dot(in), 1.5));
        for (size_t i = 0; i < y.size(); ++i) sum[i] += w * p * y[i];
    });
    evaluate_harmonics(degree, in, at_in.data());
    for (int l = 0; l <= degree; ++l)
        for (int m = -l; m <= l; ++m) EXPECT_NEAR(sum[harmonic(l, m)], std::pow(g, l) * at_in[harmonic(l, m)], 1e-12);
}

}  // namespace
}  // namespace vdbcloud
