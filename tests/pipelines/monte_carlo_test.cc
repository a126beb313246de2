// P1 and its closure by sweeps, as pictures, against path tracing of a heterogeneous cloud with true voids.
#include "vdbcloud/core/random.h"
#include "vdbcloud/render/media.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "support/monte_carlo.h"
#include "support/size.h"
#include "support/voxel_field.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr int voxels = 48, pixels = 24, puffs = 14;

/// Gaussian puffs cut off at a threshold, in a cube of edge 1.
double density_at(const Vec3d& x)
{
    double sum = 0;
    for (uint64_t k = 0; k < puffs; ++k) {
        const Vec3d centre(0.25 + 0.5 * uniform(hash_bits(1, k)), 0.25 + 0.5 * uniform(hash_bits(2, k)), 0.25 + 0.5 * uniform(hash_bits(3, k)));
        const double d = (x - centre).length() / (0.05 + 0.07 * uniform(hash_bits(4, k)));
        sum += std::exp(-d * d);
    }
    return sum > 0.15 ? sum - 0.1 : 0.0;
}

struct View {
    Vec3d direction;
    WorldRay ray(double u, double v) const
    {
        const Vec3d at = direction[1] == 0 ? Vec3d(u, v, 0.5) : Vec3d(u, 0.5, v);
        return {at - direction, direction};
    }
};
const View views[3] = {{Vec3d(0, -1, 0)}, {Vec3d(0, 0, -1)}, {Vec3d(0, 1, 0)}};  // from above, the side, below

struct Mean {
    double value = 0, deviation = 0;  // of the picture, and its standard error
};

class MonteCarlo : public testing::Test {
protected:
    MonteCarlo()
        : grid(test::voxel_field(Vec3i(voxels), Vec3d(1.0 / voxels),
                                 [](const Vec3i& p) { return density_at((Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / voxels); })),
          bricks(*grid)
    {
        double tau = 0;
        for (int i = 0; i < voxels; ++i)
            for (int k = 0; k < voxels; ++k) {
                double column = 0;
                for (int j = 0; j < voxels; ++j) {
                    const double rho = bricks.sample(Vec3d(i, j, k));
                    column += rho / voxels;
                    densest = std::max(densest, rho);
                }
                tau = std::max(tau, column);
            }
        kappa = 15 / tau;  // the thickest vertical optical depth is 15
        sun.to_light = Vec3d(0.3, 1, 0.2).unit();
    }

    Mean traced(const View& view, double w0, double g, int samples) const
    {
        const test::McMedium medium{&bricks, kappa, densest * 1.0001, w0, g, sun.to_light};
        std::vector<double> sum(pixels * pixels), square(pixels * pixels);
        tbb::parallel_for(0, pixels * pixels, [&](int p) {
            for (int k = 0; k < samples; ++k) {
                const uint64_t path = uint64_t(p) * uint64_t(samples) + uint64_t(k);
                const WorldRay ray = view.ray((p / pixels + uniform(hash_bits(7, path))) / pixels, (p % pixels + uniform(hash_bits(8, path))) / pixels);
                const double radiance = test::radiance_sample(medium, ray, 2.5, 9, path);
                sum[size_t(p)] += radiance / samples;
                square[size_t(p)] += radiance * radiance / samples;
            }
        });
        Mean mean;
        for (size_t p = 0; p < sum.size(); ++p) {
            mean.value += sum[p];
            mean.deviation += (square[p] - sum[p] * sum[p]) / samples;
        }
        mean.deviation = std::sqrt(mean.deviation);
        return mean;
    }

    /// Sums of the pictures of the three views.
    std::array<double, 3> solved(double w0, double g, int iterations, int directions, int degree) const
    {
        Medium medium;
        medium.sigma_t_per_density = Vec3d(kappa);
        medium.albedo = Vec3d(w0);
        medium.g = g;
        ScatterOptions options;
        options.closure.iterations = iterations;
        options.closure.directions = directions;
        options.closure.degree = degree;
        options.reentry_rays = options.line_rays = 0;
        ScatterReport report;
        const ScatterFields fields = scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
        Scene scene;
        scene.lights = {sun};
        scene.volumes.resize(1);
        Volume& volume = scene.volumes[0];
        volume.density = grid;
        volume.medium = medium;
        volume.phi = fields.phi;
        volume.flux = fields.flux;
        volume.moments = fields.moments;
        volume.moment_scale = fields.moment_scale;
        volume.forward = g > 0 ? std::pow(g, degree + 1) : 0;
        volume.mean_cosine = (g - volume.forward) / (1 - volume.forward);
        IntegratorOptions how;
        how.shadow_rays = true;
        const PreparedScene prepared(scene, how);
        std::array<double, 3> total{};
        for (size_t v = 0; v < 3; ++v) {
            std::vector<double> rows(pixels, 0.0);
            tbb::parallel_for(0, pixels, [&](int i) {
                const auto integrate = make_cells_integrator(prepared, how);
                RayResult result;
                for (int j = 0; j < pixels; ++j)
                    for (int s = 0; s < 4; ++s) {
                        (*integrate)(views[v].ray((i + 0.25 + 0.5 * (s & 1)) / pixels, (j + 0.25 + 0.5 * (s >> 1)) / pixels), result);
                        rows[size_t(i)] += (result.direct[0][0] + result.multiple[0]) / 4;
                    }
            });
            for (double row : rows) total[v] += row;
        }
        return total;
    }

    FloatGridPtr grid;
    BrickMap bricks;
    double densest = 0, kappa = 1;
    Light sun;
};

TEST_F(MonteCarlo, AgreesWithSweepsWhereP1IsOff)
{
    // 48 voxels across, up to 1.6 mean free paths each: what is left at 3 sweeps is mostly the voxels' own error.
    const auto p1 = solved(0.99, 0, 0, 32, 1), swept = solved(0.99, 0, 3, 32, 1);
    for (size_t v = 0; v < 3; ++v) {
        const Mean truth = traced(views[v], 0.99, 0, test::sized(72, 400));
        EXPECT_LT(std::abs(swept[v] / truth.value - 1), 0.07) << v;
        EXPECT_GT(std::abs(p1[v] / truth.value - 1), 0.08) << v;
        EXPECT_LT(truth.deviation / truth.value, 0.012) << v;
    }
}

TEST_F(MonteCarlo, AgreesWithSweepsWhereLightGoesForward)
{
    const auto swept = solved(1, 0.85, 5, 64, 3);
    for (size_t v = 0; v < 3; ++v) {
        const Mean truth = traced(views[v], 1, 0.85, test::sized(96, 800));
        EXPECT_NEAR(swept[v] / truth.value, 1, 0.07 + 2 * truth.deviation / truth.value) << v;
        EXPECT_LT(truth.deviation / truth.value, 0.08) << v;
    }
}

}  // namespace
}  // namespace vdbcloud
