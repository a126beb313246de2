// What light of emission by rays is made of: depths of segments, the tree of emitting voxels, light from near voxels.
#include "scatter/fields.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/scatter/emission_gather.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::P1Case;
using test::voxel_field;

TEST(SegmentDepth, IsTheIntegralOfTheTrilinearDensity)
{
    // Bricks of one value, bricks of many, and gaps; rays within, into and out of each.
    const auto grid = voxel_field(Vec3i(40), Vec3d(0.5), [](const Vec3i& p) {
        return p.x() < 20 ? 0.25 : p.y() < 24 ? uniform(hash_bits(3, p.x(), p.y(), p.z())) : 0.0;
    });
    const BrickMap map(*grid);
    const SegmentDepth depth(map, 3);
    for (uint64_t k = 0; k < 200; ++k) {
        Vec3d a, b;
        for (uint64_t c = 0; c < 3; ++c) {
            a[int(c)] = 22 * uniform(hash_bits(5, k, c)) - 1;
            b[int(c)] = 22 * uniform(hash_bits(6, k, c)) - 1;
        }
        const double length = (b - a).length(), exact = 3 * density_depth(map, {a, (b - a) / length}, 0, length);
        EXPECT_NEAR(depth(a, b, 1e9), exact, 1e-9 * (1 + exact));
        EXPECT_GT(depth(a, b, 1), std::min(exact, 1.0) - 1e-9) << "may end early";
    }
}

TEST(EmissionTree, NodesHoldTheMomentsOfTheirVoxels)
{
    const Vec3i n(9, 6, 7);
    const P1Case c(voxel_field(n, Vec3d(1, 2, 0.5), [](const Vec3i&) { return 1.0; }));
    std::vector<float> red(c.index.blocks().slots(), 0.0f), blue = red, sigma = red;
    for (size_t slot = 0; slot < red.size(); ++slot) {
        if (!c.index.blocks().active(slot) || slot % 3 == 0) continue;
        red[slot] = float(uniform(hash_bits(1, slot)));
        blue[slot] = slot % 2 ? float(uniform(hash_bits(2, slot))) : 0.0f;
        sigma[slot] = float(uniform(hash_bits(3, slot)));
    }
    const EmissionTree tree(c.index, {&red, &blue}, sigma);
    ASSERT_GT(tree.nodes().size(), 200u);
    for (const EmissionNode& node : tree.nodes()) {
        double power[2] = {0, 0}, rate = 0, spread = 0;
        Vec3d mean[2] = {Vec3d(0.0), Vec3d(0.0)}, both(0.0);
        const auto each = [&](const auto& f) {
            for (int x = node.low[0]; x <= node.high[0]; ++x)
                for (int y = node.low[1]; y <= node.high[1]; ++y)
                    for (int z = node.low[2]; z <= node.high[2]; ++z)
                        f(c.index.blocks().slot(Vec3i(x, y, z)), Vec3d(x, 2 * y, 0.5 * z));
        };
        each([&](size_t slot, const Vec3d& at) {
            power[0] += red[slot];
            power[1] += blue[slot];
            mean[0] += red[slot] * at;
            mean[1] += blue[slot] * at;
            rate += (red[slot] + blue[slot]) * sigma[slot];
            both += (red[slot] + blue[slot]) * at;
        });
        const double all = power[0] + power[1];
        both /= all;
        each([&](size_t slot, const Vec3d& at) {
            const Vec3d apart = at - both;
            spread += (red[slot] + blue[slot]) / all * apart[0] * apart[2];
        });
        for (size_t k = 0; k < 2; ++k) {
            EXPECT_NEAR(node.power[k], power[k], 1e-5 * (1 + power[k])) << "a voxel's volume is 1";
            if (power[k] == 0) continue;
            EXPECT_NEAR((Vec3d(node.centre) + Vec3d(node.offset[k]) - mean[k] / power[k]).length(), 0, 1e-4);
        }
        EXPECT_NEAR((Vec3d(node.centre) - both).length(), 0, 1e-4);
        EXPECT_NEAR(node.sigma, rate / all, 1e-5);
        EXPECT_NEAR(node.spread[4], spread, 1e-4) << "x and z";
    }
}

TEST(NearEmission, OfAUniformMediumIsTheLightOfTheSegments)
{
    // Emission of the middle layer of 3^3 voxels in a thick medium: 4 pi j / sigma, but for e^-tau of a voxel and a
    // half.
    const NearEmission near(Vec3d(1.0), 1);
    NearEmission::Field emission, sigma;
    for (const double tau : {12.0, 40.0}) {
        emission.fill(float(2 * tau));
        sigma.fill(float(tau));
        double moments[4] = {};
        near.add(emission, sigma, moments);
        EXPECT_NEAR(moments[0] * std::sqrt(4 * pi) / (8 * pi), 1, 1e-4);
        for (int k = 1; k < 4; ++k) EXPECT_NEAR(moments[k], 0, 1e-5) << "no flux";
    }
    // One voxel in clear air: light falls from the middle outwards, and the tents of equal neighbours look alike.
    sigma.fill(0);
    emission.fill(0);
    emission[62] = 1;
    double own[4] = {}, beside[4] = {}, opposite[4] = {};
    near.add(emission, sigma, own);
    // The mean over directions of the integral of (1 - |x|)(1 - |y|)(1 - |z|) along a ray. Four samples a voxel err by
    // up to 6 % of it along diagonals, 128 directions by less.
    double tent = 0;
    const int turns = 64, steps = 100;
    for (int a = 0; a < turns; ++a)
        for (int b = 0; b < turns; ++b) {
            const double z = (a + 0.5) / turns, turn = (b + 0.5) / turns * pi / 2;
            const Vec3d s(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
            for (int k = 0; k < steps; ++k) {
                const Vec3d x = s * (1.75 * (k + 0.5) / steps);
                tent += std::max(1 - x[0], 0.0) * std::max(1 - x[1], 0.0) * std::max(1 - x[2], 0.0) * 1.75 / steps;
            }
        }
    tent /= turns * turns;
    EXPECT_NEAR(own[0] * std::sqrt(4 * pi) / (4 * pi) / tent, 1, 0.03);
    std::swap(emission[62], emission[62 + 25]);
    near.add(emission, sigma, beside);
    std::swap(emission[62 + 25], emission[62 - 25]);
    near.add(emission, sigma, opposite);
    // Light from +x travels along -x.
    EXPECT_LT(beside[3], -0.5 * beside[0]);
    EXPECT_NEAR(beside[3], -opposite[3], 1e-6);
    EXPECT_NEAR(beside[0], opposite[0], 1e-6);
    EXPECT_NEAR(beside[1], 0, 1e-6);
}

}  // namespace
}  // namespace vdbcloud
