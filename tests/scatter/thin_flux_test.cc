// P1's flux in a thin medium, where diffusion cancels the beam's first moment to the order of the optical depth.
#include "scatter/fields.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/beam.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

/// A periodic layer of n voxels of depth s << 1 under a sun in the zenith absorbs nothing. It collects n s E, so F
/// falls by s E from layer to layer downwards. Marshak's conditions give its ends: phi(top) + phi(base) = 2 n s E, and
/// D phi' = Q1 / sigma_tr to first order in s, so phi(base) - phi(top) = 3 g n s E. Hence F up at the centre of layer y
/// is s E (y + 1/2 - n / 2 - 3 g n / 4). The terms left out are n s relative; the tolerance is ten times that.
TEST(ThinFlux, OfALayerIsWhatItCollects)
{
    constexpr int n = 8;
    constexpr double g = 0.8;
    const test::P1Case body(test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0), [](const Vec3i&) { return 1.0; }),
                            {true, false, true});
    for (const double s : {1e-5, 1e-7}) {
        const P1Operator p1(body.index, body.density, body.exposed,
                            {s, 1.0, nullptr, PhaseFunction::henyey_greenstein(g), false});
        P1Source source(p1);
        const Light sun = make_sun(Vec3d(0, 1, 0));
        add_beam(p1, periodic_beam_depths(body.index, body.exposed, body.density, sun), s, {{&source, 1.0}});
        Multigrid multigrid(p1.stencil());
        std::vector<double> phi;
        SolveOptions options;
        options.tolerance = 1e-8;
        EXPECT_TRUE(solve_p1(p1, multigrid, source, phi, options).converged);
        const auto flux = cell_flux(p1, source, phi);
        for (int y = 0; y < n; ++y) {
            const size_t slot = body.index.blocks().slot(Vec3i(2, y, 2) - body.index.origin());
            const double expected = y + 0.5 - n / 2.0 - 0.75 * g * n;
            EXPECT_NEAR(double(flux[1][slot]) / s, expected, 10 * n * (10 * s + 1e-6)) << s << ' ' << y;
        }
    }
}

/// Under a uniform sky of radiance L the fluence of such a layer is 4 pi L to first order in its depth. The layer
/// absorbs s (1 - w0) 4 pi L a voxel and lets half of it in through each side: F up is s (1 - w0) 4 pi L (n / 2 - y -
/// 1/2).
TEST(ThinFlux, UnderASkyIsWhatALayerAbsorbs)
{
    constexpr int n = 8;
    const test::P1Case body(test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0), [](const Vec3i&) { return 1.0; }),
                            {true, false, true});
    for (const double absorbed : {0.0, 1e-3, 0.1})
        for (const double s : {1e-3, 1e-5}) {
            const P1Operator p1(body.index, body.density, body.exposed,
                                {s, 1 - absorbed, nullptr, PhaseFunction::henyey_greenstein(0.8), true});
            P1Source source(p1);
            add_sky(p1, 0.3, source);
            Multigrid multigrid(p1.stencil());
            std::vector<double> phi;
            const SolveResult solve = solve_p1(p1, multigrid, source, phi, {});
            EXPECT_TRUE(solve.converged);
            if (absorbed == 0) {
                EXPECT_EQ(solve.iterations, 0);
            }
            const auto flux = cell_flux(p1, source, phi);
            for (int y = 0; y < n; ++y) {
                const size_t slot = body.index.blocks().slot(Vec3i(2, y, 2) - body.index.origin());
                EXPECT_NEAR(phi[slot], 4 * pi * 0.3, 4 * pi * 0.3 * (absorbed == 0 ? 1e-15 : 10 * n * s));
                if (absorbed == 0) {
                    EXPECT_EQ(flux[1][slot], 0.0f) << y;
                    continue;
                }
                const double unit = s * absorbed * 4 * pi * 0.3;
                EXPECT_NEAR(double(flux[1][slot]) / unit, n / 2.0 - y - 0.5, 10 * n * (10 * s + 1e-6)) << s << ' ' << y;
            }
        }
}

}  // namespace
}  // namespace vdbcloud
