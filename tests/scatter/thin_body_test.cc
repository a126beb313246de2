// A thin body in the sun: P1's negative phi, and the nonnegative radiance used for the picture.
#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// A ball of 2 x 12 voxels across and optical radius 0.01 in a sun of irradiance 1 along +x, conservative.
struct ThinBall : test::P1Case {
    static constexpr int n = 26;
    static constexpr double tau = 0.01, centre = (n - 1) / 2.0, radius = 12;

    explicit ThinBall(double g)
        : P1Case(test::voxel_field(Vec3i(n), Vec3d(1 / radius),
                                   [](const Vec3i& p) { return from_centre(p).length() < radius ? 1.0 : 0.0; })),
          p1(index, density, exposed, {tau, 1, nullptr, test::hg(g), true}), source(p1)
    {
        const Light sun = make_sun(Vec3d(-1, 0, 0));
        scaled = tau * p1.scaling(0).extinction;
        add_beam(p1, beam_depths(index, exposed, BrickMap(*grid), sun), scaled, {{&source, 1.0}});
        Multigrid multigrid(p1.stencil());
        SolveOptions options;
        options.tolerance = 1e-9;
        EXPECT_TRUE(solve_p1(p1, multigrid, source, phi, options).converged);
    }
    static Vec3d from_centre(const Vec3i& p) { return Vec3d(p.x() - centre, p.y() - centre, p.z() - centre); }

    P1Operator p1;
    P1Source source;
    double scaled = 0;  // sigma_t' R
    std::vector<double> phi;
};

TEST(ThinBody, PhiMatchesFirstOrderP1IncludingNegativeValues)
{
    // To first order in tau' = sigma_t' R the solution of P1 with Marshak's condition on the true sphere is
    //     phi = tau' E (2/3 + 3 g' x / R):   what leaves is what scatters, 4 pi R^2 phi / 2, and F = -D grad phi + g'/(1-g') E
    // has no part of its own along x. At the lit pole phi is negative from g' = 2/9 on, that is g = 2/7. The grid does
    // not cause the negative value.
    for (double g : {0.0, 0.2, 0.5, 0.85}) {
        const ThinBall ball(g);
        const double scaled_g = g / (1 + g);
        double along = 0, square = 0, sum = 0;
        size_t count = 0;
        for (size_t slot = 0; slot < ball.index.blocks().count() * 512; ++slot) {
            if (!ball.index.blocks().active(slot)) continue;
            const double x = ThinBall::from_centre(ball.index.blocks().voxel(slot))[0] / ThinBall::radius;
            sum += ball.phi[slot] / ball.scaled;
            along += x * ball.phi[slot] / ball.scaled;
            square += x * x;
            ++count;
        }
        EXPECT_NEAR(sum / double(count), 2.0 / 3, 0.03) << g;  // the staircase's area, and tau'
        EXPECT_NEAR(along / square, 3 * scaled_g, 0.05 * 3 * scaled_g + 0.01) << g;
        const P1Budget b = budget(ball.p1, ball.source, ball.phi);
        EXPECT_EQ(b.negative > 0, g > 2.0 / 7) << g;
        EXPECT_LT(b.defect, 1e-6);
    }
}

TEST(ThinBody, PictureRadianceIsNonnegative)
{
    const ThinBall ball(0.5);
    auto flux = cell_flux(ball.p1, ball.source, ball.phi);
    const auto before = flux;
    const int64_t limited = limit_flux(ball.p1, ball.phi, flux);
    int64_t seen = 0;
    for (size_t slot = 0; slot < ball.index.blocks().count() * 512; ++slot) {
        if (!ball.index.blocks().active(slot)) continue;
        const Vec3d f(flux[0][slot], flux[1][slot], flux[2][slot]),
            f0(before[0][slot], before[1][slot], before[2][slot]);
        EXPECT_LE(f.length(), std::max(0.0, ball.phi[slot]) / 3 * (1 + 1e-6));
        if (f0.length() > std::max(0.0, ball.phi[slot]) / 3)
            ++seen;
        else
            EXPECT_EQ(f, f0);
        EXPECT_GE(f.dot(f0), 0);
    }
    EXPECT_EQ(limited, seen);
    EXPECT_GT(limited, 0);

    // Deep in a cloud the flux is not shortened: diffusion's flux is small relative to phi.
    const Medium medium = [] {
        Medium m;
        m.sigma_t_per_density = Vec3d(40);
        m.phase = test::hg(0.85);
        return m;
    }();
    ScatterReport report;
    const auto grid = test::voxel_field(Vec3i(8, 32, 8), Vec3d(1.0), [](const Vec3i&) { return 1.0; });
    ScatterOptions options;
    options.periodic = {true, false, true};
    options.line_rays = options.reentry_rays = 0;
    const Light sun = make_sun(Vec3d(0, 1, 0));
    scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
    EXPECT_LT(report.channel[0].flux_limited, 2 * 64);
}

}  // namespace
}  // namespace vdbcloud
