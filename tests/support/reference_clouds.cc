#include "support/reference_clouds.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::test {

namespace {

constexpr int voxels = 48, puffs = 14, blobs = 6;

double density_of_puffs(const Vec3d& x)
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

double density_of_blobs(const Vec3d& x)
{
    double sum = 0;
    for (uint64_t k = 0; k < blobs; ++k) {
        const Vec3d centre(0.32 + 0.36 * uniform(hash_bits(21, k)), 0.32 + 0.36 * uniform(hash_bits(22, k)),
                           0.32 + 0.36 * uniform(hash_bits(23, k)));
        const double d = (x - centre).length() / (0.11 + 0.085 * uniform(hash_bits(24, k)));
        sum += std::exp(-d * d);
    }
    return sum;
}

FloatGridPtr sampled(const std::function<double(const Vec3d&)>& density)
{
    return voxel_field(Vec3i(voxels), Vec3d(1.0 / voxels),
                       [&](const Vec3i& p) { return density((Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / voxels); });
}

}  // namespace

FloatGridPtr cloud_of_puffs() { return sampled(density_of_puffs); }

FloatGridPtr cloud_of_blobs()
{
    double peak = 0;
    for (int n = 0; n < voxels * voxels * voxels; ++n)
        peak = std::max(
            peak,
            density_of_blobs((Vec3d(n / (voxels * voxels), n / voxels % voxels, n % voxels) + Vec3d(0.5)) / voxels));
    return sampled([&](const Vec3d& x) {
        const double density = density_of_blobs(x);
        return density < 0.15 * peak ? 0.0 : density;
    });
}

FloatGridPtr at_half_the_voxel(const FloatGrid& cloud)
{
    const auto at = cloud.getConstAccessor();
    auto fine = voxel_field(Vec3i(2 * voxels + 2), Vec3d(0.5 / voxels), [&](const Vec3i& fine_voxel) {
        double sum = 0;
        for (int n = 0; n < 8; ++n) {  // of the eight centres about a fine one
            openvdb::Coord from;
            double weight = 1;
            for (int a = 0; a < 3; ++a) {
                const int p = fine_voxel[a] - 1, near = (p + 2) / 2 - 1, aside = p & 1 ? near + 1 : near - 1;
                from[a] = n >> a & 1 ? aside : near;
                weight *= n >> a & 1 ? 0.25 : 0.75;
            }
            sum += weight * double(at.getValue(from));
        }
        return sum;
    });
    const auto transform = fine->transform().copy();  // fine voxel 0 is three quarters of a voxel before voxel 0
    transform->postTranslate(cloud.indexToWorld(openvdb::Vec3d(-0.75)) - fine->indexToWorld(openvdb::Vec3d(0.0)));
    fine->setTransform(transform);
    return fine;
}

double extinction_for(const FloatGrid& grid, double tau)
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
