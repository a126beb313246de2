// The mountain: its heights against their spectrum and formula, its level set against its heights.
#include "vdbcloud/fractal/mountain.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <openvdb/tools/Interpolation.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

const Box domain{{-2, 0, 1}, {2, 2, 4}};
const Vec3i size(96, 48, 72);
constexpr double h = 4.0 / 96;

/// Slope of log(mean power of a mode) over log(wave number), from 4 to 0.35 of the size, of heights over a
/// square of n x n.
double slope(const std::vector<double>& heights, int n)
{
    fft::RealField<double> field({n, 1, n});
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) field(i, 0, j) = heights[size_t(i * n + j)];
    fft::RealTransform<double>({n, 1, n}).forward(field);
    double w = 0, x = 0, y = 0, xx = 0, xy = 0;
    for (int ring = 4; ring < 0.35 * n; ++ring) {
        double power = 0, count = 0;
        for (int a = 0; a < n; ++a)
            for (int c = 0; c <= n / 2; ++c) {
                const int m = a <= n / 2 ? a : a - n;
                if (int(std::lround(std::hypot(m, c))) != ring) continue;
                power += std::norm(field.modes(a, 0)[c]), count += 1;
            }
        const double lx = std::log(ring), ly = std::log(power / count);
        w += count, x += count * lx, y += count * ly, xx += count * lx * lx, xy += count * lx * ly;
    }
    return (w * xy - x * y) / (w * xx - x * x);
}

/// Height of the zero crossing in each column, from above.
std::vector<double> surface_of(const FloatGrid& solid, const Vec3i& n)
{
    std::vector<double> out;
    const auto at = solid.getConstAccessor();
    for (int i = 0; i < n[0]; ++i)
        for (int k = 0; k < n[2]; ++k) {
            int j = n[1] + 2;
            while (j > 0 && at.getValue({i, j - 1, k}) > 0) --j;
            const double above = at.getValue({i, j, k}), below = at.getValue({i, j - 1, k});
            out.push_back(solid.indexToWorld(Vec3d(i, j - above / (above - below), k))[1]);
        }
    return out;
}

TEST(Mountain, HeightsAndLevelSetHaveTheSpectralSlope)
{
    for (double beta : {3.0, 3.6, 4.4}) {
        MountainOptions o;
        o.ridges = o.peak = 0;  // heights are the noise, scaled
        o.relief = 0.02;        // gentle: where it is steep a distance is not a height
        Spectrum s;
        s.beta = beta;
        const Box square{{0, 0, 0}, {2, 1, 2}};
        const Vec3i n(128, 64, 128);
        const auto field = mountain_heights(square, n, s, o);
        std::vector<double> heights(field.height.begin(), field.height.end());
        // 2000 modes in the plane: the slope's own error is 0.04.
        EXPECT_NEAR(slope(heights, 128), -beta, 0.12);
        auto surface = surface_of(*mountain_grid(field, 3), n);
        for (int i = 0; i < 128; ++i)
            for (int k = 0; k < 128; ++k)
                if (std::min({i, k, 127 - i, 127 - k}) < 4)
                    surface[size_t(i * 128 + k)] = heights[size_t(i * 128 + k)];  // walls are near
        EXPECT_NEAR(slope(surface, 128), -beta, 0.15);
    }
}

TEST(Mountain, LevelSetIsASignedDistanceToTheHeights)
{
    const auto field = mountain_heights(domain, size, {}, {});
    const auto grid = mountain_grid(field, 3);
    EXPECT_EQ(grid->getName(), "solid");
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
    EXPECT_NEAR(grid->background(), 3 * h, 1e-6);
    const auto at = grid->getConstAccessor();
    long active = 0, unit = 0, inside = 0;
    for (auto it = grid->cbeginValueOn(); it; ++it) {
        ASSERT_LE(std::abs(*it), 3 * h * 1.0001);
        const auto c = it.getCoord();
        if (std::abs(*it) > 2 * h) continue;  // its neighbours are within the band
        Vec3d g;
        for (int d = 0; d < 3; ++d) {
            openvdb::Coord a = c, b = c;
            a[d] -= 1, b[d] += 1;
            g[d] = (at.getValue(b) - at.getValue(a)) / (2 * h);
        }
        active += 1, inside += *it < 0;
        unit += std::abs(g.length() - 1) < 0.1;
    }
    ASSERT_GT(active, 20000);
    EXPECT_GT(inside, active / 4);
    EXPECT_LT(inside, active * 3 / 4);
    EXPECT_GT(double(unit) / active, 0.85);  // creases, where two triangles are as near, have less

    // Over every column the surface is where the heights say; inside is below.
    const auto surface = surface_of(*grid, size);
    double mean = 0;
    for (size_t c = 0; c < surface.size(); ++c) mean += std::abs(surface[c] - field.height[c]) / double(surface.size());
    EXPECT_LT(mean, 0.1 * h);
    for (int i = 5; i < size[0] - 5; i += 7)
        for (int k = 5; k < size[2] - 5; k += 7) {
            const int j = int(std::lround((double(field.height[size_t(i * size[2] + k)]) - h / 2) / h));
            EXPECT_LT(at.getValue({i, j - 2, k}), 0);
            EXPECT_GT(at.getValue({i, j + 2, k}), 0);
        }
    EXPECT_LT(at.getValue({48, 3, 36}), 0);   // deep below the peak
    EXPECT_GT(at.getValue({48, 60, 36}), 0);  // high above
}

TEST(Mountain, HasTheHeightsOfItsFormula)
{
    // q = (1 - peak (1 - m)) (a + (1 - a) B), a = 0.1 peak, m = (1 - r^2)^(3/2), B = b scaled to 0..1,
    // b = (1 - ridges) n - 2 ridges |n|; then q is scaled to the ground and the relief.
    for (const auto& [ridges, peak] : {std::pair(0.0, 0.0), {1.0, 0.0}, {0.3, 1.0}, {0.6, 0.5}}) {
        MountainOptions o;
        o.ridges = ridges;
        o.peak = peak;
        o.relief = 0.3;
        Spectrum s;
        s.seed = 4;
        const auto field = mountain_heights(domain, size, s, o);
        const auto n = synthesize({size[0], 1, size[2]}, {4, 3, 3}, s);  // the unused side: the shorter of the two
        std::vector<double> q;
        const auto scaled = [&](double low, double high) {
            const auto [least, most] = std::minmax_element(q.begin(), q.end());
            const double from = *least, range = *most - from;
            for (double& v : q) v = low + (high - low) * (v - from) / range;
        };
        for (int i = 0; i < size[0]; ++i)
            for (int k = 0; k < size[2]; ++k)
                q.push_back((1 - ridges) * n(i, 0, k) - 2 * ridges * std::abs(n(i, 0, k)));
        scaled(0, 1);
        for (int i = 0; i < size[0]; ++i)
            for (int k = 0; k < size[2]; ++k) {
                const double x = (i + 0.5) / size[0] * 2 - 1, z = (k + 0.5) / size[2] * 2 - 1;
                const double m = std::pow(std::max(0.0, 1 - x * x - z * z), 1.5);
                double& v = q[size_t(i * size[2] + k)];
                v = (1 - peak * (1 - m)) * (0.1 * peak + (1 - 0.1 * peak) * v);
            }
        scaled(4 * h, 4 * h + 0.3 * 4);
        for (size_t c = 0; c < q.size(); ++c) ASSERT_NEAR(field.height[c], q[c], 1e-5) << ridges << ' ' << peak;
    }
}

TEST(Mountain, LosesReliefWhereTheBoxIsLow)
{
    const auto field = mountain_heights({{-2, 0, 1}, {2, 0.5, 4}}, {96, 12, 72}, {}, {});
    const auto [low, high] = std::minmax_element(field.height.begin(), field.height.end());
    EXPECT_NEAR(*low, 4 * h, 1e-5);
    EXPECT_NEAR(*high, 11 * h, 1e-5);  // a voxel below the high face
}

TEST(Mountain, HasTheReliefAndStandsInTheBox)
{
    MountainOptions o;
    o.relief = 0.25;
    for (int up : {0, 1, 2}) {
        o.up = up;
        const auto field = mountain_heights(domain, size, {}, o);
        ASSERT_EQ(field.height.size(), size_t(size.product() / size[up]));
        const auto [low, high] = std::minmax_element(field.height.begin(), field.height.end());
        EXPECT_NEAR(*low, domain.low[up] + 4 * h, 1e-5);
        EXPECT_NEAR(*high - *low, 0.25 * (up == 0 ? 3 : 4), 1e-5);
        // A peak is highest about the middle and lowest at the corners.
        const auto top = high - field.height.begin();
        EXPECT_LT(std::abs(top / field.columns() - field.rows() / 2), field.rows() / 4);
        EXPECT_LT(std::abs(top % field.columns() - field.columns() / 2), field.columns() / 4);
        EXPECT_NEAR(field.height.front(), *low, 1e-5);
    }
}

TEST(Mountain, HasEqualBitsForAnyThreadCountAndOthersForAnotherSeed)
{
    const auto values = [](uint64_t seed) {
        Spectrum s;
        s.seed = seed;
        const auto grid = mountain_grid(mountain_heights(domain, {48, 24, 36}, s, {}), 3);
        std::vector<float> out;
        for (auto it = grid->cbeginValueOn(); it; ++it) out.push_back(*it);
        return out;
    };
    const auto first = values(1);
    EXPECT_NE(values(2), first);
    for (int threads : {1, 2, 4}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(values(1), first) << threads << " threads";
    }
}

TEST(Mountain, RefusesOptionsOutsideTheirRange)
{
    MountainOptions o;
    o.relief = 0;
    EXPECT_THROW(mountain_heights(domain, size, {}, o), InputError);
    o.relief = 0.3, o.ridges = 2;
    EXPECT_THROW(mountain_heights(domain, size, {}, o), InputError);
    EXPECT_THROW(mountain_heights(domain, {96, 4, 72}, {}, {}), InputError);
    const auto uneven = mountain_heights(domain, {96, 30, 72}, {}, {});
    EXPECT_THROW(mountain_grid(uneven, 3), InputError);
    EXPECT_THROW(mountain_grid(mountain_heights(domain, size, {}, {}), 1), InputError);
}

}  // namespace
}  // namespace vdbcloud
