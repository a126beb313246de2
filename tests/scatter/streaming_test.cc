// The bound of P1's diffusion in thin media, and the fluence that sweeps leave in dark places by it.
#include "scatter/sweep_cases.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/streaming.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::voxel_field;

std::vector<float> limit_of(const test::P1Case& c, double g)
{
    const P1Operator p1(c.index, c.density, c.exposed, {1, 0.5, nullptr, test::hg(g), true, 1});
    return streaming_limit(p1, {1, false});
}

TEST(StreamingLimit, IsTheMeanWayToTheSurfaceInClearAir)
{
    // In the middle of a clear cube of edge 1 the mean over directions of the way to its surface is 0.6106: the
    // integral of 1 / (2 max |s_a|). 16 directions err by 11 %. At the middle of a face half the directions see matter.
    const int n = 15;
    const double sigma = 1e-3;
    const test::P1Case c(voxel_field(Vec3i(n), Vec3d(1.0 / n), [&](const Vec3i&) { return sigma; }));
    double way = 0;
    const int turns = 200;
    for (int a = 0; a < turns; ++a)
        for (int b = 0; b < turns; ++b) {
            const double z = (a + 0.5) / turns, turn = (b + 0.5) / turns * pi / 4,
                         x = std::sqrt(1 - z * z) * std::cos(turn);
            way += 0.5 / std::max(x, z) / (turns * turns);
        }
    const auto factor = limit_of(c, 0.4);
    const double sigma_tr = sigma * (1 - 0.5 * 0.4);
    EXPECT_NEAR(factor[c.index.blocks().slot(Vec3i(7, 7, 7))] / (10 * way * sigma_tr), 1, 0.13);
    const double on_face = factor[c.index.blocks().slot(Vec3i(0, 7, 7))] / (10 * way * sigma_tr);
    EXPECT_GT(on_face, 0.5);
    EXPECT_LT(on_face, 0.9);
}

TEST(StreamingLimit, LeavesDiffusionInMatterAsItIs)
{
    // Voxels of 1/4 and of 4 mean free paths, the surface's among them. In a corner light comes from 1/8 of all
    // directions, and from the voxel's own half.
    for (const double sigma : {4.0, 64.0}) {
        const test::P1Case c(voxel_field(Vec3i(16), Vec3d(1.0 / 16), [&](const Vec3i&) { return sigma; }));
        const auto factor = limit_of(c, 0);
        for (size_t slot = 0; slot < c.index.blocks().count() * Blocks::size; ++slot)
            if (c.index.blocks().active(slot)) {
                ASSERT_GE(factor[slot], sigma < 10 ? 0.95 : 1.0) << sigma;
            }
    }
}

TEST(StreamingLimit, KeepsFluencePositiveBehindBendsOfADuct)
{
    // Kobayashi's third problem in voxels of 10 cm, one mean free path of the shield: a source in the middle of a clear
    // duct with bends. By P1's own D the imbalance of a sweep at the bends reached the ends of the ducts, where the
    // fluence is 1e-4 of the source's, and made it negative in 376 voxels.
    const auto kind = [](const Vec3i& p) {
        const double x = std::abs(p.x() - 5.5), y = std::abs(p.y() - 9.5), z = std::abs(p.z() - 5.5);
        if (x < 1 && y < 1 && z < 1) return 2;
        const bool bend = y > 5 && y < 6;
        const bool duct = (x < 1 && y < 6 && z < 1) || (x < 4 && bend && z < 1) || (x > 3 && x < 4 && bend && z < 4) ||
                          (x > 3 && x < 4 && y > 5 && z > 3 && z < 4);
        return duct ? 1 : 0;
    };
    const auto density =
        voxel_field(Vec3i(12, 20, 12), Vec3d(1.0), [&](const Vec3i& p) { return kind(p) == 1 ? 1e-3 : 1.0; });
    auto source = Vec3SGrid::create(Vec3f(0.0f));
    source->setTransform(density->transform().copy());
    for (auto v = density->cbeginValueOn(); v; ++v)
        if (kind(Vec3i(v.getCoord().x(), v.getCoord().y(), v.getCoord().z())) == 2)
            source->tree().setValueOn(v.getCoord(), Vec3f(1.0f));
    Medium medium;
    medium.sigma_t_per_density = Vec3d(1.0);
    medium.albedo = Vec3d(0.5);
    for (const int degree : {1, 3}) {
        ScatterOptions o;
        o.closure.iterations = 10;
        o.closure.directions = 32;
        o.closure.degree = degree;
        o.reentry_rays = 0;
        medium.phase = test::hg(degree == 1 ? 0 : 0.5);
        ScatterReport report;
        const auto light = scatter_p1(*density, nullptr, source.get(), medium, {}, o, {}, report);
        const ChannelReport& r = report.channel[0];
        EXPECT_TRUE(r.closure.converged);
        EXPECT_EQ(r.budget.negative, 0) << r.budget.smallest;
        EXPECT_GT(r.budget.smallest, 0);
        EXPECT_LT(r.budget.defect, 1e-6);
        // Light falls along the last leg, to the medium's end.
        const auto phi = openvdb::gridPtrCast<FloatGrid>(light.phi);
        double before = phi->tree().getValue(openvdb::Coord(9, 15, 9));
        for (int y = 16; y < 20; ++y) {
            const double here = phi->tree().getValue(openvdb::Coord(9, y, 9));
            EXPECT_GT(here, 0.2 * before) << y;
            EXPECT_LT(here, before) << y;
            before = here;
        }
    }
}

}  // namespace
}  // namespace vdbcloud
