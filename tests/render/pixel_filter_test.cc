// Reconstruction filters: their samples are distributed as they say, and belong to the pixel alone.
#include "vdbcloud/render/pixel_filter.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbcloud {
namespace {

double density(FilterKind kind, double width, double x)  // unnormalised, from the definitions
{
    const double u = 2 * pi * x / width, s = width / 6;
    switch (kind) {
    case FilterKind::Box: return 1;
    case FilterKind::Gaussian: return std::exp(-x * x / (2 * s * s));
    case FilterKind::BlackmanHarris:
        return 0.35875 + 0.48829 * std::cos(u) + 0.14128 * std::cos(2 * u) + 0.01168 * std::cos(3 * u);
    }
    return 0;
}

class AnyFilter : public testing::TestWithParam<FilterKind> {};

TEST_P(AnyFilter, CumulativeIsTheIntegralOfItsShapeAndSumsToOne)
{
    const double width = 2.5;
    const int n = 20000;  // midpoint rule: 1e-9 for these smooth shapes
    double total = 0, quarter = 0;
    for (int k = 0; k < n; ++k) {
        const double x = width * ((k + 0.5) / n - 0.5);
        total += density(GetParam(), width, x);
        if (x < -width / 8) quarter += density(GetParam(), width, x);
    }
    EXPECT_NEAR(cumulative(GetParam(), width, -width / 8), quarter / total, 1e-7);
    EXPECT_NEAR(cumulative(GetParam(), width, -width / 2), 0, 1e-15);
    EXPECT_DOUBLE_EQ(cumulative(GetParam(), width, width / 2), 1);
    EXPECT_DOUBLE_EQ(cumulative(GetParam(), width, 0), 0.5);
}

TEST_P(AnyFilter, SamplesHaveTheFiltersMeanAndSpread)
{
    SamplingOptions options;
    options.samples = 4096;
    options.filter = GetParam();
    const PixelFilter filter(options);
    const double width = GetParam() == FilterKind::Box ? 1 : 3;
    double expected = 0, total = 0;
    for (int k = 0; k < 10000; ++k) {
        const double x = width * ((k + 0.5) / 10000 - 0.5);
        total += density(GetParam(), width, x);
        expected += x * x * density(GetParam(), width, x);
    }
    expected /= total;
    double x1 = 0, x2 = 0, y1 = 0, y2 = 0, xy = 0;
    for (int k = 0; k < options.samples; ++k) {
        const auto [x, y] = filter(5, 9, k);
        EXPECT_LE(std::max(std::abs(x), std::abs(y)), width / 2);
        x1 += x, x2 += x * x, y1 += y, y2 += y * y, xy += x * y;
    }
    const double n = options.samples;
    // A Hammersley set of n points: discrepancy about (log n)/n = 2e-3.
    EXPECT_NEAR(x1 / n, 0, 3e-3);
    EXPECT_NEAR(y1 / n, 0, 3e-3);
    EXPECT_NEAR(x2 / n, expected, 3e-3);
    EXPECT_NEAR(y2 / n, expected, 3e-3);
    EXPECT_NEAR(xy / n, 0, 3e-3);
}

TEST_P(AnyFilter, InverseUndoesCumulative)
{
    SamplingOptions options;
    options.samples = 2;
    options.filter = GetParam();
    options.filter_width = 2;
    const PixelFilter filter(options);
    for (double u = 0; u <= 1; u += 1.0 / 64)
        EXPECT_NEAR(cumulative(GetParam(), 2, filter.inverse_cumulative(u)), u, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Kinds, AnyFilter,
                         testing::Values(FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris),
                         [](const auto& kind) {
                             std::string text = name(kind.param);
                             text.erase(std::remove(text.begin(), text.end(), '-'), text.end());
                             return text;
                         });

TEST(PixelFilter, TakesASingleSampleAtTheCentre)
{
    for (const auto kind : {FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris}) {
        SamplingOptions options;
        options.filter = kind;
        const auto [x, y] = PixelFilter(options)(17, 4, 0);
        EXPECT_EQ(x, 0);
        EXPECT_EQ(y, 0);
    }
}

TEST(PixelFilter, HasOneOfFourSamplesInEachQuarterOfAnAxis)
{
    SamplingOptions options;
    options.samples = 4;
    const PixelFilter filter(options);
    for (int i = 0; i < 20; ++i) {
        std::set<int> columns, rows;
        for (int k = 0; k < 4; ++k) {
            // Turned round as a whole, the points keep their distance: one in each quarter of the turned
            // axis.
            const auto first = filter(i, 3, 0), at = filter(i, 3, k);
            columns.insert(int(std::lround(4 * (at.x - first.x + 1))) % 4);
            rows.insert(int(std::lround(4 * (at.y - first.y + 1))) % 4);
        }
        EXPECT_EQ(columns.size(), 4u);
        EXPECT_EQ(rows.size(), 4u);
    }
}

TEST(PixelFilter, HasUncorrelatedOffsetsOnItsTwoAxes)
{
    SamplingOptions options;
    options.samples = 2;
    const PixelFilter filter(options);
    double xy = 0;
    for (int i = 0; i < 1000; ++i) {
        const auto [x, y] = filter(i, 7, 0);
        xy += 12 * x * y / 1000;  // a correlation: 1/12 is the variance of either
    }
    EXPECT_LT(std::abs(xy), 0.1);  // three standard deviations of the mean of 1000
}

TEST(PixelFilter, DependsOnSeedAndPixel)
{
    SamplingOptions options;
    options.samples = 4;
    const PixelFilter one(options);
    options.seed = 1;
    const PixelFilter two(options);
    EXPECT_EQ(one(3, 4, 1).x, one(3, 4, 1).x);
    EXPECT_NE(one(3, 4, 1).x, two(3, 4, 1).x);
    EXPECT_NE(one(3, 4, 1).x, one(4, 3, 1).x);
    EXPECT_NE(one(3, 4, 1).y, one(3, 5, 1).y);
}

TEST(PixelFilter, RefusesSamplesWidthsAndNamesOutsideTheirRange)
{
    EXPECT_THROW(PixelFilter({0, FilterKind::Box, 0, 0}), InputError);
    EXPECT_THROW(PixelFilter({1, FilterKind::Box, -1, 0}), InputError);
    EXPECT_THROW(PixelFilter({1, FilterKind::Box, std::nan(""), 0}), InputError);
    EXPECT_THROW(filter_kind("triangle"), InputError);
    EXPECT_EQ(filter_kind("blackman-harris"), FilterKind::BlackmanHarris);
}

}  // namespace
}  // namespace vdbcloud
