#pragma once
// Means of light paths with their standard errors, for the tests of Integrator::Path.
#include "render/pictures.h"
#include "support/size.h"
#include "vdbcloud/render/path.h"

#include <functional>

namespace vdbcloud::test {

/// A fixed seed decides each comparison once and for all; 4.5 standard errors leave a right program 7e-6 of being red.
inline constexpr double sigmas = 4.5;

/// The mean of independent samples and its standard error, by channel.
struct Estimate {
    Vec3d mean{0, 0, 0}, error{0, 0, 0};
};

/// `sample(k)` for k = 0 .. count - 1, a Vec3d each.
template<typename F>
Estimate estimate(int count, const F& sample)
{
    Vec3d sum(0), squares(0), mean(0);
    for (int k = 0; k < count; ++k) {
        const Vec3d x = sample(k), before = x - mean;
        mean += before / (k + 1);
        squares += before * (x - mean);
    }
    Estimate out{mean, Vec3d(0)};
    for (int c = 0; c < 3; ++c) out.error[c] = std::sqrt(squares[c] / (double(count) * (count - 1)));
    return out;
}

/// Which part of a sample is looked at.
using Part = std::function<Vec3d(const RayResult&)>;

inline Vec3d all_light(const RayResult& r)
{
    Vec3d sum = r.multiple + r.emission;
    for (const Vec3d& d : r.direct) sum += d;
    return sum;
}
inline Vec3d scattered_once(const RayResult& r)
{
    Vec3d sum(0);
    for (const Vec3d& d : r.direct) sum += d;
    return sum;
}

/// Samples of rays, one path each.
inline Estimate traced(const Scene& scene, int count, const std::function<WorldRay(int)>& ray,
                       const Part& part = all_light, uint64_t seed = 1)
{
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult result;
    return estimate(count, [&](int k) {
        trace(ray(k), PathRandom(seed, 3, 4, uint64_t(k)), result);
        return part(result);
    });
}

inline Estimate traced(const Scene& scene, int count, const WorldRay& ray, const Part& part = all_light,
                       uint64_t seed = 1)
{
    return traced(
        scene, count, [&](int) { return ray; }, part, seed);
}

/// The estimate has `expected` within its own standard errors and those of `expected`, and says enough: its error is
/// at most `share` of the value.
inline void expect_mean(const Estimate& found, const Vec3d& expected, double share, const Vec3d& its_error = Vec3d(0),
                        const std::string& what = "")
{
    for (int c = 0; c < 3; ++c) {
        const double error = std::hypot(found.error[c], its_error[c]);
        EXPECT_NEAR(found.mean[c], expected[c], sigmas * error + 1e-12 * std::abs(expected[c])) << what << " " << c;
        EXPECT_LT(error, share * std::abs(expected[c]) + 1e-300) << what << " says little, channel " << c;
    }
}

inline void expect_equal(const Estimate& a, const Estimate& b, double share, const std::string& what = "")
{
    expect_mean(a, b.mean, share, b.error, what);
}

/// A clumpy field of n^3 voxels of edge h about the origin, moved by `shift`.
inline FloatGridPtr clump(int n, double h, uint64_t seed = 1, const Vec3d& shift = Vec3d(0))
{
    auto grid = box(Vec3i(n), h, [&](openvdb::Coord ijk) { return clumps(ijk, seed, 1); });
    grid->transform().postTranslate(shift - Vec3d(0.5 * h * (n - 1)));
    return grid;
}

/// One clumpy volume of extinction `sigma_t` and phase function of mean cosine g.
inline Scene one_clump(const Vec3d& sigma_t, const Vec3d& albedo, double g)
{
    Scene scene;
    scene.volumes.push_back(volume_of(clump(20, 0.1), medium(sigma_t, albedo, g)));
    return scene;
}

/// An infinite layer, in effect: voxels a million times as wide as high. Thickness 1 along y, density 1 inside; the
/// trilinear fringe adds as much above and below as the outermost half voxels lack.
inline FloatGridPtr layer(int voxels = 4)
{
    auto grid = box({8, voxels, 8}, 1, [](openvdb::Coord) { return 1.0; });
    openvdb::Mat4d m = openvdb::Mat4d::identity();
    m.postTranslate(openvdb::Vec3d(-3.5, 0, -3.5));
    m.postScale(openvdb::Vec3d(1e6, 1.0 / voxels, 1e6));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    return grid;
}

}  // namespace vdbcloud::test
