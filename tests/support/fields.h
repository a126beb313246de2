#pragma once
// Small density grids with known values, and a reference integral of their interpolant without the library's code.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbcloud::test {

/// n[0] x n[1] x n[2] voxels that begin at the origin, voxel edge h [world unit], value f(Coord).
template<typename F>
FloatGridPtr box(const Vec3i& n, double h, F f)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    auto accessor = grid->getAccessor();
    for (int x = 0; x < n[0]; ++x)
        for (int y = 0; y < n[1]; ++y)
            for (int z = 0; z < n[2]; ++z)
                accessor.setValueOn(openvdb::Coord(x, y, z), float(f(openvdb::Coord(x, y, z))));
    return grid;
}

/// A clumpy, smooth field with holes: about half of the voxels are 0, the others have values up to `top`.
inline double clumps(const openvdb::Coord& ijk, uint64_t seed, double top)
{
    const auto phase = [&](int n) { return 6.28 * uniform(hash_bits(seed, uint64_t(n))); };
    const double v = std::sin(0.41 * ijk[0] + phase(0)) + std::sin(0.37 * ijk[1] + phase(1)) +
                     std::sin(0.43 * ijk[2] + phase(2)) + std::sin(0.23 * (ijk[0] + ijk[1] - ijk[2]) + phase(3)) +
                     0.3 * uniform(hash_bits(seed, uint64_t(uint32_t(ijk[0])), uint64_t(uint32_t(ijk[1])),
                                             uint64_t(uint32_t(ijk[2]))));
    return v > 0.3 ? top * std::min(1.0, (v - 0.3) / 1.5) : 0.0;
}

/// A random point on the unit sphere.
inline Vec3d direction(uint64_t seed)
{
    const double z = 2 * uniform(hash_bits(seed, 1)) - 1, a = 2 * pi * uniform(hash_bits(seed, 2));
    return Vec3d(std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z);
}

/// The trilinear interpolant by its definition, in double precision (OpenVDB's sampler rounds to float).
template<typename Accessor>
double trilinear(const Accessor& accessor, const Vec3d& p)
{
    const openvdb::Coord low = openvdb::Coord::floor(p);
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
        const int d[3] = {c & 1, (c >> 1) & 1, c >> 2};
        double weight = 1;
        for (int a = 0; a < 3; ++a) weight *= d[a] ? p[a] - low[a] : 1 - (p[a] - low[a]);
        sum += weight * accessor.getValue(low.offsetBy(d[0], d[1], d[2]));
    }
    return sum;
}

/// The integral of the trilinear interpolant along a ray. Between two crossings with planes of voxel centres the
/// interpolant is a cubic, which three Gauss points integrate exactly.
inline double integral_of_interpolant(const FloatGrid& grid, const WorldRay& ray, double t0, double t1)
{
    const auto& transform = grid.transform();
    const Vec3d o = transform.worldToIndex(ray.origin), d = transform.worldToIndex(ray.at(1)) - o;
    const auto box = grid.evalActiveVoxelBoundingBox();
    std::vector<double> cuts{t0, t1};
    for (int a = 0; a < 3; ++a)
        for (int plane = box.min()[a] - 1; plane <= box.max()[a] + 1 && d[a] != 0; ++plane)
            if (const double t = (plane - o[a]) / d[a]; t > t0 && t < t1) cuts.push_back(t);
    std::sort(cuts.begin(), cuts.end());
    const auto accessor = grid.getConstAccessor();
    double sum = 0;
    for (size_t n = 0; n + 1 < cuts.size(); ++n) {
        const double mid = (cuts[n] + cuts[n + 1]) / 2, half = (cuts[n + 1] - cuts[n]) / 2;
        const Vec3d centre = o + mid * d;
        if (centre[0] < box.min()[0] - 1 || centre[0] > box.max()[0] + 1 || centre[1] < box.min()[1] - 1 ||
            centre[1] > box.max()[1] + 1 || centre[2] < box.min()[2] - 1 || centre[2] > box.max()[2] + 1)
            continue;
        const double x[3] = {-0.7745966692414834, 0, 0.7745966692414834}, w[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
        for (int q = 0; q < 3; ++q) sum += w[q] * half * trilinear(accessor, o + (mid + x[q] * half) * d);
    }
    return sum;
}

}  // namespace vdbcloud::test
