// Power by column and by voxel: closed forms of absorbing media, orientation of the map, sums against the report.
#include "scatter/sweep_cases.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::billows;

Medium coloured(double sigma_t, const Vec3d& albedo, double g = 0)
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(sigma_t);
    medium.albedo = albedo;
    medium.phase = test::hg(g);
    return medium;
}

ScatterOptions with_results(int iterations = 0)
{
    ScatterOptions o;
    o.flux_map = o.heating = true;
    o.closure.iterations = iterations;
    return o;
}

size_t pixel(const FluxMap& map, int x, int y) { return size_t(y) * size_t(map.width) + size_t(x); }

/// Sum over the voxels of a channel of `heating`, times their volume.
double heat(const GridBasePtr& grid, int channel)
{
    const Vec3d h = grid->transform().voxelSize();
    double sum = 0;
    if (const auto floats = openvdb::gridPtrCast<FloatGrid>(grid))
        for (auto v = floats->cbeginValueOn(); v; ++v) sum += double(*v);
    else
        for (auto v = openvdb::gridPtrCast<Vec3SGrid>(grid)->cbeginValueOn(); v; ++v) sum += double((*v)[channel]);
    return sum * h[0] * h[1] * h[2];
}

TEST(FluxMap, OfAnAbsorbingBoxIsTheExponentialOfEachColumn)
{
    // Columns of 24 voxels and different density under a sun overhead: direct light exp(-tau), the rest absorbed.
    const int n = 24;
    const double h = 1.0 / n;
    const auto tau_of = [](const Vec3i& p) { return p.x() < 8 ? 0.5 : 2.0; };
    const auto grid = test::voxel_field(Vec3i(16, n, 12), Vec3d(h), [&](const Vec3i& p) { return tau_of(p); });
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0)), {make_sun(Vec3d(0, 1, 0), Vec3d(3, 1, 1))},
               with_results(), {}, report);
    const FluxMap& map = *report.flux_map;
    ASSERT_EQ(map.width, 16);
    ASSERT_EQ(map.height, 12);
    for (int x = 0; x < 16; ++x)
        for (int y = 0; y < 12; ++y) {
            const size_t at = pixel(map, x, y);
            const double through = std::exp(-tau_of(Vec3i(x, 0, y)));
            for (const auto& [c, e] : {std::pair(size_t(0), 3.0), {2, 1.0}}) {
                const FluxMap::Channel& channel = map.channel[c];
                ASSERT_NEAR(channel.direct_top[at], e, 1e-6);
                ASSERT_NEAR(channel.direct_base[at], e * through, 1e-6) << x << ' ' << y;
                ASSERT_NEAR(channel.absorbed[at], e * (1 - through), 2e-3 * e) << "by the light lattice";
                ASSERT_EQ(channel.diffuse_up[at], 0);
                ASSERT_EQ(channel.diffuse_down[at], 0);
            }
        }
    EXPECT_NEAR(power_of(map, map.channel[1].direct_top), 16 * 12 * h * h, 1e-6);
    EXPECT_NEAR(heat(report.heating, 1) / report.channel[1].budget.absorbed, 1, 1e-6);
    EXPECT_NEAR(heat(report.heating, 0) / heat(report.heating, 1), 3, 1e-6);
    EXPECT_NEAR(report.channel[1].budget.absorbed, h * h * 96 * ((1 - std::exp(-0.5)) + (1 - std::exp(-2.0))), 1e-4);
}

TEST(FluxMap, SlantedLightIsThatOfTheLineToTheSun)
{
    // A periodic layer of optical depth 1.2 under a sun of cosine 0.6.
    const auto grid = test::voxel_field(Vec3i(8, 16, 8), Vec3d(1.0 / 16), [](const Vec3i&) { return 1.2; });
    ScatterOptions o = with_results();
    o.periodic = {true, false, true};
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0.5)), {make_sun(Vec3d(0.8, 0.6, 0))}, o, {}, report);
    const FluxMap::Channel& channel = report.flux_map->channel[0];
    for (size_t n = 0; n < 64; ++n) {
        ASSERT_NEAR(channel.direct_top[n], 0.6, 1e-6);
        ASSERT_NEAR(channel.direct_base[n], 0.6 * std::exp(-2.0), 1e-6);
        ASSERT_NEAR(channel.diffuse_up[n] + channel.diffuse_down[n] + channel.absorbed[n], 0.6 * (1 - std::exp(-2.0)),
                    1e-5);
    }
    // From below all is the other way round: light goes up.
    ScatterReport below;
    scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0.5)), {make_sun(Vec3d(0.8, -0.6, 0))}, o, {}, below);
    const FluxMap::Channel& other = below.flux_map->channel[0];
    EXPECT_NEAR(other.direct_base[9], -0.6, 1e-6);
    EXPECT_NEAR(other.direct_top[9], -0.6 * std::exp(-2.0), 1e-6);
    EXPECT_NEAR(other.diffuse_down[9], channel.diffuse_up[9], 1e-5);
    o.periodic = {true, true, true};
    EXPECT_THROW(scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0.5)), {}, o, {}, below), InputError);
}

/// A thin box whose voxel column (5, 2) across index axis y is dense; the grid's index y axis is `y` in the world.
FloatGridPtr marked(const Vec3d& x, const Vec3d& y, const Vec3d& z)
{
    return test::voxel_field(Vec3i(12, 6, 9), 0.1 * x, 0.1 * y, 0.1 * z,
                             [](const Vec3i& p) { return p.x() == 5 && p.z() == 2 ? 50.0 : 0.01; });
}

TEST(FluxMap, SaysWhereItsColumnsAre)
{
    struct Case {
        Vec3d x, y, z, up;
        int top;
    };
    for (const Case& of : {Case{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, Blocks::YPlus},
                           {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 1, 0}, Blocks::YMinus},
                           {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, Blocks::YPlus}}) {
        const auto grid = marked(of.x, of.y, of.z);
        ScatterOptions o = with_results();
        o.up = of.up;
        ScatterReport report;
        scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0.5)), {make_sun(of.up)}, o, {}, report);
        const FluxMap& map = *report.flux_map;
        EXPECT_EQ(map.top, of.top);
        EXPECT_EQ(report.top, of.top);
        ASSERT_EQ(map.width, 12);
        ASSERT_EQ(map.height, 9);
        for (int x = 0; x < 12; ++x)
            for (int y = 0; y < 9; ++y) {
                const FluxMap::Channel& channel = map.channel[0];
                EXPECT_EQ(channel.direct_base[pixel(map, x, y)] < 0.1, x == 5 && y == 2) << x << ' ' << y;
                EXPECT_EQ(channel.absorbed[pixel(map, x, y)] > 0.1, x == 5 && y == 2) << x << ' ' << y;
                EXPECT_NEAR(channel.direct_top[pixel(map, x, y)], 1, 1e-6);
            }
        const Vec3d place = map.first + 5 * map.step_x + 2 * map.step_y;
        const bool down = of.y.dot(of.up) < 0;
        const Vec3d expected = 0.1 * (5 * of.x + 2 * of.z + (down ? 5.5 : -0.5) * of.y);
        EXPECT_LT((place - expected).length(), 1e-6) << "the base of the dense column";
    }
}

TEST(FluxMap, SumsToThePowersOfTheReport)
{
    const auto grid = test::voxel_field(Vec3i(30, 21, 26), Vec3d(0.04, 0.05, 0.06),
                                        [](const Vec3i& p) { return std::max(billows(p, 30) - 0.1, 0.0); });
    const auto tint = test::constant_like(*grid, Vec3f(0.9f, 0.8f, 0.95f));
    for (auto v = tint->beginValueOn(); v; ++v)
        if (v.getCoord().x() % 3 == 0) v.setValue(Vec3f(0.5f, 0.9f, 1.0f));
    const std::vector<Light> lights{make_sun(Vec3d(0.9, 0.4, 0.2), Vec3d(1, 2, 3)), make_lamp(Vec3d(0.5, 0.4, 0.7))};
    for (const int iterations : {0, 3}) {
        ScatterOptions o = with_results(iterations);
        o.sky = Sky::constant(Vec3d(0.1));
        ScatterReport report;
        scatter_p1(*grid, tint.get(), nullptr, coloured(20, Vec3d(0.95, 0.99, 1), 0.5), lights, o, {}, report);
        const FluxMap& map = *report.flux_map;
        EXPECT_EQ(report.heating->valueType(), "vec3s");
        for (int c = 0; c < 3; ++c) {
            const ChannelReport& r = report.channel[size_t(c)];
            const FluxMap::Channel& channel = map.channel[size_t(c)];
            EXPECT_NEAR(power_of(map, channel.diffuse_up) / r.planes.out[Blocks::YPlus], 1, 1e-6);
            EXPECT_NEAR(power_of(map, channel.diffuse_down) / r.planes.out[Blocks::YMinus], 1, 1e-6);
            EXPECT_NEAR(power_of(map, channel.absorbed) / r.budget.absorbed, 1, 1e-5);
            EXPECT_NEAR(heat(report.heating, c) / r.budget.absorbed, 1, 1e-5);
            EXPECT_GT(r.budget.absorbed, 0.01 * r.deposited);
            double in = r.deposited, out = r.budget.absorbed + r.planes.reentered;
            for (size_t face = 0; face < 6; ++face) {
                in += r.planes.sky_in[face];
                out += r.planes.out[face];
            }
            EXPECT_NEAR(out / in, 1, 1e-6) << iterations;
            EXPECT_EQ(r.planes.reentered > 0.01 * in, iterations == 0) << "P1 alone loses what enters again";
            EXPECT_GT(power_of(map, channel.direct_base), 0.1 * r.deposited) << "sun and lamp";
        }
    }
}

TEST(FluxMap, ChannelsThatShareASolutionAreMultiples)
{
    const auto grid = test::voxel_field(Vec3i(12), Vec3d(0.1), [](const Vec3i& p) { return billows(p, 12) + 0.1; });
    ScatterReport report, alone;
    scatter_p1(*grid, nullptr, nullptr, coloured(10, Vec3d(0.9)), {make_sun(Vec3d(0, 1, 1), Vec3d(1, 0.25, 3))},
               with_results(1), {}, report);
    scatter_p1(*grid, nullptr, nullptr, coloured(10, Vec3d(0.9)), {make_sun(Vec3d(0, 1, 1), Vec3d(0.25))},
               with_results(1), {}, alone);
    EXPECT_EQ(report.solves, 1);
    EXPECT_EQ(report.heating->valueType(), "vec3s");
    EXPECT_EQ(alone.heating->valueType(), "float") << "white light in a grey medium";
    for (const FluxMapLayer& layer : flux_map_layers())
        for (size_t n = 0; n < 144; ++n)
            ASSERT_NEAR((report.flux_map->channel[1].*layer.values)[n], (alone.flux_map->channel[0].*layer.values)[n],
                        1e-6)
                << layer.name;
    EXPECT_NEAR(heat(report.heating, 1), heat(alone.heating, 0), 1e-6);
}

TEST(Heating, OfALampInABlackVoxelIsItsPower)
{
    // 4 pi at intensity 1, all of it absorbed: no light scatters, and little leaves 20 mean free paths.
    const auto grid = test::voxel_field(Vec3i(15), Vec3d(0.2), [](const Vec3i&) { return 10.0; });
    ScatterOptions o;
    o.heating = true;
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, coloured(1, Vec3d(0)), {make_lamp(Vec3d(1.43, 1.38, 1.41))}, o, {}, report);
    EXPECT_NEAR(heat(report.heating, 0), 4 * pi, 0.001);
    EXPECT_NEAR(heat(report.heating, 0) / report.channel[0].budget.absorbed, 1, 1e-6);
    EXPECT_FALSE(report.flux_map);
}

}  // namespace
}  // namespace vdbcloud
