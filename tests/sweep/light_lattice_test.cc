// The light lattice at what it costs, and the depth of voxels far from one another.
#include "vdbcloud/sweep/light_lattice.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

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
