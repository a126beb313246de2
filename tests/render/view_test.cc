// The way to the screen: known values of the transfer function, a monotone curve, an exposure found by ranks.
#include "vdbcloud/render/view.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/film.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(Srgb, HasTheValuesOfTheStandard)
{
    EXPECT_EQ(srgb_encode(0), 0);
    EXPECT_NEAR(srgb_encode(1), 1, 1e-15);
    EXPECT_NEAR(srgb_encode(0.18), 0.461356, 1e-6);
    EXPECT_NEAR(srgb_encode(0.5), 0.735357, 1e-6);
    EXPECT_NEAR(srgb_encode(0.001), 0.01292, 1e-12);
    EXPECT_EQ(srgb_encode(-3), 0);
    EXPECT_NEAR(srgb_encode(7), 1, 1e-15);
    // The two branches meet to the standard's own rounding.
    EXPECT_NEAR(srgb_encode(0.0031308), srgb_encode(0.0031309), 2e-6);
}

TEST(Filmic, GrowsStrictlyStaysBelowOneAndIsTheIdentityInTheDark)
{
    double before = filmic(0);
    EXPECT_EQ(before, 0);
    for (double x = 1e-3; x < 1e6; x *= 1.05) {
        EXPECT_GT(filmic(x), before) << x;
        EXPECT_LT(filmic(x), 1);
        EXPECT_LE(filmic(x), x);
        before = filmic(x);
    }
    EXPECT_EQ(filmic(0.3), 0.3);
    EXPECT_EQ(filmic(-1), 0);
    EXPECT_GT(filmic(1e6), 0.999);
}

TEST(Filmic, HasTheValuesOfItsFormula)
{
    // k + (1 - k) u / (1 + u), u = (x - k) / (1 - k), k = 0.4.
    EXPECT_DOUBLE_EQ(filmic(0.4), 0.4);
    EXPECT_DOUBLE_EQ(filmic(0.7), 0.4 + 0.6 / 3);
    EXPECT_DOUBLE_EQ(filmic(1), 0.7);
    EXPECT_DOUBLE_EQ(filmic(4), 0.4 + 0.6 * 6 / 7);
    EXPECT_DOUBLE_EQ(filmic(12.4), 0.4 + 0.6 * 20 / 21);
}

TEST(Filmic, IsSmoothAtItsKnee)
{
    const double k = 0.4, e = 1e-6;
    EXPECT_NEAR(filmic(k + e) - filmic(k - e), 2 * e, 1e-11);
    EXPECT_NEAR((filmic(k + e) - filmic(k)) / e, 1, 1e-5);
}

TEST(View, MultipliesByTwoToTheExposureThenEncodes)
{
    const Vec3d radiance(0.05, 0.1, 4);
    ViewOptions linear{ViewKind::None, 2};
    EXPECT_LT((displayed(radiance, linear) - Vec3d(0.2, 0.4, 1)).length(), 1e-15);
    ViewOptions srgb{ViewKind::Srgb, 1};
    EXPECT_LT((displayed(radiance, srgb) - Vec3d(srgb_encode(0.1), srgb_encode(0.2), 1)).length(), 1e-15);
    ViewOptions film{ViewKind::Filmic, 0};
    EXPECT_LT((displayed(radiance, film) - Vec3d(srgb_encode(0.05), srgb_encode(0.1), srgb_encode(filmic(4)))).length(),
              1e-15);
}

TEST(View, ReadsTheNamesItWrites)
{
    for (const auto kind : {ViewKind::Srgb, ViewKind::Filmic, ViewKind::None}) EXPECT_EQ(view_kind(name(kind)), kind);
    EXPECT_THROW(view_kind("agx"), InputError);
}

Film two_halves(float alpha)  // the left half a ramp of grey with alpha, the right half empty
{
    Film film({100, 10, 1, {}}, {{"", {"R", "G", "B", "A"}}, {"background", {"R", "G", "B"}}});
    for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 50; ++i) {
            float* p = film.pixel(i, j);
            p[0] = p[1] = p[2] = 0.001f * float(i + 1);
            p[3] = alpha;
        }
    return film;
}

TEST(AutoExposure, TakesThe95thPercentileOfTheMediumToItsTarget)
{
    // 500 pixels: rank floor(0.95 * 499) = 474, of the 48th column.
    EXPECT_NEAR(auto_exposure(two_halves(1)), std::log2(1.0 / 0.048), 1e-6);
    // Where nothing is opaque, all 1000 pixels count: rank 949 is the 45th column's.
    EXPECT_NEAR(auto_exposure(two_halves(0)), std::log2(1.0 / 0.045), 1e-6);
}

TEST(AutoExposure, CountsTheBackgroundAndFallsByTwoStopsForFourTimesTheLight)
{
    Film film = two_halves(0.5f);
    const double before = auto_exposure(film);
    for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 100; ++i)
            for (int c = 0; c < 3; ++c) {
                film.pixel(i, j)[c] *= 4;
            }
    EXPECT_NEAR(auto_exposure(film), before - 2, 1e-6);
    for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 100; ++i) film.pixel(i, j)[5] = 1;
    EXPECT_LT(auto_exposure(film), before - 2);
}

TEST(AutoExposure, CountsPixelsOfAlphaAboveATwentieth)
{
    // Exactly 16 pixels of the medium are enough, 15 are not: then the other pixels, of radiance 0, count as well.
    for (const auto& [pixels, expected] : {std::pair(16, std::log2(1 / 0.5)), {15, 0.0}}) {
        Film film({40, 10, 1, {}}, {{"", {"R", "G", "B", "A"}}});
        for (int n = 0; n < pixels; ++n) {
            float* p = film.pixel(n, 0);
            p[0] = p[1] = p[2] = 0.5f;
            p[3] = 0.051f;
        }
        for (int n = 0; n < 40; ++n) film.pixel(n, 5)[3] = 0.049f;
        EXPECT_NEAR(auto_exposure(film), expected, 1e-6) << pixels;
    }
}

TEST(AutoExposure, IsZeroForADarkPicture)
{
    EXPECT_EQ(auto_exposure(Film({9, 9, 1, {}}, {{"", {"R", "G", "B", "A"}}})), 0);
}

}  // namespace
}  // namespace vdbcloud
