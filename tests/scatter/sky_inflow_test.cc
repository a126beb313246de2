// A layer under a sky that changes with height: P1 against its closed form, sweeps against exact transport.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/second_moment.h"
#include "vdbcloud/scatter/sky_inflow.h"

#include "scatter/fields.h"
#include "support/slab_exact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// A layer of n voxels along y, of thickness 1 and optical depth tau, that neither absorbs nor prefers a direction.
struct Layer : test::P1Case {
    Layer(double tau, int n)
        : P1Case(test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; }),
                 {true, false, true}),
          p1(index, density, exposed, {tau, 1, nullptr, PhaseFunction(), true}), area(64.0 / n / n)
    {
    }
    double transmitted(const P1Source& source, const std::vector<double>& phi) const
    {
        const P1Budget b = budget(p1, source, phi);
        EXPECT_LT(b.defect, 1e-6);
        return b.out[Blocks::YMinus] / area;
    }
    P1Operator p1;
    double area;
};

Sky sky_above()
{
    return GradientSky{Vec3d(0.2), Vec3d(3.0), Vec3d(0), 2};  // black ground except for the horizon's haze
}

TEST(SkyInflow, P1OutflowMatchesMarshakForSkyFromBothSides)
{
    // Marshak, w0 = 1: the net flux is (J_top - J_bottom) / (1 + 3/4 tau), layers and boundaries being exact on the
    // grid.
    const Layer layer(2, 16);
    const Sky sky = sky_above();
    P1Source source(layer.p1);
    add_sky(layer.p1, sky_on_faces(layer.index, sky, 0), source);
    Multigrid multigrid(layer.p1.stencil());
    std::vector<double> phi;
    SolveOptions tight;
    tight.tolerance = 1e-9;
    solve_p1(layer.p1, multigrid, source, phi, tight);
    const double share = 2.0 / 12, top = pi * (0.2 + 2.8 * share), bottom = pi * 3 * share;
    // Power out below: the transmitted share of light from above, and the reflected share of light from below.
    const double pass = 1 / (1 + 0.75 * 2);
    EXPECT_NEAR(layer.transmitted(source, phi), top * pass + bottom * (1 - pass), 1e-4);
}

TEST(SkyInflow, SweepsMatchExactTransportUnderAnOvercastSky)
{
    const double tau = 2;
    const Layer layer(tau, 64);
    // L = 3 s above: overcast, and nothing from the ground
    const Sky sky = GradientSky{Vec3d(3.0), Vec3d(0), Vec3d(0), 1};
    ClosureOptions options;
    options.directions = 128;
    options.iterations = 15;
    options.change = 1e-4;
    const auto exposed = closure_exposed(layer.p1, layer.p1.exposed());
    const P1Operator p1(layer.index, layer.density, exposed, layer.p1.medium());
    const auto run = [&](bool by_direction) {
        SecondMoment closure(p1, options);
        if (by_direction)
            closure.set_sky(sky_along(layer.index, sky, 0, closure.set().direction));
        else {  // the same power, spread evenly over each half
            std::vector<float> even;
            for (const Vec3d& s : closure.set().direction)
                even.push_back(float(sky.mean_inflow(Vec3d(0, s[1] < 0 ? 1 : -1, 0))[0]));
            closure.set_sky(even);
        }
        P1Source source(p1);
        add_sky(p1, sky_on_faces(layer.index, sky, 0), source);
        Multigrid multigrid(p1.stencil());
        P1Source first = source;
        std::vector<double> phi;
        solve_p1(p1, multigrid, first, phi, {});
        EXPECT_TRUE(closure.run(multigrid, {}, source, phi).converged);
        return layer.transmitted(source, phi);
    };
    // Exact: beams from every height, from above and (those that return) from below.
    std::vector<double> node, weight;
    gauss_legendre(24, node, weight);
    double exact = 0;
    for (size_t k = 0; k < node.size(); ++k) {
        const double mu = (node[k] + 1) / 2, w = pi * weight[k];  // 2 pi dmu
        const test::SlabExact beam({tau, 1, 0, mu, {}, 16});
        exact +=
            w * sky.radiance(Vec3d(std::sqrt(1 - mu * mu), mu, 0))[0] * (beam.transmitted() + mu * std::exp(-tau / mu));
        exact += w * sky.radiance(Vec3d(std::sqrt(1 - mu * mu), -mu, 0))[0] * beam.reflected();
    }
    // 128 directions have an error of 0.13 % under a beam; here they also sample the inflow at 8 heights only.
    EXPECT_NEAR(run(true) / exact, 1, 0.005);
    EXPECT_GT(std::abs(run(false) / exact - 1), 0.03) << "the directions of the inflow matter here";
}

}  // namespace
}  // namespace vdbcloud
