// P1 in slabs and layers against closed forms; delta scaling leaves the matrix as it is.
#include "scatter/p1_solve.h"
#include "support/p1_forms.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/beam.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::P1Case;
using test::P1Slab;
using test::solve;
using test::Solved;

struct SlabOutcome {
    double reflected, transmitted, phi_error, defect, deposited, lost;
    double layer_ratio;  // phi of the first cell
};

/// A slab of n voxels along y, periodic across, sun from +y at cosine mu in the x-y plane.
SlabOutcome slab(int n, double tau, double w0, double g, double mu, bool delta, const P1Slab& exact)
{
    const double h = 1.0 / n, E = exact.E;
    P1Case c(test::voxel_field(Vec3i(8, n, 8), Vec3d(h), [&](const Vec3i&) { return 1.0; }), {true, false, true});
    const P1Operator p1(c.index, c.density, c.exposed, {tau, w0, nullptr, test::hg(g), delta});
    P1Source source(p1);
    const Light sun = make_sun(Vec3d(std::sqrt(1 - mu * mu), mu, 0));
    const double extinction = tau * p1.scaling(0).extinction;
    double lost = 0;
    if (E > 0) {
        add_beam(p1, periodic_beam_depths(c.index, c.exposed, c.density, sun), extinction, {{&source, E}});
        lost = E * lost_power(periodic_line_depths(c.index, c.density, sun), extinction);
    }
    if (exact.j0 > 0) add_sky(p1, exact.j0 / pi, source);
    const Solved s = solve(p1, source);
    EXPECT_TRUE(s.solve.converged) << n << ' ' << tau << ' ' << w0 << ' ' << g << ' ' << s.solve.residual;
    const double area = 64 * h * h;
    SlabOutcome o{s.budget.out[Blocks::YPlus] / area,
                  s.budget.out[Blocks::YMinus] / area,
                  0,
                  s.budget.defect,
                  source.deposited / area,
                  lost / area,
                  0};
    double largest = 0;
    const double scaled_tau = tau * p1.scaling(0).extinction;
    for (int j = 0; j < n; ++j) {
        const double depth = scaled_tau * (n - 1 - j + 0.5) / n, phi = exact.phi(depth);
        const size_t slot = c.index.blocks().slot(Vec3i(0, j, 0));
        o.phi_error = std::max(o.phi_error, std::abs(s.phi[slot] - phi));
        largest = std::max(largest, std::abs(phi));
        if (scaled_tau / n < 0.2) {
            EXPECT_NEAR(-double(s.flux[1][slot]), exact.flux(depth), 0.02 * std::max(exact.flux(0), E)) << j;
        }
    }
    o.phi_error /= largest;
    return o;
}

struct SlabCase {
    double tau, w0, g, mu;
    bool delta;
};

class Slab : public testing::TestWithParam<SlabCase> {};

TEST_P(Slab, ConvergesAtSecondOrderToTheClosedForm)
{
    const SlabCase p = GetParam();
    const auto scaled = p.delta ? delta_scaling(test::hg(p.g), 1) : no_scaling(test::hg(p.g), 1);
    const P1Slab exact(p.tau * scaled.extinction(p.w0), scaled.albedo(p.w0), scaled.mean_cosine(), 1, p.mu);
    const int n = p.tau > 20 ? 256 : p.tau > 5 ? 64 : 32;
    const auto coarse = slab(n, p.tau, p.w0, p.g, p.mu, p.delta, exact);
    const auto fine = slab(2 * n, p.tau, p.w0, p.g, p.mu, p.delta, exact);
    const auto order = [](double a, double b) { return std::log2(std::abs(a) / std::abs(b)); };
    const double reflected[2] = {coarse.reflected - exact.reflected(), fine.reflected - exact.reflected()};
    const double transmitted[2] = {coarse.transmitted - exact.transmitted(), fine.transmitted - exact.transmitted()};
    // Richardson extrapolation: the error without the second-order term.
    EXPECT_NEAR((4 * reflected[1] - reflected[0]) / 3, 0, 1e-4);
    EXPECT_NEAR((4 * transmitted[1] - transmitted[0]) / 3, 0, 1e-4);
    for (const auto& e : {reflected, transmitted})
        if (std::abs(e[1]) > 1e-6) {
            EXPECT_GT(order(e[0], e[1]), 1.8);
        }
    EXPECT_GT(order(coarse.phi_error, fine.phi_error), 1.8);
    EXPECT_LT(fine.phi_error, 0.02);
    for (const auto& o : {coarse, fine}) {
        EXPECT_LT(o.defect, 1e-6);
        EXPECT_NEAR(o.lost / o.deposited, 1, 1e-6);
        EXPECT_NEAR(o.deposited, p.mu * (1 - std::exp(-p.tau * scaled.extinction(p.w0) / p.mu)), 1e-6);
    }
}

INSTANTIATE_TEST_SUITE_P(Cases, Slab,
                         testing::Values(SlabCase{0.1, 1, 0, 1, false}, SlabCase{1, 1, 0, 1, false},
                                         SlabCase{1, 0.9, 0.5, 0.6, false}, SlabCase{4, 0.99, 0.85, 0.6, true},
                                         SlabCase{4, 0.99, 0.4, 0.6, false}, SlabCase{16, 1, 0.85, 0.8, true},
                                         SlabCase{64, 1, 0, 0.7, false}, SlabCase{64, 0.999, 0.85, 1, true},
                                         SlabCase{8, 0.95, -0.5, 0.6, true}));

TEST(Slab, TransmissionOfIsotropicInflowMatchesTheClosedForm)
{
    for (double g : {0.0, 0.5}) {
        const double tau = 8;
        const P1Slab exact(tau, 1, g, 0, 1, /*j0=*/1);
        EXPECT_NEAR(exact.transmitted(), 1 / (1 + 0.75 * (1 - g) * tau), 1e-12);
        P1Case c(test::voxel_field(Vec3i(8, 32, 8), Vec3d(1.0 / 32), [](const Vec3i&) { return 1.0; }),
                 {true, false, true});
        const P1Operator p1(c.index, c.density, c.exposed, {tau, 1, nullptr, test::hg(g), true});
        P1Source source(p1);  // sky from above only: inflow 4 J = 4 through the top faces
        for (const ExposedVoxel& voxel : c.exposed)
            if (voxel.faces >> Blocks::YPlus & 1) source.rhs[voxel.slot] += 4 * p1.conductance(voxel, Blocks::YPlus);
        const Solved s = solve(p1, source);
        // No source between the faces: the discrete flux is exact.
        EXPECT_NEAR(s.budget.out[Blocks::YMinus] / 0.0625, exact.transmitted(), 1e-6);
    }
}

TEST(Layers, LayersInSeriesAreExact)
{
    const int n = 16;
    const double h = 1.0 / n, sigma[2] = {300, 0.01};
    P1Case c(test::voxel_field(Vec3i(8, n, 8), Vec3d(h), [&](const Vec3i& p) { return sigma[p.y() / 5 % 2]; }),
             {true, false, true});
    const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(0), true});
    double tau = 0;
    for (int j = 0; j < n; ++j) tau += sigma[j / 5 % 2] * h;
    P1Source source(p1);
    for (const ExposedVoxel& voxel : c.exposed)
        if (voxel.faces >> Blocks::YPlus & 1) source.rhs[voxel.slot] += 4 * p1.conductance(voxel, Blocks::YPlus);
    const Solved s = solve(p1, source);
    EXPECT_NEAR(s.budget.out[Blocks::YMinus] / (64 * h * h) * (1 + 0.75 * tau), 1, 1e-5);
}

TEST(Scaling, DoesNotChangeTheMatrix)
{
    P1Case c(test::voxel_field(Vec3i(8, 8, 8), Vec3d(0.2), [](const Vec3i& p) { return 1.0 + p.x(); }));
    const P1Operator plain(c.index, c.density, c.exposed, {3, 0.97, nullptr, test::hg(0.85), false});
    const P1Operator scaled(c.index, c.density, c.exposed, {3, 0.97, nullptr, test::hg(0.85), true});
    EXPECT_EQ(plain.stencil().extra, scaled.stencil().extra);
    for (int a = 0; a < 3; ++a) EXPECT_EQ(plain.stencil().face[a], scaled.stencil().face[a]);
    EXPECT_NE(plain.q1_factor(0), scaled.q1_factor(0));
}

}  // namespace
}  // namespace vdbcloud
