// Anderson acceleration on maps whose fixed points are known.
#include "vdbcloud/scatter/mixing.h"

#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud {
namespace {

/// Iterates G on two arrays of n values. Returns the residuals.
std::vector<double> iterate(Mixing::Arrays& x, int depth, int steps, const std::function<void(Mixing::Arrays&)>& g)
{
    Mixing mixing(x[0].size(), 2, depth);
    std::vector<double> residual;
    for (int k = 0; k < steps; ++k) {
        mixing.before(x);
        g(x);
        residual.push_back(mixing.after(x));
        mixing.next(x);
    }
    return residual;
}

constexpr size_t n = 9000;  // more than one partial sum

/// x <- r x + 1 with fixed point 1 / (1 - r). r cycles through four rates; one rate diverges and one alternates sign.
void affine(Mixing::Arrays& x)
{
    constexpr float rate[4] = {0.9f, 0.5f, 1.5f, -0.8f};
    for (auto& array : x)
        for (size_t k = 0; k < array.size(); ++k) array[k] = rate[k % 4] * array[k] + 1;
}

TEST(Mixing, ConvergesForDivergentAffineMaps)
{
    Mixing::Arrays x(2, std::vector<float>(n, 0.0f));
    const auto residual = iterate(x, 5, 7, affine);
    EXPECT_LT(residual[5], 1e-4);  // single precision
    constexpr double exact[4] = {10, 2, -2, 1 / 1.8};
    for (size_t k = 0; k < 4; ++k) EXPECT_NEAR(x[1][k] / exact[k], 1, 1e-4) << k;
    Mixing::Arrays plain(2, std::vector<float>(n, 0.0f));
    EXPECT_GT(iterate(plain, 0, 7, affine).back(), 0.2);  // depth 0 is the plain iteration
}

TEST(Mixing, PreservesAffineConstraints)
{
    // Every G(x) has the sum 1, so every mixture has the sum 1.
    Mixing::Arrays x(2, std::vector<float>(n, 0.0f));
    iterate(x, 3, 6, [](Mixing::Arrays& s) {
        double sum = 0;
        for (size_t k = 0; k < n; ++k) {
            s[0][k] = float(0.8 * std::cos(double(k)) * s[0][(k + 1) % n] + uniform(hash_bits(5, k)));
            sum += s[0][k];
        }
        for (float& v : s[0]) v += float((1 - sum) / n);
    });
    double sum = 0;
    for (float v : x[0]) sum += v;
    EXPECT_NEAR(sum, 1, 1e-3);  // 9000 values of size 1 in single precision
}

TEST(Mixing, HandlesFixedPointsAndParallelDifferences)
{
    Mixing::Arrays x(2, std::vector<float>(n, 2.0f));
    EXPECT_EQ(iterate(x, 5, 4, [](Mixing::Arrays&) {}).back(), 0);
    EXPECT_EQ(x[0][7], 2.0f);
    // One rate only: all differences are parallel after the second step.
    Mixing::Arrays y(2, std::vector<float>(n, 0.0f));
    iterate(y, 5, 8, [](Mixing::Arrays& s) {
        for (auto& array : s)
            for (float& v : array) v = 0.9f * v + 1;
    });
    EXPECT_NEAR(y[1][n - 1], 10, 1e-4);
    Mixing::Arrays zero(2, std::vector<float>(n, 0.0f));
    EXPECT_EQ(iterate(zero, 2, 3, [](Mixing::Arrays&) {}).back(), 0);
}

}  // namespace
}  // namespace vdbcloud
