// Transport sweeps that close P1: slabs against exact transport.
#include "scatter/sweep_cases.h"
#include "support/size.h"
#include "support/slab_exact.h"
#include "vdbcloud/core/constants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

using test::Lit;
using test::options;
using test::Result;
using test::Slab;
using test::solve;

/// Radiance that leaves a slab upwards (`up`) along a cosine, from isotropic sources at cell centres taken linear
/// between them.
double emergent(const Slab& slab, const Result& r, const Lit& lit, double tau, double mu, bool up)
{
    const int n = slab.count, steps = 8;
    const double cell = tau / n;
    double sum = 0, depth = 0;
    for (int k = 0; k < n * steps; ++k) {
        const double at = (k + 0.5) / steps - 0.5;  // cells from the first centre on the side that is looked at
        const int lower = std::clamp(int(std::floor(at)), 0, n - 2);
        const auto source = [&](int j) {
            const int from_top = up ? j : n - 1 - j;
            return lit.w0 / (4 * pi) * (slab.at(r.phi, from_top) + slab.at(r.uncollided, from_top));
        };
        const double q = source(lower) + (at - lower) * (source(lower + 1) - source(lower)), d = cell / steps / mu;
        sum += q * std::exp(-depth) * -std::expm1(-d);
        depth += d;
    }
    return sum;
}

TEST(SecondMoment, SlabsMatchExactTransport)
{
    // 2 and 8 polar points per hemisphere. Errors are larger in thin slabs, because of grazing light.
    struct Bound {
        int directions;
        double thick, thin;
    };
    double error[2] = {0, 0}, wave[2] = {0, 0};
    for (double tau : {0.1, 1.0, 16.0, 64.0})
        for (const Bound& bound : {Bound{32, 0.025, 0.05}, {128, 0.002, 0.002}}) {
            if (bound.directions > 32 && tau > 20 && !test::full_size()) continue;
            const int n = tau > 20 ? 128 : 64, which = bound.directions == 128;
            Slab slab(tau, n);
            Lit lit;
            lit.w0 = 0.9999;
            lit.to_sun = Vec3d(0.8, 0.6, 0);
            const Result r = solve(slab.cloud, lit, options(bound.directions));
            const test::SlabExact exact({tau, lit.w0, 0, 0.6, {0.3, 1.0}, 24});
            // The sweep's own law of the flux errs by some 0.04 of a voxel's squared thickness.
            const double cell = tau / n, most = (tau < 1 ? bound.thin : bound.thick) + 0.05 * cell * cell;
            const double line = most + 0.2 * cell * cell;  // radiance: adds the error of linear sources between centres
            const double reflected = r.budget.out[Blocks::YPlus] / slab.area(),
                         transmitted = r.budget.out[Blocks::YMinus] / slab.area();
            EXPECT_NEAR(reflected / exact.reflected(), 1, most) << tau << ' ' << bound.directions;
            EXPECT_NEAR(transmitted / exact.transmitted(), 1, most) << tau << ' ' << bound.directions;
            for (int k = 0; k < 2; ++k) {
                const double mu = k ? 1.0 : 0.3;
                EXPECT_NEAR(emergent(slab, r, lit, tau, mu, true) / exact.emergent_top(k), 1, line)
                    << tau << ' ' << bound.directions << ' ' << mu;
                EXPECT_NEAR(emergent(slab, r, lit, tau, mu, false) / exact.emergent_bottom(k), 1, line)
                    << tau << ' ' << bound.directions << ' ' << mu;
            }
            EXPECT_LT(r.budget.defect, 1e-6);
            EXPECT_TRUE(r.report.converged);
            EXPECT_LE(r.report.iterations, 7);
            double square = 0, worst = 0;  // of the error of everything's fluence; P1's own is 6 to 16 %
            for (int j = 0; j < n; j += n / 32) {
                const double depth = tau * (j + 0.5) / n, phi = exact.at(depth).phi;
                const double off = (slab.at(r.phi, j) - phi) / (phi + std::exp(-depth / 0.6));
                square += off * off / 32;
                worst = std::max(worst, std::abs(off));
            }
            EXPECT_LT(worst, most + 0.1 * cell * cell)
                << tau << ' ' << bound.directions;  // at every depth: second order in the voxel
            if (tau == 1) {
                error[which] = std::abs(reflected / exact.reflected() - 1);
                wave[which] = std::sqrt(square);
            }
        }
    // Two doublings of the polar points: at least second order.
    EXPECT_GT(std::log2(error[0] / error[1]), 4);
    EXPECT_GT(std::log2(wave[0] / wave[1]), 4);
}

TEST(SecondMoment, TransmissionHoldsAtAnyOpticalDepthPerVoxel)
{
    for (const auto& [per_voxel, tau] :
         {std::pair(0.25, 16.0), {4.0, 16.0}, {4.0, 1000.0}, {16.0, 1000.0}, {60.0, 960.0}}) {
        Slab slab(tau, int(std::lround(tau / per_voxel)));
        Lit lit;
        lit.w0 = 1;
        const Result r = solve(slab.cloud, lit, options(32, 15, 1, 1e-3));
        const test::SlabExact exact({tau, 1, 0, 1, {}, 16});
        EXPECT_NEAR(r.budget.out[Blocks::YMinus] / slab.area() / exact.transmitted(), 1, 0.02)
            << per_voxel << ' ' << tau;
        EXPECT_LT(r.budget.defect, 1e-6);
        EXPECT_TRUE(r.report.converged);
    }
}

TEST(SecondMoment, ForwardScatteringSlabsMatchExactTransport)
{
    // Degree 3 suffices where light is scattered many times; a slab of tau 1 at g = 0.85 needs degree 5. Most
    // transmitted light is unscattered under delta scaling: T includes the unscattered light.
    for (const auto& [g, degree, directions, tau] : {std::tuple(0.5, 3, 64, 1.0),
                                                     {0.5, 1, 32, 16.0},
                                                     {0.85, 5, 144, 0.1},
                                                     {0.85, 5, 144, 1.0},
                                                     {0.85, 7, 256, 1.0},
                                                     {0.85, 3, 64, 4.0},
                                                     {0.85, 1, 32, 16.0},
                                                     {0.85, 3, 64, 64.0}}) {
        Slab slab(tau, 64);
        Lit lit;
        lit.w0 = 0.999;
        lit.g = g;
        lit.to_sun = Vec3d(0.8, 0.6, 0);
        const Result r = solve(slab.cloud, lit, options(directions, 15, degree, 1e-3));
        EXPECT_TRUE(r.report.converged);
        const test::SlabExact exact({tau, lit.w0, g, 0.6, {}, 24});
        EXPECT_NEAR(r.budget.out[Blocks::YPlus] / slab.area() / exact.reflected(), 1, 0.03)
            << g << ' ' << degree << ' ' << tau;
        EXPECT_NEAR((r.budget.out[Blocks::YMinus] / slab.area() + 0.6 * std::exp(-r.extinction * tau / 0.6)) /
                        (exact.transmitted() + 0.6 * std::exp(-tau / 0.6)),
                    1, 0.03)
            << g << ' ' << degree << ' ' << tau;
    }
}

}  // namespace
}  // namespace vdbcloud
