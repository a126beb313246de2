// Rays that ask the few blocks which shade their tile, against rays that walk through the void.
#include "support/voxel_field.h"
#include "swept_medium.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/void_rays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace vdbcloud {
namespace {

/// Voxels of their own, at random in a cube of `extent` voxels.
test::SweptMedium scattered(int count, int extent)
{
    std::vector<std::pair<Vec3i, Vec3i>> voxels;
    for (int n = 0; n < count; ++n) {
        Vec3i at;
        for (int a = 0; a < 3; ++a) at[a] = int(extent * uniform(hash_bits(31, uint64_t(n), uint64_t(a))));
        voxels.push_back({at, at});
    }
    test::SweptMedium m(test::voxel_clouds(voxels, Vec3d(1.0, 0.8, 1.3), 0.7));
    m.add_source([](const Vec3i& p) { return 1 + std::sin(0.7 * p.x() - 0.2 * p.z()); });
    return m;
}

TEST(Shadows, RaysThatAskBlocksEndWhereRaysThatWalkDo)
{
    // Towards corners, edges and middles of blocks, along diagonals and along the axes.
    const test::SweptMedium m = scattered(60, 160);
    const Blocks& blocks = m.index.blocks();
    const VoidRays rays(blocks);
    std::vector<int32_t> all(blocks.count());
    std::iota(all.begin(), all.end(), 0);
    int met = 0, apart = 0;
    for (uint64_t n = 0; n < 20000; ++n) {
        const auto draw = [&](uint64_t k) { return uniform(hash_bits(5, n, k)); };
        Vec3d step, target;
        for (int a = 0; a < 3; ++a) {
            step[a] = n % 4 == 0 ? int(3 * draw(uint64_t(a))) - 1 : 2 * draw(uint64_t(a)) - 1;
            const double in_block = n % 3 == 0 ? 8 * int(2 * draw(3 + uint64_t(a))) : 8 * draw(3 + uint64_t(a));
            target[a] = 8 * blocks.at(size_t(double(blocks.count()) * draw(9)))[a] + in_block - 0.5;
        }
        if (step.length() == 0) continue;
        const Vec3d from = target + step * (40 + 64 * int(4 * draw(7)));
        if (rays.find(Vec3i(int(std::floor((from[0] + 0.5) / 8)), int(std::floor((from[1] + 0.5) / 8)),
                            int(std::floor((from[2] + 0.5) / 8)))) >= 0)
            continue;
        const auto walked = rays.trace(from, step), asked = rays.trace(from, step, all.data(), all.size());
        // Which side of an edge a walk passes is rounding where it crosses a large empty cell.
        const bool edge = n % 3 == 0 || n % 4 == 0;
        if (edge && asked.block != walked.block) {
            ++apart;
            continue;
        }
        ASSERT_EQ(asked.block, walked.block) << n << ' ' << from << ' ' << step;
        if (walked.block < 0) continue;
        ++met;
        ASSERT_TRUE(edge || asked.axes == walked.axes) << n;
        for (int a = 0; a < 3; ++a) ASSERT_NEAR(asked.at[a], walked.at[a], 1e-6) << n;
    }
    EXPECT_GT(met, 5000);
    EXPECT_LT(apart, met / 20);
}

TEST(Shadows, SumsOverPlanesOfScatteredVoxelsAreThoseOfAllCells)
{
    const test::SweptMedium m = scattered(60, 160);
    SweepSet set = test::set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0.3);
    SweepResult result;
    PlaneLight sums, cells;
    sums.by_cell = false;
    TransportSweep sweep(m.index, m.faces);
    sweep.run(set, m.fields(), result, &sums);
    sweep.run(set, m.fields(), result, &cells);
    EXPECT_GT(sums.tests, 0u);
    EXPECT_EQ(cells.tests, 0u);
    for (size_t face = 0; face < 6; ++face)
        for (size_t n = 0; n < set.count(); ++n) {
            const double whole = cells.medium_along[face][n] + cells.sky_along[face][n];
            EXPECT_NEAR(sums.medium_along[face][n], cells.medium_along[face][n], 1e-9 * whole) << face << ' ' << n;
            EXPECT_NEAR(sums.sky_along[face][n], cells.sky_along[face][n], 1e-6 * whole) << face << ' ' << n;
        }
}

TEST(Shadows, RaysCostTheBlocksThatShadeThemAndNotTheEmptinessBetween)
{
    // Shadows of 200 blocks seldom overlap on planes of 1250^2 tiles: one block to ask for a ray.
    const test::SweptMedium m = scattered(200, 10000);
    SweepResult result;
    PlaneLight sums;
    sums.by_cell = false;
    TransportSweep(m.index, m.faces)
        .run(test::set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0.3), m.fields(), result, &sums);
    EXPECT_GE(sums.tests, 64 * sums.traced) << "every ray asks";
    EXPECT_LT(double(sums.tests), 1.05 * 64 * double(sums.traced));
}

}  // namespace
}  // namespace vdbcloud
