#include "support/puffs.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {

namespace {

constexpr int voxels = 48, puffs = 14;

double density_at(const Vec3d& x)
{
    double sum = 0;
    for (uint64_t k = 0; k < puffs; ++k) {
        const Vec3d centre(0.25 + 0.5 * uniform(hash_bits(1, k)), 0.25 + 0.5 * uniform(hash_bits(2, k)),
                           0.25 + 0.5 * uniform(hash_bits(3, k)));
        const double d = (x - centre).length() / (0.05 + 0.07 * uniform(hash_bits(4, k)));
        sum += std::exp(-d * d);
    }
    return sum > 0.15 ? sum - 0.1 : 0.0;
}

}  // namespace

FloatGridPtr cloud_of_puffs()
{
    return voxel_field(Vec3i(voxels), Vec3d(1.0 / voxels),
                       [](const Vec3i& p) { return density_at((Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / voxels); });
}

double extinction_of_puffs(const FloatGrid& grid, double tau)
{
    double thickest = 0;
    for (int i = 0; i < voxels; ++i)
        for (int k = 0; k < voxels; ++k) {
            double column = 0;
            for (int j = 0; j < voxels; ++j) column += double(grid.tree().getValue(openvdb::Coord(i, j, k))) / voxels;
            thickest = std::max(thickest, column);
        }
    return tau / thickest;
}

}  // namespace vdbcloud::test
