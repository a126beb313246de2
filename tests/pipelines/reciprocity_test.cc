// Reciprocity in a heterogeneous cloud: a lamp and an isotropic detector change places, and the detector's fluence
// stays.
#include "render/path_estimates.h"
#include "support/size.h"
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <cmath>
#include <cstdio>

namespace vdbcloud {
namespace {

using namespace test;

/// Three puffs of optical depth 4 in [-1, 1]^3, cut to 0 at a tenth of their peak, in voxels of edge h.
FloatGridPtr three_puffs(double h)
{
    const int n = int(std::lround(2 / h));
    auto grid = box(Vec3i(n), h, [&](openvdb::Coord ijk) {
        const Vec3d x = h * (Vec3d(ijk[0], ijk[1], ijk[2]) + Vec3d(0.5)) - Vec3d(1);
        const auto puff = [&](const Vec3d& centre, double width) {
            return std::exp(-(x - centre).lengthSqr() / (2 * width * width));
        };
        const double all = puff(Vec3d(-0.3, -0.2, 0.1), 0.3) + 0.8 * puff(Vec3d(0.4, 0.2, -0.2), 0.25) +
                           0.6 * puff(Vec3d(0, 0.45, 0.4), 0.2);
        return std::max(0.0, all - 0.1);
    });
    grid->transform().postTranslate(Vec3d(0.5 * h - 1));
    return grid;
}

/// A place within a puff, another one at the edge of a puff, and one outside of the cloud.
const Vec3d places[] = {Vec3d(-0.34, -0.13, 0.07), Vec3d(0.58, 0.36, -0.17), Vec3d(0.7, -0.65, 0.4)};

Scene lit_from(const Vec3d& lamp, const FloatGridPtr& density, const Medium& m)
{
    Scene scene;
    scene.volumes.push_back(volume_of(density, m));
    scene.lights = {make_lamp(lamp)};
    return scene;
}

double uncollided(const Scene& scene, const Vec3d& at)
{
    const Vec3d way = scene.lights[0].place() - at;
    const Volume& v = scene.volumes[0];
    return std::exp(-v.medium.sigma_t_per_density[0] *
                    density_depth(BrickMap(*v.density), {at, way.unit()}, 0, way.length())) /
           way.lengthSqr();
}

/// A direction at the angle `theta` to `axis`.
Vec3d about(const Vec3d& axis, double theta, double turn)
{
    const Vec3d x = (std::abs(axis[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(axis).unit(), y = axis.cross(x);
    return std::cos(theta) * axis + std::sin(theta) * (std::cos(turn) * x + std::sin(turn) * y);
}

/// Fluence at `at`, from radiance gathered along rays. Radiance has a pole of the inverse angle towards the lamp, which
/// the sine of the angle cancels: the midpoint rule in both angles. Sets `scattered` to the part that is not straight.
double gathered(const Scene& scene, const Vec3d& at, double& scattered)
{
    IntegratorOptions how;
    how.shadow_rays = true;
    how.parts = 2;
    const PreparedScene prepared(scene, how);
    const auto integrate = make_cells_integrator(prepared, how);
    const Vec3d axis = (scene.lights[0].place() - at).unit();
    constexpr int rings = 32, spokes = 16;
    scattered = 0;
    RayResult r;
    for (int i = 0; i < rings; ++i)
        for (int k = 0; k < spokes; ++k) {
            const double theta = pi * (i + 0.5) / rings, turn = 2 * pi * (k + 0.5 * (i & 1)) / spokes;
            (*integrate)({at, about(axis, theta, turn)}, r);
            scattered += (r.direct[0][0] + r.multiple[0]) * std::sin(theta) * 2 * pi * pi / (rings * spokes);
        }
    return uncollided(scene, at) + scattered;
}

Medium isotropic(double sigma_t, double albedo) { return medium(Vec3d(sigma_t), Vec3d(albedo), 0); }

double solved(const FloatGridPtr& density, const Medium& m, const Vec3d& lamp, const Vec3d& at, double& scattered)
{
    Scene scene = lit_from(lamp, density, m);
    ScatterOptions options;
    options.closure.iterations = 12;
    options.closure.directions = 64;
    options.closure.change = 1e-5;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    scene.volumes[0].collided = scatter_p1(*density, nullptr, nullptr, m, scene.lights, options, {}, report);
    return gathered(scene, at, scattered);
}

Estimate traced_fluence(const FloatGridPtr& density, const Medium& m, const Vec3d& lamp, const Vec3d& at, int count)
{
    const Scene scene = lit_from(lamp, density, m);
    const PathScene prepared(scene);
    PathTracer trace(prepared);
    RayResult r;
    const Vec3d axis = (lamp - at).unit();
    const double straight = uncollided(scene, at);
    return estimate(count, [&](int k) {
        const double theta = pi * uniform(hash_bits(51, uint64_t(k))),
                     turn = 2 * pi * uniform(hash_bits(52, uint64_t(k)));
        trace({at, about(axis, theta, turn)}, PathRandom(1, 0, 0, uint64_t(k)), r);
        return all_light(r) * (2 * pi * pi * std::sin(theta)) + Vec3d(straight);
    });
}

TEST(Reciprocity, OfTheSolvedCloudHoldsToAnErrorThatFallsWithTheVoxel)
{
    // 1.4, 0.7 and 0.35 mean free paths a voxel at the densest place. The error is that of voxels around the lamp and
    // of the beam within them, which is of first order: it halves with the voxel.
    const Medium m = isotropic(9, 0.95);
    std::vector<double> rms;
    for (int n = 12; n <= sized(24, 48); n *= 2) {
        const auto density = three_puffs(2.0 / n);
        double squares = 0;
        for (size_t a = 0; a < 3; ++a)
            for (size_t b = 0; b < a; ++b) {
                double scattered;
                const double there = solved(density, m, places[a], places[b], scattered);
                EXPECT_GT(scattered, 0.5 * there) << "scattered light decides";
                const double back = solved(density, m, places[b], places[a], scattered), error = there / back - 1;
                std::printf("%d^3, places %zu and %zu: %.5g and back %.5g, %+.2f %%\n", n, a, b, there, back,
                            100 * error);
                squares += error * error / 3;
            }
        rms.push_back(std::sqrt(squares));
    }
    EXPECT_LT(rms[0], 0.16);
    EXPECT_GT(rms[0], 0.02) << "two different solutions are compared";
    for (size_t k = 1; k < rms.size(); ++k) EXPECT_LT(rms[k], 0.6 * rms[k - 1]);
}

TEST(Reciprocity, OfLightPathsHoldsWithinTheirErrors)
{
    const Medium m = isotropic(9, 0.95);
    const auto density = three_puffs(2.0 / 24);
    for (size_t a = 0; a < 3; ++a)
        for (size_t b = 0; b < a; ++b) {
            const int count = sized(11000, 500000);
            const Estimate there = traced_fluence(density, m, places[a], places[b], count),
                           back = traced_fluence(density, m, places[b], places[a], count);
            expect_equal(there, back, 0.15, std::to_string(a) + std::to_string(b));
            // The solved cloud, in both directions, errs by 4 %.
            double scattered;
            const double solution = std::sqrt(solved(density, m, places[a], places[b], scattered) *
                                              solved(density, m, places[b], places[a], scattered));
            const double error = std::hypot(there.error[0], back.error[0]) / 2;
            EXPECT_NEAR(solution, (there.mean[0] + back.mean[0]) / 2, sigmas * error + 0.04 * solution);
        }
}

}  // namespace
}  // namespace vdbcloud
