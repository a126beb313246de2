#include "support/reference_clouds.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud::test {

namespace {

constexpr int voxels = 48;

/// Where Gaussians may stand and how wide they are: from `low` and up to `more` further along each axis, the same for
/// the radius. Random but fixed, by `seed`.
struct Gaussians {
    uint64_t seed, count;
    double low, more, radius, more_radius;

    double operator()(const Vec3d& x) const
    {
        double sum = 0;
        for (uint64_t k = 0; k < count; ++k) {
            const auto place = [&](uint64_t axis) { return low + more * uniform(hash_bits(seed + axis, k)); };
            const Vec3d centre(place(0), place(1), place(2));
            const double d = (x - centre).length() / (radius + more_radius * uniform(hash_bits(seed + 3, k)));
            sum += std::exp(-d * d);
        }
        return sum;
    }
};
constexpr Gaussians puffs{1, 14, 0.25, 0.5, 0.05, 0.07}, blobs{21, 6, 0.32, 0.36, 0.11, 0.085};

FloatGridPtr sampled(const std::function<double(const Vec3d&)>& density)
{
    return voxel_field(Vec3i(voxels), Vec3d(1.0 / voxels),
                       [&](const Vec3i& p) { return density((Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / voxels); });
}

}  // namespace

FloatGridPtr cloud_of_puffs()
{
    return sampled([](const Vec3d& x) {
        const double density = puffs(x);
        return density > 0.15 ? density - 0.1 : 0.0;
    });
}

FloatGridPtr cloud_of_blobs()
{
    double peak = 0;
    for (int n = 0; n < voxels * voxels * voxels; ++n)
        peak = std::max(peak,
                        blobs((Vec3d(n / (voxels * voxels), n / voxels % voxels, n % voxels) + Vec3d(0.5)) / voxels));
    return sampled([&](const Vec3d& x) {
        const double density = blobs(x);
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
