// The film: layers, samples gathered the same way by any number of threads, crops that are part of the whole.
#include "vdbcloud/render/film.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <cstring>

namespace vdbcloud {
namespace {

const std::vector<LayerSpec> layers{{"", {"R", "G", "B", "A"}},
                                    {"Z", {"Z"}, false, Combine::Nearest},
                                    {"variance", {"Y"}, false},
                                    {"emission", {"R", "G", "B"}}};

SamplerFactory factory(SampleFunction f)
{
    return [f] { return f; };
}

/// Something smooth and different everywhere.
void pattern(double x, double y, double* out)
{
    for (int c = 0; c < 4; ++c) out[c] = 1 + std::sin(0.3 * x + c) * std::cos(0.2 * y);
    out[4] = 10 + x;
    out[6] = y;
}

bool equal(const Film& a, const Film& b, const PixelWindow& w)
{
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i)
            if (std::memcmp(a.pixel(i, j), b.pixel(i, j), sizeof(float) * size_t(a.channels())) != 0) return false;
    return true;
}

SamplingOptions sixteen_gaussian()
{
    SamplingOptions options;
    options.samples = 16;
    options.filter = FilterKind::Gaussian;
    return options;
}

TEST(Film, HasItsLayersInOrder)
{
    Film film({4, 3, 1, {}}, layers);
    EXPECT_EQ(film.channels(), 9);
    EXPECT_EQ(film.offset(film.find("Z")), 4);
    EXPECT_EQ(film.offset(film.find("emission")), 6);
    EXPECT_EQ(film.find("direct_sun"), -1);
    EXPECT_EQ(film.pixel(3, 2) - film.pixel(0, 0), 11 * 9);
    EXPECT_THROW(Film({4, 3, 1, {}}, {layers[0], layers[0]}), InputError);
    EXPECT_THROW(Film({4, 3, 1, {}}, {{"x", {}}}), InputError);
}

TEST(Film, TakesOneSampleAtEachPixelsCentre)
{
    Film film({40, 30, 1, {}}, layers);
    expose(film, {}, factory([](double x, double y, double* out) { out[0] = x, out[1] = y; }));
    for (int j = 0; j < 30; ++j)
        for (int i = 0; i < 40; ++i) {
            EXPECT_EQ(film.pixel(i, j)[0], i + 0.5f);
            EXPECT_EQ(film.pixel(i, j)[1], j + 0.5f);
        }
}

TEST(Film, KeepsAConstantToTheBitUnderAnyFilter)
{
    for (const auto kind : {FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris}) {
        SamplingOptions options;
        options.samples = 7;
        options.filter = kind;
        Film film({8, 8, 1, {}}, layers);
        expose(film, options, factory([](double, double, double* out) { std::fill(out, out + 9, 0.75); }));
        for (int c : {0, 3, 4, 8}) EXPECT_EQ(film.pixel(5, 6)[c], 0.75f);
        EXPECT_EQ(film.pixel(5, 6)[5], 0);  // no variance in a constant
    }
}

/// int f(x) cos(k x) dx of a filter of integral 1, by the midpoint rule on its definition.
double transform_of(FilterKind kind, double width, double k)
{
    double sum = 0, total = 0;
    const int n = 20000;
    for (int i = 0; i < n; ++i) {
        const double x = width * ((i + 0.5) / n - 0.5), u = 2 * M_PI * x / width, s = width / 6;
        const double f = kind == FilterKind::Box ? 1
                         : kind == FilterKind::Gaussian
                             ? std::exp(-x * x / (2 * s * s))
                             : 0.35875 + 0.48829 * std::cos(u) + 0.14128 * std::cos(2 * u) + 0.01168 * std::cos(3 * u);
        sum += f * std::cos(k * x);
        total += f;
    }
    return sum / total;
}

TEST(Film, IsTheRadianceConvolvedWithTheFilter)
{
    // A wave cos(k x) becomes its value at the pixel's centre times the filter's transform; 2 where there is no wave.
    for (const auto kind : {FilterKind::Box, FilterKind::Gaussian, FilterKind::BlackmanHarris})
        for (double width : {0.0, 2.0}) {
            SamplingOptions options;
            options.samples = 4096;
            options.filter = kind;
            options.filter_width = width;
            const double own = kind == FilterKind::Box ? 1 : 3, used = width > 0 ? width : own, kx = 2.1, ky = 1.3;
            Film film({6, 5, 1, {}}, layers);
            expose(film, options, factory([&](double x, double y, double* out) {
                       out[0] = std::cos(kx * x);
                       out[1] = std::cos(ky * y);
                       out[2] = std::cos(kx * x) * std::cos(ky * y);
                       out[3] = 2;
                   }));
            const double fx = transform_of(kind, used, kx), fy = transform_of(kind, used, ky);
            for (int j = 0; j < 5; ++j)
                for (int i = 0; i < 6; ++i) {
                    const float* p = film.pixel(i, j);
                    const double cx = std::cos(kx * (i + 0.5)), cy = std::cos(ky * (j + 0.5));
                    // A Hammersley set of 4096 points: discrepancy about (log n) / n = 2e-3.
                    EXPECT_NEAR(p[0], cx * fx, 5e-3) << name(kind) << width;
                    EXPECT_NEAR(p[1], cy * fy, 5e-3) << name(kind) << width;
                    EXPECT_NEAR(p[2], cx * cy * fx * fy, 5e-3) << name(kind) << width;
                    EXPECT_EQ(p[3], 2);
                }
        }
}

TEST(Film, HasTheMeanColourAndTheNearestDepthOfItsSamples)
{
    SamplingOptions options;
    options.samples = 64;
    Film film({4, 4, 1, {}}, layers);
    // Half of each pixel sees something at depth 2, the other half nothing.
    expose(film, options, factory([](double x, double, double* out) {
               const bool hit = x - std::floor(x) < 0.5;
               out[0] = hit;
               out[4] = hit ? 2.0 : 1e30;
           }));
    EXPECT_NEAR(film.pixel(2, 1)[0], 0.5, 1.0 / 64 + 1e-6);  // one of 64 strata holds the edge
    EXPECT_EQ(film.pixel(2, 1)[4], 2.0f);
}

TEST(Film, EstimatesTheVarianceOfAPixelsMean)
{
    SamplingOptions options;
    options.samples = 400;
    Film film({2, 2, 1, {}}, layers);
    // Grey, uniform in [0, 1) across the pixel: the variance of one sample is 1/12.
    expose(film, options, factory([](double x, double, double* out) { out[0] = out[1] = out[2] = x - std::floor(x); }));
    EXPECT_NEAR(film.pixel(1, 1)[5] * 400 * 12, 1, 0.02);  // unbiased to 1/n, strata change it by less
}

TEST(Film, HasEqualBitsForOneAndFourThreads)
{
    const ImageSize size{70, 45, 1, {}};
    Film one(size, layers), four(size, layers);
    {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        expose(one, sixteen_gaussian(), factory(pattern));
    }
    {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 4);
        expose(four, sixteen_gaussian(), factory(pattern));
    }
    EXPECT_TRUE(equal(one, four, size.window()));
    EXPECT_NE(one.pixel(3, 3)[0], one.pixel(4, 3)[0]);
}

TEST(Film, HasThePixelsOfTheWholeInACrop)
{
    ImageSize size{70, 45, 1, {}};
    Film whole(size, layers);
    size.crop = {13, 7, 51, 40};
    Film part(size, layers);
    EXPECT_EQ(part.window().width(), 38);
    expose(whole, sixteen_gaussian(), factory(pattern));
    expose(part, sixteen_gaussian(), factory(pattern));
    EXPECT_TRUE(equal(whole, part, size.crop));
}

TEST(Film, NamesThePixelAndLayerOfAValueThatIsNotFinite)
{
    Film film({8, 8, 1, {}}, layers);
    const auto bad = [](double x, double y, double* out) { out[7] = x == 3.5 && y == 6.5 ? std::nan("") : 0; };
    try {
        expose(film, {}, factory(bad));
        FAIL() << "took a NaN";
    } catch (const ConvergenceError& error) {
        EXPECT_NE(std::string(error.what()).find("3,6"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("emission"), std::string::npos) << error.what();
    }
}

TEST(Film, ReportsProgressByTileAndThrowsCancelled)
{
    Film film({64, 64, 1, {}}, layers);
    std::atomic<int> calls{0};
    std::atomic<bool> complete{false};
    expose(film, {}, factory(pattern), [&](double done) {
        ++calls;
        if (done == 1) complete = true;
        return true;
    });
    EXPECT_EQ(calls, 16);
    EXPECT_TRUE(complete);
    EXPECT_THROW(expose(film, {}, factory(pattern), [](double) { return false; }), Cancelled);
}

}  // namespace
}  // namespace vdbcloud
