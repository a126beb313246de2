// Spectral synthesis against its power spectrum, mode by mode.
#include "vdbcloud/fractal/noise.h"

#include "support/size.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

namespace vdbcloud {
namespace {

using Field = fft::RealField<float>;

/// Calls visit(m, F) for every mode of the half spectrum, F in the scale of the synthesis, its phase that of
/// a box whose origin is its low corner (voxel centres lie half a voxel inside).
void for_modes(Field& field, const std::function<void(const Vec3i&, std::complex<double>)>& visit)
{
    const auto n = field.size();
    fft::RealTransform<float>(n).forward(field);
    for (int a = 0; a < n[0]; ++a)
        for (int b = 0; b < n[1]; ++b)
            for (int c = 0; c <= n[2] / 2; ++c) {
                const Vec3i m(2 * a < n[0] ? a : a - n[0], 2 * b < n[1] ? b : b - n[1], c);
                const double turns = 0.5 * (double(m[0]) / n[0] + double(m[1]) / n[1] + double(m[2]) / n[2]);
                visit(m, std::complex<double>(field.modes(a, b)[c]) * std::polar(1.0 / n.product(), -2 * M_PI * turns));
            }
}

bool inside(const Vec3i& m, const Vec3i& n)
{
    double r2 = 0;
    for (int d = 0; d < 3; ++d) r2 += 4.0 * m[d] * m[d] / n[d] / n[d];
    return r2 < 0.999;
}

double kappa(const Vec3i& m, const Vec3d& sides, const Vec3d& stretch)
{
    const double longest = std::max({sides[0], sides[1], sides[2]});
    return Vec3d(m[0] * stretch[0] / sides[0], m[1] * stretch[1] / sides[1], m[2] * stretch[2] / sides[2]).length() *
           longest;
}

/// Slope of log(mean power of a mode) over log(wave number), by least squares over shells of equal ratio,
/// each weighted by its modes (the relative error of a mean of N exponential variables is 1 / sqrt(N)).
double slope(Field& field, const Vec3d& sides, const Spectrum& s, double from, double to)
{
    constexpr int shells = 12;
    double power[shells] = {}, log_k[shells] = {}, count[shells] = {};
    for_modes(field, [&](const Vec3i& m, std::complex<double> f) {
        const double k = kappa(m, sides, s.stretch);
        const int shell = int(std::floor(shells * std::log(k / from) / std::log(to / from)));
        if (k < from || shell >= shells || !inside(m, field.size())) return;
        power[shell] += std::norm(f);
        log_k[shell] += std::log(k);
        count[shell] += 1;
    });
    double w = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int i = 0; i < shells; ++i) {
        if (count[i] < 8) continue;
        const double lx = log_k[i] / count[i], ly = std::log(power[i] / count[i]);
        w += count[i], x += count[i] * lx, y += count[i] * ly, xx += count[i] * lx * lx, xy += count[i] * lx * ly;
    }
    return (w * xy - x * y) / (w * xx - x * x);
}

TEST(Noise, HasTheSpectralSlopeMinusBeta)
{
    const int n = test::sized(64, 192);
    for (double beta : {0.0, 1.5, 3.0, 11.0 / 3, 5.0, 7.0})
        for (uint64_t seed : {1, 2}) {
            Spectrum s;
            s.beta = beta;
            s.seed = seed;
            auto field = synthesize({n, n, n}, {1, 1, 1}, s);
            // A shell from 4 to 0.45 n holds 5e4 modes at 64^3: the slope's own error is about 0.01. At 7,
            // rounding of the float transform (1e-7 of the largest mode) is 1e-3 of the smallest mode's
            // amplitude.
            EXPECT_NEAR(slope(field, {1, 1, 1}, s, 4, 0.45 * n), -beta, 0.1) << "seed " << seed;
        }
}

TEST(Noise, HasTheSpectralSlopeInOddStretchedBoxes)
{
    const Vec3i n(90, 37, 64);
    const Vec3d sides(3, 1, 2);
    Spectrum s;
    s.beta = 3.5;
    s.stretch = {1, 0.5, 2};
    auto field = synthesize(n, sides, s);
    EXPECT_NEAR(slope(field, sides, s, 6, 40), -3.5, 0.1);
}

TEST(Noise, ModesAreComplexGaussiansOfTheStatedPower)
{
    Spectrum s;
    s.beta = 3;
    s.outer = 5;
    s.stretch = {1, 2, 1};
    s.low_cut = 2;
    s.high_cut = 25;
    const Vec3d sides(1, 1, 1);
    double scale = 0;  // of power: 1 over the variance of the waves with |m_d| <= 32
    for (int a = -32; a <= 32; ++a)
        for (int b = -32; b <= 32; ++b)
            for (int c = -32; c <= 32; ++c)
                if (a || b || c) scale += mode_power(s, std::pow(kappa({a, b, c}, sides, s.stretch), 2));
    double count = 0, second = 0, fourth = 0, outside = 0, plane = 0, plane_count = 0;
    std::complex<double> mean = 0, square = 0;
    auto field = synthesize({64, 64, 64}, sides, s);
    for_modes(field, [&](const Vec3i& m, std::complex<double> f) {
        const double power = mode_power(s, std::pow(kappa(m, sides, s.stretch), 2)) / scale;
        if (m == Vec3i(0) || power == 0 || !inside(m, {64, 64, 64})) {
            if (m == Vec3i(0) || power == 0) outside = std::max(outside, std::abs(f));
            return;
        }
        f /= std::sqrt(power);
        if (m[2] == 0) {  // each of these comes twice
            plane += std::norm(f), plane_count += 1;
            return;
        }
        count += 1, mean += f, square += f * f, second += std::norm(f), fourth += std::norm(f) * std::norm(f);
    });
    ASSERT_GT(count, 10000);
    const double error = 4 / std::sqrt(count);  // four standard errors of a mean of unit variance
    EXPECT_LT(std::abs(mean / count), error);
    EXPECT_LT(std::abs(square / count), error * std::sqrt(2));  // no preferred phase
    EXPECT_NEAR(second / count, 1, error);
    EXPECT_NEAR(fourth / count, 2, error * std::sqrt(20));  // <|F|^4> = 2 <|F|^2>^2; its variance is 24 - 4
    EXPECT_NEAR(plane / plane_count, 1,
                4 * std::sqrt(2 / plane_count));  // conjugate pairs, or it would be a half
    EXPECT_LT(outside, 1e-6);
}

TEST(Noise, IsRealWithMeanZeroAndAboutUnitVariance)
{
    double variance = 0, mean = 0;
    const Vec3i n(40, 48, 54);
    const int fields = 20;
    for (uint64_t seed = 0; seed < fields; ++seed) {
        Spectrum s;
        s.seed = seed;
        const auto f = synthesize(n, {1, 1, 1}, s);
        for (int i = 0; i < n[0]; ++i)
            for (int j = 0; j < n[1]; ++j)
                for (int k = 0; k < n[2]; ++k) mean += f(i, j, k), variance += double(f(i, j, k)) * f(i, j, k);
    }
    EXPECT_NEAR(mean / fields / n.product(), 0, 1e-6);
    EXPECT_NEAR(variance / fields / n.product(), 1,
                0.2);  // a few long waves carry most of it: +-0.2 / sqrt(20) x 4
}

TEST(Noise, HasUnitVarianceInTwoDimensions)
{
    double variance = 0;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        Spectrum s;
        s.seed = seed;
        s.beta = 3;
        s.outer = 4;
        const auto f = synthesize({60, 1, 64}, {2, 0.1, 2}, s);
        for (int i = 0; i < 60; ++i)
            for (int k = 0; k < 64; ++k) variance += double(f(i, 0, k)) * f(i, 0, k);
    }
    EXPECT_NEAR(variance / 40 / 60 / 64, 1, 0.1);
}

TEST(Noise, KeepsTheModesOfASmallerSize)
{
    Spectrum s;
    s.seed = 9;
    auto coarse = synthesize({24, 20, 27}, {1, 1, 1}, s), fine = synthesize({32, 64, 45}, {1, 1, 1}, s);
    std::vector<std::complex<double>> kept(17 * 17 * 9);
    const auto at = [](const Vec3i& m) { return ((m[0] + 8) * 17 + m[1] + 8) * 9 + m[2]; };
    const auto low = [](const Vec3i& m) { return std::abs(m[0]) <= 5 && std::abs(m[1]) <= 5 && m[2] <= 5; };
    for_modes(coarse, [&](const Vec3i& m, std::complex<double> f) {
        if (low(m)) kept[at(m)] = f;
    });
    int compared = 0;
    for_modes(fine, [&](const Vec3i& m, std::complex<double> f) {
        if (!low(m)) return;
        ASSERT_NEAR(std::abs(f - kept[at(m)]), 0, 2e-6) << m;
        compared += std::abs(f) > 1e-3;
    });
    EXPECT_GT(compared, 100);
}

bool equal(const Field& a, const Field& b)
{
    for (int i = 0; i < a.size()[0]; ++i)
        for (int j = 0; j < a.size()[1]; ++j)
            if (std::memcmp(a.row(i, j), b.row(i, j), size_t(a.size()[2]) * sizeof(float)) != 0) return false;
    return true;
}

TEST(Noise, HasEqualBitsForAnyThreadCountAndIsUncorrelatedBetweenSeeds)
{
    const Vec3i n(30, 33, 47);
    Spectrum s;
    const auto first = synthesize(n, {1, 1, 1}, s);
    for (int threads : {1, 2, 5}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_TRUE(equal(first, synthesize(n, {1, 1, 1}, s))) << threads << " threads";
    }
    s.seed = 2;
    s.beta = 0;  // many independent values, so that a correlation would show
    const auto other = synthesize(n, {1, 1, 1}, s);
    s.seed = 3;
    const auto third = synthesize(n, {1, 1, 1}, s);
    double ab = 0, aa = 0, bb = 0;
    for (int i = 0; i < n[0]; ++i)
        for (int j = 0; j < n[1]; ++j)
            for (int k = 0; k < n[2]; ++k) {
                const double a = other(i, j, k), b = third(i, j, k);
                ab += a * b, aa += a * a, bb += b * b;
            }
    EXPECT_LT(std::abs(ab) / std::sqrt(aa * bb), 5 / std::sqrt(n.product() / 2.0));
}

TEST(Noise, RefusesParametersOutsideTheirRange)
{
    const auto make = [](double beta, double low, double high, double stretch) {
        Spectrum s;
        s.beta = beta, s.low_cut = low, s.high_cut = high, s.stretch[1] = stretch;
        return synthesize({8, 8, 8}, {1, 1, 1}, s);
    };
    EXPECT_NO_THROW(make(3, 0, 10, 1));
    EXPECT_THROW(make(-1, 0, 10, 1), InputError);
    EXPECT_THROW(make(std::nan(""), 0, 10, 1), InputError);
    EXPECT_THROW(make(3, 5, 4, 1), InputError);
    EXPECT_THROW(make(3, 0, 0.5, 1), InputError);
    EXPECT_THROW(make(3, 0, 10, 0), InputError);
    EXPECT_THROW(synthesize({8, 8, 8}, {1, 0, 1}, {}), InputError);
}

}  // namespace
}  // namespace vdbcloud
