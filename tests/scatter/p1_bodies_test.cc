// P1 in bodies against closed forms: spheres, the white furnace, moments of a point source, facing sheets.
#include "scatter/p1_solve.h"
#include "support/p1_forms.h"
#include "support/size.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::bumpy;
using test::P1Case;
using test::P1Sphere;
using test::solve;
using test::Solved;

/// Relative error of phi at the centre of a voxel sphere of R voxels, for a uniform source.
double sphere_error(int R, double sigma_R, double w0, bool sky)
{
    const int n = 2 * R + 2;
    const double h = 1.0 / R, sigma = sigma_R;
    const Vec3d centre(n / 2 - 0.5);
    P1Case c(test::voxel_field(Vec3i(n), Vec3d(h), [&](const Vec3i& p) {
        return (Vec3d(p.x(), p.y(), p.z()) - centre).length() < R ? 1.0 : 0.0;
    }));
    const P1Operator p1(c.index, c.density, c.exposed, {sigma, w0, nullptr, test::hg(0), true});
    P1Source source(p1);
    std::vector<float> one(c.index.blocks().slots(), 1.0f);
    if (sky)
        add_sky(p1, 1 / (4 * pi), source);
    else
        add_emission(p1, one, 1 / (4 * pi), source);
    const Solved s = solve(p1, source, 1e-8);
    const P1Sphere exact{1.0, 1 / (3 * sigma), sigma * (1 - w0), sky ? 0.0 : 1.0, sky ? 1.0 : 0.0};
    double error = 0;
    for (int k = 0; k < 8; ++k) {
        const Vec3i p(n / 2 - 1 + (k & 1), n / 2 - 1 + (k >> 1 & 1), n / 2 - 1 + (k >> 2));
        const double r = (Vec3d(p.x(), p.y(), p.z()) - centre).length() * h;
        error = std::max(error, std::abs(s.phi[c.index.blocks().slot(p)] / exact.phi(r) - 1));
    }
    return error;
}

TEST(Sphere, VoxelisedSphereConvergesToTheClosedForm)
{
    for (double tau : {1.0, 8.0}) {
        const double e8 = sphere_error(8, tau, 1, false), e16 = sphere_error(16, tau, 1, false),
                     e32 = sphere_error(32, tau, 1, false);
        EXPECT_LT(e8, 0.05);
        EXPECT_LT(e32, 0.005);  // seen: 3.7, 1.3, 0.2 %, then -0.1 % at 64
        EXPECT_LT(e32, e16 / 2);
        EXPECT_LT(e16, e8 / 2);
        if (test::full_size()) {
            EXPECT_LT(sphere_error(64, tau, 1, false), 0.003);
        }
    }
    EXPECT_LT(sphere_error(32, 4, 0.9, false), 0.015);
    EXPECT_LT(sphere_error(32, 4, 0.9, true), 0.015);
}

TEST(Furnace, IsExactInAnyDensityFromAZeroGuess)
{
    const std::pair<const char*, FloatGridPtr> cases[] = {
        {"salt and pepper with voids",
         test::voxel_field(Vec3i(20, 22, 18), Vec3d(0.1), [](const Vec3i& p) { return bumpy(p, 3); })},
        {"thin as 1e-12", test::voxel_field(Vec3i(16), Vec3d(1), [](const Vec3i&) { return 1e-12; })},
        {"100 a voxel", test::voxel_field(Vec3i(16), Vec3d(1), [](const Vec3i&) { return 100.0; })},
        {"one voxel", test::voxel_field(Vec3i(1), Vec3d(1), [](const Vec3i&) { return 1.0; })},
        {"two clouds far apart",
         test::voxel_field(Vec3i(200, 4, 4), Vec3d(1),
                           [](const Vec3i& p) { return p.x() < 5 || p.x() > 190 ? 1.0 : 0.0; })},
        {"stretched voxels",
         test::voxel_field(Vec3i(16), Vec3d(0.1, 0.3, 1), [](const Vec3i& p) { return bumpy(p, 5); })},
    };
    for (const auto& [name, grid] : cases)
        for (double g : {0.0, 0.85, 0.99, -0.9}) {
            P1Case c(grid);
            const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(g), true});
            P1Source source(p1);
            add_sky(p1, 0.7, source);
            const Solved s = solve(p1, source, 1e-6, 400);
            EXPECT_TRUE(s.solve.converged) << name << " g " << g << " residual " << s.solve.residual;
            double error = 0;
            for (size_t slot = 0; slot < c.index.blocks().count() * 512; ++slot)
                if (c.index.blocks().active(slot)) error = std::max(error, std::abs(s.phi[slot] / (4 * pi * 0.7) - 1));
            EXPECT_LT(error, 1e-4) << name << " g " << g;
            EXPECT_LT(s.budget.defect, 1e-6) << name;
        }
}

TEST(Moments, PointSourceMomentsAreExact)
{
    // Far enough for the boundary not to matter: exp(-k r) with k^2 = 3 (1-w0)(1-w0 g).
    const int n = 47;
    const double h = 0.5, w0 = 0.5;
    for (double g : {0.0, 0.6, -0.3}) {
        P1Case c(test::voxel_field(Vec3i(n), Vec3d(h), [](const Vec3i&) { return 1.0; }));
        const P1Operator p1(c.index, c.density, c.exposed, {1, w0, nullptr, test::hg(g), true});
        P1Source source(p1);
        const Vec3i middle(n / 2);
        source.rhs[c.index.blocks().slot(middle)] = 1 / (h * h);
        const Solved s = solve(p1, source);
        double zeroth = 0, second = 0;
        for (size_t slot = 0; slot < c.index.blocks().count() * 512; ++slot) {
            if (!c.index.blocks().active(slot)) continue;
            const Vec3i d = c.index.blocks().voxel(slot) - middle;
            zeroth += s.phi[slot] * h * h * h;
            second += s.phi[slot] * h * h * h * h * h * double(d.lengthSqr());
        }
        // The discrete second moment is exact at any h: the stencil's second moment is 2 h^2 D / h^2 per axis.
        EXPECT_NEAR(zeroth * (1 - w0), 1, 1e-3);
        EXPECT_NEAR(second * (1 - w0) * (1 - w0) * (1 - w0 * g) / 2, 1, 1e-3) << g;
    }
}

TEST(ReentryShare, IsZeroForASphereAndHalfForFacingSheets)
{
    const auto share = [](const FloatGridPtr& grid) {
        P1Case c(grid);
        const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(0), true});
        P1Source source(p1);
        const std::vector<double> phi(c.index.blocks().slots(), 1.0);
        return reentry_share(p1, source, phi, 20000);
    };
    const Vec3d middle(15.5);
    EXPECT_LT(share(test::voxel_field(
                  Vec3i(32), Vec3d(1),
                  [&](const Vec3i& p) { return (Vec3d(p.x(), p.y(), p.z()) - middle).length() < 15 ? 1.0 : 0.0; })),
              0.01);
    // Wide sheets of two voxels, 6 apart: nearly all light of the inner sides hits again, about half of the total.
    EXPECT_NEAR(share(test::voxel_field(Vec3i(96, 10, 96), Vec3d(1),
                                        [](const Vec3i& p) { return p.y() < 2 || p.y() > 7 ? 1.0 : 0.0; })),
                0.45, 0.06);
}

}  // namespace
}  // namespace vdbcloud
