// Quadratures of the sphere: exactness for harmonics, symmetries, rounding of counts.
#include "vdbcloud/scatter/ordinates.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/scatter/harmonics.h"

#include <gtest/gtest.h>

#include <set>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbcloud {
namespace {

/// Largest |<Y_lm Y_l'm'> - delta| up to a degree.
double worst_moment(const Ordinates& set, int degree)
{
    const int n = harmonic_count(degree);
    std::vector<double> gram(size_t(n) * n, 0.0), y(size_t(n), 0.0);
    for (size_t m = 0; m < set.count(); ++m) {
        evaluate_harmonics(degree, set.direction[m], y.data());
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) gram[i * n + j] += set.weight[m] * y[i] * y[j];
    }
    double worst = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) worst = std::max(worst, std::abs(gram[i * n + j] - (i == j)));
    return worst;
}

std::vector<Ordinates> all_sets()
{
    std::vector<Ordinates> sets;
    for (int polar = 0; polar < 3; ++polar)
        for (int count : {8, 16, 32, 64, 72, 128, 256, 288, 512})
            sets.push_back(ordinates(OrdinateKind::Product, count, 0, polar));
    for (int count : {8, 24, 48, 80, 120, 168}) sets.push_back(ordinates(OrdinateKind::LevelSymmetric, count, 0));
    return sets;
}

TEST(Ordinates, ProductsOfHarmonicsAreExactUpToTheDegreeOnly)
{
    for (const Ordinates& set : all_sets()) {
        EXPECT_LT(worst_moment(set, set.degree), 1e-12) << name(set.kind) << ' ' << set.count();
        if (set.count() != 168) {  // S_12: too few weights for degree 6, with a small error there
            EXPECT_GT(worst_moment(set, set.degree + 1), 1e-6) << name(set.kind) << ' ' << set.count();
        }
        for (size_t m = 0; m < set.count(); ++m) {
            EXPECT_GT(set.weight[m], 0);
            EXPECT_NEAR(set.direction[m].length(), 1, 1e-15);
        }
    }
}

TEST(Ordinates, HalfRangeGaussIsExactOnEachSideOfTheEquator)
{
    const Ordinates set = ordinates(OrdinateKind::Product, 32, 1, 1);  // 2 polar points: degree 3 on (0, 1)
    for (int power = 0; power <= 3; ++power) {
        double up = 0;
        for (size_t m = 0; m < set.count(); ++m)
            if (set.direction[m][1] > 0) up += set.weight[m] * std::pow(set.direction[m][1], power);
        EXPECT_NEAR(up, 2 * pi / (power + 1), 1e-13);
    }
}

/// True if the permutation and reflection of axes maps the set to itself, weights included.
bool invariant(const Ordinates& set, const std::array<int, 3>& axes, int signs)
{
    for (size_t m = 0; m < set.count(); ++m) {
        Vec3d image;
        for (int a = 0; a < 3; ++a) image[a] = (signs >> a & 1 ? -1 : 1) * set.direction[m][axes[a]];
        bool found = false;
        for (size_t k = 0; k < set.count() && !found; ++k)
            found = (image - set.direction[k]).length() < 1e-14 && std::abs(set.weight[k] - set.weight[m]) < 1e-14;
        if (!found) return false;
    }
    return true;
}

int symmetries(const Ordinates& set)
{
    int count = 0;
    std::array<int, 3> axes{0, 1, 2};
    do
        for (int signs = 0; signs < 8; ++signs) count += invariant(set, axes, signs);
    while (std::next_permutation(axes.begin(), axes.end()));
    return count;
}

TEST(Ordinates, LevelSymmetricHas48SymmetriesAndProductHas16)
{
    EXPECT_EQ(symmetries(ordinates(OrdinateKind::LevelSymmetric, 80, 1)), 48);
    EXPECT_EQ(symmetries(ordinates(OrdinateKind::LevelSymmetric, 24, 1)), 48);
    for (int count : {16, 32, 72, 144}) EXPECT_EQ(symmetries(ordinates(OrdinateKind::Product, count, 1)), 16) << count;
}

TEST(Ordinates, LevelSymmetricCosinesMatchCarlsonAndLathrop)
{
    // Carlson & Lathrop 1968: mu_1 of S_4, S_6, S_8, S_12.
    for (const auto& [count, mu] : {std::pair(24, 0.3500212), {48, 0.2666355}, {80, 0.2182179}, {168, 0.1672126}}) {
        double smallest = 1;
        for (const Vec3d& s : ordinates(OrdinateKind::LevelSymmetric, count, 1).direction)
            smallest = std::min(smallest, std::abs(s[0]));
        EXPECT_NEAR(smallest, mu, 1e-6) << count;
    }
}

TEST(Ordinates, CountsRoundUpToTheSmallestSufficientSet)
{
    const auto count = [](int asked, int degree) { return ordinates(OrdinateKind::Product, asked, degree).count(); };
    EXPECT_EQ(count(32, 1), 32u);
    EXPECT_EQ(count(33, 1), 64u);
    EXPECT_EQ(count(1, 1), 16u);
    EXPECT_EQ(count(32, 3), 64u);
    EXPECT_EQ(count(64, 3), 64u);
    EXPECT_EQ(count(64, 7), 256u);
    for (int asked : {8, 32, 64, 128, 256,
                      512}) {  // layers: the same counts and degrees, more polar points where that leaves 8 azimuths
        const Ordinates cloud = ordinates(OrdinateKind::Product, asked, 1),
                        layer = ordinates(OrdinateKind::Product, asked, 1, 1, true);
        EXPECT_EQ(cloud.count(), layer.count());
        EXPECT_EQ(cloud.degree, layer.degree);
        const auto heights = [](const Ordinates& set) {
            std::set<double> mu;
            for (const Vec3d& s : set.direction) mu.insert(s[1]);
            return mu.size();
        };
        EXPECT_EQ(heights(layer), asked == 128 || asked == 512 ? 2 * heights(cloud) : heights(cloud)) << asked;
        EXPECT_LT(worst_moment(layer, layer.degree), 1e-12) << asked;
        EXPECT_EQ(symmetries(layer), 16) << asked;
    }
    EXPECT_EQ(ordinates(OrdinateKind::LevelSymmetric, 32, 1).count(), 48u);
    EXPECT_EQ(ordinates(OrdinateKind::LevelSymmetric, 8, 3).count(), 48u);
    EXPECT_THROW(ordinates(OrdinateKind::LevelSymmetric, 80, 7), InputError);
    EXPECT_THROW(ordinates(OrdinateKind::LevelSymmetric, 1000, 1), InputError);
    EXPECT_THROW(ordinates(OrdinateKind::Product, 1000000, 1), InputError);
    EXPECT_THROW(ordinates(OrdinateKind::Product, 0, 1), InputError);
    EXPECT_THROW(ordinates(OrdinateKind::Product, 8, 8), InputError);
    EXPECT_THROW(ordinates(OrdinateKind::Product, 8, 1, 3), InputError);
    EXPECT_EQ(ordinate_kind("level-symmetric"), OrdinateKind::LevelSymmetric);
    EXPECT_THROW(ordinate_kind("gauss"), InputError);
}

}  // namespace
}  // namespace vdbcloud
