// Any phase function through the sweeps, in slabs, against adding and doubling with its moments.
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/slab_exact.h"
#include "support/voxel_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr double mu = 1;  // of the sun; near 0.6 Rayleigh reflects as isotropic scattering does

struct Outcome {
    double reflected, transmitted;  ///< per incident flux; transmitted with the beam
};

/// A slab of n voxels along y through scatter_p1, the whole way of p1solve --iterations.
Outcome swept(const PhaseFunction& phase, double tau, double w0, int degree, int n)
{
    const auto grid = test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(tau);
    medium.albedo = Vec3d(w0);
    medium.phase = phase;
    const Light sun = make_sun(Vec3d(std::sqrt(1 - mu * mu), mu, 0));
    ScatterOptions options;
    options.periodic = {true, false, true};
    options.closure.iterations = 40;
    options.closure.directions = 128;
    options.closure.degree = degree;
    options.closure.change = 1e-6;
    options.solve.tolerance = 1e-8;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
    EXPECT_TRUE(report.channel[0].closure.converged);
    EXPECT_LT(report.channel[0].budget.defect, 1e-6);
    const double in = mu * 64.0 / n / n, scaled_tau = tau * delta_scaling(phase, degree).extinction(w0);
    return {report.channel[0].planes.reflected / in,
            report.channel[0].planes.transmitted() / in + std::exp(-scaled_tau / mu)};
}

/// Exact for moments up to 2 n - 1 = 47. The higher moments of a peak count as unscattered, with an error of the order
/// of m_48 of the slab in a flux that passes through either way.
Outcome exact(const PhaseFunction& phase, double tau, double w0)
{
    const int n = 24;
    const DeltaScaling fine = delta_scaling(phase, 2 * n - 1);
    test::SlabExact::Options o;
    o.tau = tau * fine.extinction(w0);
    o.w0 = fine.albedo(w0);
    o.mu0 = mu;
    o.n = n;
    o.moments = fine.moments;
    const test::SlabExact slab(o);
    return {slab.reflected() / mu, slab.transmitted() / mu + std::exp(-o.tau / mu)};
}

TEST(PhaseSlab, RayleighSlabMatchesAddingDoubling)
{
    // 128 directions and voxels of tau / 64 leave less than 0.05 % of R and of T.
    const PhaseFunction rayleigh("rayleigh");
    for (const auto& [tau, w0] : {std::pair(1.0, 0.5), {1.0, 0.8}, {4.0, 0.8}, {4.0, 1.0}})
        for (int degree : {2, 5}) {
            const Outcome found = swept(rayleigh, tau, w0, degree, 64), truth = exact(rayleigh, tau, w0);
            EXPECT_NEAR(found.reflected / truth.reflected, 1, 0.0005) << tau << ' ' << degree;
            EXPECT_NEAR(found.transmitted / truth.transmitted, 1, 0.0005) << tau << ' ' << degree;
        }
}

TEST(PhaseSlab, RayleighDiffersFromIsotropicByMoreThanTheTolerance)
{
    // Shows that RayleighSlabMatchesAddingDoubling would detect isotropic scattering in place of Rayleigh.
    const Outcome rayleigh = exact(PhaseFunction("rayleigh"), 1, 0.5), isotropic = exact(PhaseFunction(), 1, 0.5);
    EXPECT_NEAR(rayleigh.reflected / isotropic.reflected - 1, 0.040, 0.001);
    EXPECT_NEAR(rayleigh.transmitted / isotropic.transmitted - 1, 0.0096, 0.0005);
}

TEST(PhaseSlab, DropletSlabMatchesAddingDoubling)
{
    // The error of delta-M at degree L is largest where light is scattered few times: in R of the thinner slab.
    // Voxels of half a mean free path in the thicker one add 0.04 of their squared scaled thickness to T.
    const PhaseFunction droplets("hg-draine", {20});
    for (const auto& [tau, w0, degree, tolerance] :
         {std::tuple(8.0, 1.0, 3, 0.003), {8.0, 1.0, 5, 0.001}, {32.0, 0.999, 3, 0.0015}, {32.0, 0.999, 5, 0.0015}}) {
        const Outcome found = swept(droplets, tau, w0, degree, 64), truth = exact(droplets, tau, w0);
        EXPECT_NEAR(found.reflected / truth.reflected, 1, tolerance) << tau << ' ' << degree;
        EXPECT_NEAR(found.transmitted / truth.transmitted, 1, tolerance) << tau << ' ' << degree;
    }
}

TEST(PhaseSlab, ThinForwardScatteringSlabSendsBackWhatThePhaseFunctionDoes)
{
    // Nearly all of R was scattered once: by the phase function, not by the expansion, with which R is 8 and 1.7 % off.
    // What is left is what directions near the peak cannot carry.
    const PhaseFunction forward = PhaseFunction::henyey_greenstein(0.85);
    for (const auto& [degree, w0, tolerance] : {std::tuple(3, 1.0, 0.04), {3, 0.5, 0.04}, {7, 1.0, 0.005}}) {
        const Outcome found = swept(forward, 0.25, w0, degree, 16), truth = exact(forward, 0.25, w0);
        EXPECT_NEAR(found.reflected / truth.reflected, 1, tolerance) << degree;
    }
}

TEST(PhaseSlab, DoubleHenyeyGreensteinSlabMatchesAddingDoubling)
{
    const PhaseFunction lobes("double-henyey-greenstein", {0.6, -0.5, 0.7});
    const Outcome found = swept(lobes, 2, 0.98, 5, 64), truth = exact(lobes, 2, 0.98);
    EXPECT_NEAR(found.reflected / truth.reflected, 1, 0.01);
    EXPECT_NEAR(found.transmitted / truth.transmitted, 1, 0.005);
}

}  // namespace
}  // namespace vdbcloud
