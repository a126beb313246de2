// Transport sweeps that close P1: symmetry, light between two bodies, and a tint against an albedo.
#include "scatter/sweep_cases.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbcloud {
namespace {

using test::billows;
using test::Lit;
using test::options;
using test::P1Case;
using test::Result;
using test::solve;

TEST(SecondMoment, SolutionHasTheSymmetriesOfTheDirections)
{
    // A ball lit by a sky of one radiance: 48 images of each voxel with a level-symmetric set, 16 with a product set
    // about y.
    P1Case c(test::voxel_field(Vec3i(16), Vec3d(1.0 / 16), [](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) - Vec3d(7.5)) / 8;
        return std::max(0.0, 1 - x.dot(x));
    }));
    Lit lit;
    lit.sigma = 8;
    lit.w0 = 0.9;
    lit.sun = 0;
    lit.sky = 1;
    for (OrdinateKind kind : {OrdinateKind::LevelSymmetric, OrdinateKind::Product}) {
        ClosureOptions o = options(kind == OrdinateKind::Product ? 64 : 80, 3, 1, 1e-9);
        o.kind = kind;
        o.solve_share = 0;  // what the solver leaves has no symmetry
        const Result r = solve(c, lit, o);
        double worst = 0;
        for (int n = 0; n < 16 * 16 * 16; ++n) {
            const Vec3i p(n / 256, n / 16 % 16, n % 16);
            const double own = r.phi[c.index.blocks().slot(p)];
            std::array<int, 3> axes{0, 1, 2};
            do {
                if (kind == OrdinateKind::Product && axes[1] != 1) continue;
                for (int signs = 0; signs < 8; ++signs) {
                    Vec3i image;
                    for (int a = 0; a < 3; ++a)
                        image[a] = signs >> a & 1 ? 15 - p[axes[size_t(a)]] : p[axes[size_t(a)]];
                    worst = std::max(worst, std::abs(r.phi[c.index.blocks().slot(image)] - own));
                }
            } while (std::next_permutation(axes.begin(), axes.end()));
        }
        EXPECT_LT(worst, 2e-6 * 4 * pi) << int(kind);  // single-precision sums in different orders
        EXPECT_GT(r.budget.largest - r.budget.smallest, 0.5);
    }
}

/// Two cubes of 16 voxels edge, `gap` voxels apart; the first emits. Returns the mean phi of the second cube.
double second_cube(int gap, double sigma, double emission_of_first)
{
    const int far = 16 + gap;
    P1Case c(test::voxel_clouds({{Vec3i(0, 0, 0), Vec3i(15, 15, 15)}, {Vec3i(far, 0, 0), Vec3i(far + 15, 15, 15)}},
                                Vec3d(1.0 / 16), 1.0));
    const P1Operator plain(c.index, c.density, c.exposed, {sigma, 0.5, nullptr, test::hg(0), true, 1});
    const auto open = closure_exposed(plain, c.exposed);
    const P1Operator p1(c.index, c.density, open, {sigma, 0.5, nullptr, test::hg(0), true, 1});
    std::vector<float> j(c.index.blocks().slots(), 0.0f);
    for (size_t slot = 0; slot < c.index.blocks().count() * 512; ++slot)
        if (c.index.blocks().active(slot) && c.index.blocks().voxel(slot).x() < 16) j[slot] = float(emission_of_first);
    ClosureOptions o = options(512, 12, 1, 1e-6);
    SecondMoment closure(p1, o, {0, false});
    closure.add_emission(j, 1);
    P1Source base(p1);
    add_emission(p1, j, 1, base);
    Multigrid multigrid(p1.stencil());
    std::vector<double> phi(c.index.blocks().slots(), 0.0);
    EXPECT_TRUE(closure.run(multigrid, {}, base, phi).converged);
    double sum = 0;
    for (size_t slot = 0; slot < c.index.blocks().count() * 512; ++slot)
        if (c.index.blocks().active(slot) && c.index.blocks().voxel(slot).x() >= far) sum += phi[slot] / 4096;
    return sum;
}

TEST(SecondMoment, LightBetweenTwoCubesMatchesTheIntegral)
{
    // Optically thin cubes (tau 0.08): the second cube's phi is int int j / r^2 over both volumes. 512 directions
    // resolve a cube at 2 edges' distance by some 20 beams; P1 alone gives the second cube no light.
    constexpr int n = 8, gap = 32;
    double exact = 0;
    for (int a = 0; a < n * n * n; ++a)
        for (int b = 0; b < n * n * n; ++b) {
            const auto point = [](int k) { return (Vec3d(k / (n * n), k / n % n, k % n) + Vec3d(0.5)) / n; };
            const Vec3d d = point(b) + Vec3d(1 + gap / 16.0, 0, 0) - point(a);
            exact += 1 / d.dot(d) / std::pow(n, 6);
        }
    EXPECT_NEAR(second_cube(gap, 0.08, 1.0) / exact, 1, 0.05);
}

TEST(SecondMoment, UniformTintMatchesUniformAlbedo)
{
    // A uniform tint equals a uniform albedo, through scatter_p1 and at the scaling of every degree. Densities are
    // scaled before interpolation, so the results differ by single precision only.
    const auto grid = test::voxel_field(Vec3i(24), Vec3d(1.0 / 24), [](const Vec3i& p) { return billows(p, 24); });
    const auto tint = test::constant_like(*grid, Vec3f(0.9f, 0.9f, 0.9f));
    Medium medium;
    medium.sigma_t_per_density = Vec3d(40);
    medium.phase = test::hg(0.8);
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    for (int degree : {1, 3, 5}) {
        ScatterOptions o;
        o.closure = options(64, 15, degree, 1e-5);
        o.reentry_rays = o.line_rays = 0;
        ScatterReport tinted, plain;
        medium.albedo = Vec3d(1);
        scatter_p1(*grid, tint.get(), nullptr, medium, {sun}, o, {}, tinted);
        medium.albedo = Vec3d(double(0.9f));
        scatter_p1(*grid, nullptr, nullptr, medium, {sun}, o, {}, plain);
        const ChannelReport &a = tinted.channel[0], &b = plain.channel[0];
        EXPECT_TRUE(a.closure.converged);
        EXPECT_NEAR(a.budget.absorbed / b.budget.absorbed, 1, 2e-4) << degree;
        EXPECT_NEAR(a.planes.reflected / b.planes.reflected, 1, 2e-4) << degree;
        EXPECT_NEAR(a.planes.transmitted() / b.planes.transmitted(), 1, 2e-4) << degree;
        EXPECT_NEAR(a.budget.largest / b.budget.largest, 1, 1e-3) << degree;
        EXPECT_LT(a.budget.defect, 1e-6);
    }
}

}  // namespace
}  // namespace vdbcloud
