// P1 with Levermore and Pomraning's limiter: its function, its two limits, and a layer against the differential
// equation.
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/voxel_field.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(FluxLimiter, FactorIsOneInThickMediaAndBoundsFluxInThinMedia)
{
    EXPECT_DOUBLE_EQ(levermore_pomraning(0), 1);
    EXPECT_NEAR(levermore_pomraning(0.00999999), levermore_pomraning(0.01000001), 1e-9)
        << "the series meets the formula";
    double before = 0;
    for (double r = 1e-3; r < 1e6; r *= 1.5) {
        const double flux = levermore_pomraning(r) * r / 3;  // of phi
        EXPECT_GT(flux, before);
        EXPECT_LT(flux, 1);
        before = flux;
    }
    EXPECT_NEAR(before, 1, 1e-5);
}

/// A layer of optical depth tau and albedo 1, isotropic, under an overcast sky of L = s above and no light from below.
double transmitted(double tau, int n, bool limiter, LimiterReport* limited = nullptr)
{
    const auto grid = test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(tau);
    medium.albedo = Vec3d(1);
    ScatterOptions options;
    options.periodic = {true, false, true};
    options.sky = GradientSky{Vec3d(1), Vec3d(0), Vec3d(0), 1};
    options.limiter = limiter;
    options.limiter_change = 1e-7;
    options.solve.tolerance = 1e-9;
    options.reentry_rays = 0;
    ScatterReport report;
    scatter_p1(*grid, nullptr, nullptr, medium, {}, options, {}, report);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.channel[0].budget.defect, 1e-6);
    if (limited) *limited = report.channel[0].limiter;
    return report.channel[0].budget.out[Blocks::YMinus] * n * n / 64;
}

/// x with coth x - 1/x = y, by bisection.
double inverse_langevin(double y)
{
    double lo = 0, hi = 1e4;
    for (int k = 0; k < 100; ++k) {
        const double x = (lo + hi) / 2;
        (levermore_pomraning(x) * x / 3 < y ? lo : hi) = x;
    }
    return lo;
}

/// Reference from the differential equation: F is constant, phi' = -phi Linv(F / phi), phi = 4 J - 2 F above, 2 F
/// below.
double exact_transmitted(double tau, double inflow)
{
    double lo = 0, hi = 4.0 / 3 * inflow;
    for (int k = 0; k < 50; ++k) {
        const double flux = (lo + hi) / 2;
        double phi = 4 * inflow - 2 * flux;
        const int steps = 400;
        const auto slope = [&](double p) { return p > flux * 1.0001 ? -p * inverse_langevin(flux / p) : -1e4 * flux; };
        for (int s = 0; s < steps && phi > flux; ++s) {  // Heun
            const double h = tau / steps, first = slope(phi);
            phi += h / 2 * (first + slope(phi + h * first));
        }
        (phi > 2 * flux ? lo : hi) = flux;
    }
    return lo;
}

TEST(FluxLimiter, LayerMatchesTheDifferentialEquation)
{
    const double inflow = 2 * pi / 3, tau = 1, exact = exact_transmitted(tau, inflow);
    LimiterReport report;
    const double coarse = transmitted(tau, 16, true) - exact, fine = transmitted(tau, 32, true, &report) - exact;
    EXPECT_GT(std::abs(exact / transmitted(tau, 32, false) - 1), 0.02) << "here the limiter matters";
    EXPECT_LT(std::abs(fine), 0.005 * exact);
    EXPECT_GT(std::abs(coarse / fine), 1.8) << coarse << ' ' << fine;
    EXPECT_GT(report.iterations, 2);
    EXPECT_LT(report.least, 0.95);
}

TEST(FluxLimiter, ThickMediaMatchP1) { EXPECT_NEAR(transmitted(400, 64, true) / transmitted(400, 64, false), 1, 0.01); }

TEST(FluxLimiter, FluxStaysBelowFluenceInThinParts)
{
    const auto grid = test::voxel_field(Vec3i(24), Vec3d(1.0 / 24), [](const Vec3i& p) {
        const Vec3d x = Vec3d(p.x(), p.y(), p.z()) / 11.5 - Vec3d(1);
        return std::max(0.0, 1 - x.dot(x));
    });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    medium.albedo = Vec3d(1);
    medium.phase = PhaseFunction::henyey_greenstein(0.6);
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    ScatterOptions options;
    options.limiter = true;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    const CollidedLight fields = scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.channel[0].budget.defect, 1e-6);
    EXPECT_EQ(report.channel[1].solved_as, 0);
    EXPECT_EQ(report.channel[0].budget.negative, 0);
    EXPECT_LT(report.channel[0].limiter.least, 0.9);
}

}  // namespace
}  // namespace vdbcloud
