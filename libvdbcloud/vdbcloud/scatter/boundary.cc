#include "vdbcloud/scatter/boundary.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace vdbcloud {

namespace {

constexpr int reach = 2;  // half-width of the gradient's window [voxels]

/// Density of the 27 blocks about a block, looked up once.
struct Surroundings {
    Surroundings(const Blocks& blocks, size_t block)
    {
        for (int n = 0; n < 27; ++n)
            base[n] = size_t(blocks.find(blocks.at(block) + Vec3i(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1))) * 512;
    }
    /// The slot of a voxel given relative to the middle block, -8..15.
    size_t slot(int x, int y, int z) const
    {
        return base[((x >> 3) + 1) * 9 + ((y >> 3) + 1) * 3 + (z >> 3) + 1] +
               size_t((x & 7) * 64 + (y & 7) * 8 + (z & 7));
    }
    size_t base[27];
};

/// Direction of the density's gradient, up to a positive factor: first moments under a smooth round window.
Vec3d gradient(const VoxelIndex& index, const std::vector<float>& density, const Surroundings& around, size_t in_block)
{
    const int x = int(in_block / 64), y = int(in_block / 8 % 8), z = int(in_block % 8);
    Vec3d g(0, 0, 0);
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k) {
                const double u = 1 - (i * i + j * j + k * k) / 9.0;
                if (u <= 0) continue;
                const double w = u * u * density[around.slot(x + i, y + j, z + k)];
                g += Vec3d(w * i, w * j, w * k);
            }
    return g / index.spacing();
}

}  // namespace

std::vector<ExposedVoxel> exposed_voxels(const VoxelIndex& index, const std::vector<float>& density)
{
    const Blocks& blocks = index.blocks();
    std::vector<std::vector<ExposedVoxel>> found(blocks.count());
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        const Surroundings around(blocks, b);
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot) {
            if (!blocks.active(slot)) continue;
            ExposedVoxel voxel{uint32_t(slot), 0, {1, 1, 1}, 0};
            for (int face = 0; face < 6; ++face)
                if (!blocks.active(blocks.neighbour(slot, face))) voxel.faces |= uint8_t(1 << face);
            if (!voxel.faces) continue;
            const Vec3d g = gradient(index, density, around, slot % 512);
            const double length = g.length();
            if (length * index.spacing()[0] > 1e-6 * density[slot])
                for (int a = 0; a < 3; ++a) voxel.weight[a] = float(std::abs(g[a]) / length);
            found[b].push_back(voxel);
        }
    });
    std::vector<ExposedVoxel> all;
    for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace vdbcloud
