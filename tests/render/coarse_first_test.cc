// Pictures that begin with coarse pixels: the same at the end, each pixel computed once, whole at any moment.
#include "vdbcloud/render/coarse_first.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <vector>

namespace vdbcloud::test {
namespace {

/// Colours that differ from pixel to pixel and from sample to sample.
SamplerFactory pattern(std::atomic<int>& calls)
{
    return [&]() -> SampleFunction {
        return [&](double x, double y, double* out) {
            ++calls;
            for (int c = 0; c < 5; ++c) out[c] = 1.5 + std::sin(3 * x + c) * std::cos(2 * y);
        };
    };
}

Film empty(const PixelWindow& crop)
{
    ImageSize size;
    size.width = 37, size.height = 29;
    size.crop = crop;
    return {size,
            {{"", {"R", "G", "B", "A"}, true, Combine::Mean},
             {"Z", {"Z"}, false, Combine::Nearest},
             {"variance", {"Y"}, false, Combine::Mean}}};
}

/// Sum over the channels: a number that tells pixels from each other.
double mark(const Film& film, int i, int j)
{
    double sum = 0;
    for (int c = 0; c < film.channels(); ++c) sum += (c + 1) * double(film.pixel(i, j)[c]);
    return sum;
}

void expect_equal(const Film& a, const Film& b)
{
    const PixelWindow w = a.window();
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i)
            for (int c = 0; c < a.channels(); ++c) ASSERT_EQ(a.pixel(i, j)[c], b.pixel(i, j)[c]) << i << ',' << j;
}

const PixelWindow crops[] = {{0, 0, 37, 29}, {3, 5, 36, 28}, {9, 9, 10, 10}, {0, 7, 37, 8}};

TEST(CoarseFirst, EndsAsThePlainPictureAndComputesEachPixelOnce)
{
    for (const PixelWindow& crop : crops) {
        SamplingOptions sampling;
        sampling.samples = 3;
        std::atomic<int> plain_calls{0}, calls{0};
        Film plain = empty(crop), film = empty(crop);
        expose(plain, sampling, pattern(plain_calls));
        int shown = 0;
        PassOptions options;
        options.show_interval = 0;
        options.show = [&](const Film&, const ShownPicture&) { ++shown; };
        const CoarseReport report = expose_coarse_first(film, sampling, options, pattern(calls));
        expect_equal(plain, film);
        EXPECT_EQ(calls, plain_calls);
        EXPECT_EQ(report.coarseness, 1);
        EXPECT_EQ(report.pixels, uint64_t(plain_calls / 3));
        EXPECT_EQ(shown > 0, crop.width() * crop.height() > 1);
    }
}

TEST(CoarseFirst, EachShownPictureIsWholeAndFinerThanTheOneBefore)
{
    for (const PixelWindow& crop : crops) {
        std::atomic<int> calls{0};
        Film plain = empty(crop), film = empty(crop);
        expose(plain, {}, pattern(calls));
        const PixelWindow w = plain.window();
        int coarseness = 8, last_right = 0;
        PassOptions options;
        options.show_interval = 0;
        options.show = [&](const Film& shown, const ShownPicture& picture) {
            EXPECT_LE(picture.coarseness, coarseness);
            coarseness = picture.coarseness;
            int right = 0;
            for (int j = w.y0; j < w.y1; ++j)
                for (int i = w.x0; i < w.x1; ++i) {
                    // The value of the pixel itself, or of the first pixel of a block about it.
                    bool known = false;
                    for (int edge = 1; edge <= coarseness; edge *= 2)
                        known = known || mark(shown, i, j) == mark(plain, i - (i - w.x0) % edge, j - (j - w.y0) % edge);
                    EXPECT_TRUE(known) << i << ',' << j;
                    right += mark(shown, i, j) == mark(plain, i, j);
                }
            EXPECT_GT(right, last_right);
            last_right = right;
        };
        expose_coarse_first(film, {}, options, pattern(calls));
    }
}

TEST(CoarseFirst, WithoutTimeThePictureIsThatOfTheFirstRound)
{
    for (const PixelWindow& crop : crops) {
        std::atomic<int> plain_calls{0}, calls{0};
        Film plain = empty(crop), film = empty(crop);
        expose(plain, {}, pattern(plain_calls));
        PassOptions options;
        options.time_limit = 1e-9;
        const CoarseReport report = expose_coarse_first(film, {}, options, pattern(calls));
        const PixelWindow w = plain.window();
        const int blocks = (w.width() + 7) / 8 * ((w.height() + 7) / 8);
        EXPECT_EQ(report.pixels, uint64_t(blocks));
        EXPECT_EQ(calls, blocks);
        EXPECT_EQ(report.coarseness, w.width() * w.height() > 1 ? 8 : 1);
        for (int j = w.y0; j < w.y1; ++j)
            for (int i = w.x0; i < w.x1; ++i)
                EXPECT_EQ(mark(film, i, j), mark(plain, i - (i - w.x0) % 8, j - (j - w.y0) % 8)) << i << ',' << j;
    }
}

TEST(CoarseFirst, PassesOfLightPathsAreShownAndEndAsOnePass)
{
    const IndexedSampleFactory factory = [] {
        return [](int i, int j, uint64_t k, double* out) {
            for (int c = 0; c < 5; ++c) out[c] = 1.5 + std::sin(3.0 * i + 5.0 * j + 7.0 * double(k) + c);
        };
    };
    SamplingOptions sampling;
    sampling.samples = 40;
    Film plain = empty(crops[0]), film = empty(crops[0]);
    const PassReport a = expose_in_passes(plain, sampling, {}, factory);
    PassOptions options;
    options.show_interval = 0;
    uint64_t last = 0;
    options.show = [&](const Film& shown, const ShownPicture& picture) {
        EXPECT_EQ(picture.samples > last, true);
        last = picture.samples;
        Film alone = empty(crops[0]);
        SamplingOptions fewer = sampling;
        fewer.samples = int(picture.samples);
        expose_in_passes(alone, fewer, {}, factory);
        expect_equal(alone, shown);
    };
    const PassReport b = expose_in_passes(film, sampling, options, factory);
    // How often depends on the clock: the first pass is shown always.
    EXPECT_GE(last, 1u);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.noise, b.noise);
    expect_equal(plain, film);
}

TEST(CoarseFirst, ShowingTakesATenthOfTheTimeAtTheMost)
{
    PassOptions options;
    options.show_interval = 0;
    options.show = [](const Film&, const ShownPicture&) {
        const double end = clock_seconds() + 0.02;
        while (clock_seconds() < end) continue;
    };
    Showing showing(options);
    EXPECT_TRUE(showing.due());
    showing.show(empty(crops[0]), {});
    const double shown = clock_seconds();
    while (!showing.due()) ASSERT_LT(clock_seconds(), shown + 30);
    EXPECT_GE(clock_seconds() - shown, 0.19);
}

}  // namespace
}  // namespace vdbcloud::test
