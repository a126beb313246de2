// The light lattice at what it costs, and the depth of voxels far from one another.
#include "vdbcloud/sweep/light_lattice.h"

#include "support/voxel_field.h"
#include "swept_medium.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/sweep/lattice_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// The lattice without its arrays: the depth at a target from the four rays about it, each an exact ray through the
/// trilinear density, in double.
double by_exact_rays(const BrickMap& density, const LightModel& sun, const Vec3d& target, int rays_per_voxel)
{
    double sum = 0;
    const auto frames = frames_of(density, *sun.common_direction());
    for (const LatticeFrame& f : frames) {
        const double w = f.sign * target[f.w];
        const double a = (target[f.u] - f.mu * w) * rays_per_voxel, b = (target[f.v] - f.mv * w) * rays_per_voxel;
        for (int corner = 0; corner < 4; ++corner) {
            const double p = std::floor(a) + (corner & 1), q = std::floor(b) + (corner >> 1);
            Vec3d place = target;
            place[f.u] = p / rays_per_voxel + f.mu * w;
            place[f.v] = q / rays_per_voxel + f.mv * w;
            sum += (1 - std::abs(a - p)) * (1 - std::abs(b - q)) *
                   depth_to_light(density, sun, density.world_from_index().point(place));
        }
    }
    return sum / double(frames.size());
}

/// The deepest single-precision sum of a step has 27 taps; then the depth is rounded to single precision.
constexpr double relative_error = 29.0 / (1 << 24);

TEST(LightLattice, SetsOfTargetsAreThoseOfExactRays)
{
    // Salt and pepper, targets on both sides of the border between tiles of rays (31 voxels), and offsets within, on
    // and beyond planes of voxels, as beams need them.
    const BrickMap density(*test::voxel_field(Vec3i(37, 34, 36), Vec3d(0.5, 0.25, 0.4),
                                              [](const Vec3i& p) { return test::clumps(p, 5, 0.4); }));
    std::vector<Vec3i> some{Vec3i(0, 0, 0), Vec3i(3, 3, 3), Vec3i(3, 0, 1), Vec3i(1, -1, 3)}, one{Vec3i(0, 1, 3)};
    const std::vector<LatticeTargets> fixed{{Vec3d(0, 0, 0), some},         {Vec3d(-0.5, 0, 0), some},
                                            {Vec3d(0, -0.5, 0), some},      {Vec3d(0, 0, -0.5), some},
                                            {Vec3d(0.9, 0.3, -0.2), one},   {Vec3d(-0.9, -0.3, 0.2), one},
                                            {Vec3d(-1.2, -1.0, 0.4), some}, {Vec3d(0.1, 1.3, 1.499), one}};
    for (const Vec3d& to_light : {Vec3d(0.3, 1, 0.2), Vec3d(-0.9, 0.1, 0.4), Vec3d(0, 0, -1), Vec3d(1, -0.5, 0.8)}) {
        const Light sun = make_sun(to_light);
        // Along the light the position across it stays that of a ray, but for rounding.
        const Vec3d along = density.index_from_world().vector(to_light).unit();
        std::vector<LatticeTargets> sets = fixed;
        for (double step : {1.0, -1.0, 0.3}) {
            sets.push_back({step * along, some});
            sets.push_back({Vec3d(0, 0, 0.5) + step * along, some});
        }
        for (int rays_per_voxel : {1, 3}) {
            const auto depth = lattice_depths(density, *sun->common_direction(), sets, rays_per_voxel);
            double deepest = 0;
            for (size_t s = 0; s < sets.size(); ++s)
                for (size_t n = 0; n < depth[s].size(); ++n) {
                    const Vec3i voxel =
                        sets[s].blocks[n / 512] * 8 + Vec3i(int(n / 64 % 8), int(n / 8 % 8), int(n % 8));
                    const Vec3d target = Vec3d(voxel[0], voxel[1], voxel[2]) + sets[s].offset;
                    const double expected = by_exact_rays(density, *sun, target, rays_per_voxel);
                    deepest = std::max(deepest, expected);
                    ASSERT_NEAR(depth[s][n], expected, relative_error * expected + 1e-9)
                        << to_light << ' ' << rays_per_voxel << " set " << s << " voxel " << voxel;
                }
            EXPECT_GT(deepest, 0.5);
        }
    }
}

TEST(LightLattice, TransmittanceErrsByLessThanAMillionth)
{
    // The error of exp(-depth) is at most relative_error times depth exp(-depth) <= 1 / e.
    EXPECT_LT(relative_error / std::exp(1.0), 1e-6);
    for (double place : {0.0, 0.25, 0.77})
        for (double mu : {0.0, 0.4, 1.0, -1.0, 1 + 1e-8})
            for (double mv : {0.0, -0.7, 1.0, -1 - 1e-8}) {
                const LatticeFrame frame{2, 1, 0, 1, mu, mv, 1.5};
                for (double w0 : {0.0, 0.3, -2.5}) {
                    const LatticeTaps taps = step_taps(frame, place + mu * w0, 0.1 + mv * w0, w0);
                    EXPECT_LE(taps.count, 27);
                    double length = 0;
                    for (int k = 0; k < taps.count; ++k) length += taps.tap[size_t(k)].weight;
                    EXPECT_NEAR(length, 1.5, 1e-12) << "weights of a medium of density 1";
                }
            }
}

TEST(LightLattice, CostsTheVoxelsThatAreNotEmptyWhereverTheyLie)
{
    // A voxel meets the rays within a voxel of it: four phases, some planes and some taps each, some tens of products.
    // A tile of rays through its brick would be millions.
    std::vector<std::pair<Vec3i, Vec3i>> voxels;
    std::vector<Vec3i> blocks;
    for (int n = 0; n < 27; ++n) {
        const Vec3i at(600 * (n / 9) + 3, 600 * (n / 3 % 3) + 4, 600 * (n % 3) + 5);
        voxels.emplace_back(at, at);
        blocks.push_back(Vec3i(at[0] >> 3, at[1] >> 3, at[2] >> 3));
    }
    const BrickMap density(*test::voxel_clouds(voxels, Vec3d(0.5), 1.0));
    std::atomic<size_t> products{0};
    LatticeOptions options;
    options.products = &products;
    const auto depth = lattice_depths(density, Vec3d(0, 1, 0), blocks, options);
    EXPECT_GT(products, 27 * 10u);
    EXPECT_LT(products, 27 * 100u);
    for (size_t n = 0; n < 27; ++n) {
        // Half of the voxel is above its centre. Voxels higher up add half a unit each.
        const double above = 0.5 * (2 - int(n / 3 % 3));
        EXPECT_NEAR(depth[n * 512 + 3 * 64 + 4 * 8 + 5], 0.25 + above, 1e-6) << n;
        EXPECT_NEAR(depth[n * 512 + 3 * 64 + 2 * 8 + 5], 0.5 + above, 1e-6) << n;
        EXPECT_NEAR(depth[n * 512 + 3 * 64 + 6 * 8 + 5], above, 1e-6) << n;
    }
}

}  // namespace
}  // namespace vdbcloud
