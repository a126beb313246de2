// A Lambertian ground under layers: P1 against its closed form, sweeps against adding and doubling, energy, furnace.
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/p1_forms.h"
#include "support/size.h"
#include "support/slab_ground.h"
#include "support/voxel_field.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr double mu = 0.6;  // of the sun

Light sun() { return make_sun(Vec3d(0.8, mu, 0)); }

Medium medium(double sigma_t, double w0, double g = 0)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    m.albedo = Vec3d(w0);
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

/// A layer of n voxels along y and thickness 1, 8 voxels wide.
FloatGridPtr layer(int n)
{
    return test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; });
}

/// A layer whose half x < 4 is five times as dense.
FloatGridPtr step(int n)
{
    return test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i& p) { return p.x() < 4 ? 5.0 : 1.0; });
}

/// Columns that reach the base beside columns that end above it.
FloatGridPtr with_gaps(int n)
{
    return test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [&](const Vec3i& p) {
        return p.x() < 4 ? 1.0 : p.x() == 4 || p.y() < n / 2 ? 0.0 : 1.0;
    });
}

ScatterOptions over(std::optional<double> albedo, int iterations)
{
    ScatterOptions o;
    o.periodic = {true, false, true};
    o.ground_albedo = albedo;
    o.closure.iterations = iterations;
    o.closure.directions = test::sized(64, 128);
    o.closure.change = 1e-7;
    o.solve.tolerance = 1e-9;
    o.reentry_rays = 500;
    o.line_rays = 0;
    return o;
}

struct Outcome {
    ScatterReport report;
    CollidedLight light;
    const ChannelReport& channel() const { return report.channel[0]; }
    double top() const { return channel().planes.out[Blocks::YPlus]; }
};

Outcome scattered(const FloatGrid& grid, const Medium& m, const std::vector<Light>& lights, const ScatterOptions& o)
{
    Outcome out;
    out.light = scatter_p1(grid, nullptr, nullptr, m, lights, o, {}, out.report);
    EXPECT_TRUE(out.report.converged);
    if (o.closure.iterations > 0) {
        EXPECT_TRUE(out.channel().closure.converged);
    }
    return out;
}

/// What falls on the layer and the ground equals what comes back and what both absorb.
void expect_energy_closes(const Outcome& found, double tolerance)
{
    const ChannelReport& c = found.channel();
    const double in = c.deposited + c.ground.direct + c.emitted + c.planes.sky_in[Blocks::YPlus];
    EXPECT_NEAR((found.top() + c.planes.reentered + c.budget.absorbed + c.ground.absorbed) / in, 1, tolerance);
    EXPECT_NEAR(c.ground.sent_up + c.ground.absorbed, c.ground.direct + c.ground.diffuse, 1e-6 * in);
    EXPECT_NEAR(c.planes.from_ground, c.ground.sent_up, 1e-6 * in);
    EXPECT_NEAR(c.planes.out[Blocks::YMinus], c.ground.diffuse, 1e-6 * in);
}

float ground_at(const Outcome& found, int x, int z)
{
    return openvdb::gridPtrCast<Vec3SGrid>(found.report.ground)->tree().getValue(openvdb::Coord(x, -1, z))[0];
}

TEST(Ground, P1OverItMatchesTheClosedForm)
{
    // Of second order in the voxel: 1e-3 of R at 32 voxels, as without a ground.
    const int n = 32;
    for (const double albedo : {0.0, 0.2, 0.8, 1.0})
        for (const auto& [tau, w0, g] : {std::tuple(2.0, 0.95, 0.0), {2.0, 1.0, 0.0}, {1.0, 0.9, 0.4}}) {
            ScatterOptions o = over(albedo, 0);
            o.delta = false;
            const Outcome found = scattered(*layer(n), medium(tau, w0, g), {sun()}, o);
            const test::P1Slab black(tau, w0, g, 1, mu), lit(tau, w0, g, 1, mu, 0, 1);
            const double direct = mu * std::exp(-tau / mu);
            // J+ is linear in what the ground sends up: J- = albedo (J+ + D).
            const double per_unit = lit.transmitted() - black.transmitted();
            const double up = albedo * (black.transmitted() + direct) / (1 - albedo * per_unit);
            const test::P1Slab exact(tau, w0, g, 1, mu, 0, up);
            const double area = 64.0 / n / n, tolerance = 1.5e-3 * mu;
            EXPECT_NEAR(found.top() / area, exact.reflected(), tolerance) << albedo << " " << tau << " " << w0;
            EXPECT_NEAR(found.channel().ground.diffuse / area, exact.transmitted(), tolerance);
            EXPECT_NEAR(found.channel().ground.direct / area, direct, 1e-6);
            EXPECT_NEAR(found.channel().ground.sent_up / area, up, tolerance);
            EXPECT_NEAR(ground_at(found, 3, 5), up / pi, tolerance / pi);
            expect_energy_closes(found, 1e-6);
            if (albedo == 1 && w0 == 1) {
                EXPECT_NEAR(found.top() / area, mu, 1e-5);
            }
        }
}

TEST(Ground, SweepsOverItMatchAddingAndDoubling)
{
    // Without a ground 64 directions and 16 voxels of 1/8 mean free path leave 0.3 % of mu in R and in E (the test
    // before, of albedo 0); a ground adds no error of its own.
    const int n = test::sized(16, 32);
    const double tau = 2;
    for (const double w0 : {0.95, 1.0})
        for (const double albedo : {0.0, 0.2, 0.8, 1.0}) {
            if (w0 == 1 && albedo == 0.2 && !test::full_size()) continue;
            const Outcome found = scattered(*layer(n), medium(tau, w0), {sun()}, over(albedo, 60));
            const test::SlabOverGround exact({tau, w0, 0, mu, {}, 16, {}}, albedo);
            const double area = 64.0 / n / n, tolerance = 3e-3 * mu;
            const ChannelReport& c = found.channel();
            EXPECT_NEAR(found.top() / area, exact.reflected, tolerance) << albedo << " " << w0;
            EXPECT_NEAR((c.ground.direct + c.ground.diffuse) / area, exact.irradiance, tolerance);
            EXPECT_NEAR(c.ground.absorbed / area, exact.absorbed_by_ground, tolerance);
            EXPECT_NEAR(c.budget.absorbed / area, exact.absorbed, tolerance);
            EXPECT_NEAR(ground_at(found, 3, 5), exact.ground, tolerance / pi);
            EXPECT_LT(c.budget.defect, 1e-6);
            expect_energy_closes(found, 1e-5);
            // As few iterations as without a ground: 9 to 12.
            EXPECT_LT(c.closure.iterations, 20) << albedo << " " << w0;
        }
}

TEST(Ground, AWhiteGroundSendsAllLightBackWhereNothingAbsorbs)
{
    // Thin and thick voxels; columns of different depth, so that the ground is lit unevenly.
    for (const double sigma_t : {1.0, 40.0})
        for (const int iterations : {0, 80}) {
            const Outcome found = scattered(*step(8), medium(sigma_t, 1), {sun()}, over(1, iterations));
            const ChannelReport& c = found.channel();
            EXPECT_NEAR((found.top() + c.planes.reentered) / (c.deposited + c.ground.direct), 1, 1e-5)
                << sigma_t << " " << iterations;
            EXPECT_EQ(c.ground.absorbed, 0);
            EXPECT_GT(c.ground.direct + c.ground.diffuse, 1e-4 * c.deposited);
        }
}

TEST(Ground, IsBrighterUnderThinColumns)
{
    for (const int iterations : {0, 40}) {
        const Outcome found = scattered(*step(8), medium(1.5, 0.99), {make_sun(Vec3d(0, 1, 0))}, over(0.5, iterations));
        // Direct light alone differs by exp(-1.5) against exp(-7.5).
        EXPECT_GT(ground_at(found, 6, 3), 2 * ground_at(found, 2, 3)) << iterations;
        EXPECT_GT(ground_at(found, 2, 3), 0);
        EXPECT_EQ(ground_at(found, -1, 3), ground_at(found, 7, 3)) << "repeats";
        EXPECT_EQ(ground_at(found, 8, -1), ground_at(found, 0, 7));
        expect_energy_closes(found, 1e-5);
    }
}

TEST(Ground, WhiteFurnaceIsUniform)
{
    // A uniform sky over a white ground, without absorption: radiance 1 everywhere.
    ScatterOptions o = over(1, 0);
    o.sky = Sky::constant(Vec3d(1.0));
    for (const int iterations : {0, 60}) {
        o.closure.iterations = iterations;
        const Outcome found = scattered(iterations ? *step(8) : *layer(8), medium(2, 1), {}, o);
        EXPECT_NEAR(found.channel().budget.smallest, 4 * pi, 1e-4);
        EXPECT_NEAR(found.channel().budget.largest, 4 * pi, 1e-4);
        EXPECT_NEAR(ground_at(found, 2, 3), 1, 1e-5);
        EXPECT_NEAR(ground_at(found, 6, 3), 1, 1e-5);
        expect_energy_closes(found, 1e-5);
    }
}

TEST(Ground, UnderThinAirShinesAsLambertSays)
{
    // Air of 1e-6 mean free paths scatters and absorbs less than that.
    for (const int iterations : {0, 20}) {
        const Outcome found = scattered(*layer(8), medium(1e-6, 0.9), {sun()}, over(0.3, iterations));
        EXPECT_NEAR(ground_at(found, 3, 3), 0.3 * mu / pi, 1e-5);
        EXPECT_NEAR(found.channel().ground.absorbed, 0.7 * mu, 1e-5);
    }
}

TEST(Ground, LightReachesItThroughGaps)
{
    const FloatGridPtr grid = with_gaps(16);
    const Outcome found = scattered(*grid, medium(3, 0.99), {make_sun(Vec3d(0, 1, 0))}, over(0.8, 60));
    const Outcome black = scattered(*grid, medium(3, 0.99), {make_sun(Vec3d(0, 1, 0))}, over(0.0, 60));
    // Column 4 is empty: its ground has the whole sun. Under column 6 half of the matter is left.
    EXPECT_GT(ground_at(found, 4, 3), 0.8 / pi);
    EXPECT_GT(ground_at(found, 6, 3), 0.8 / pi * std::exp(-1.5));
    EXPECT_GT(ground_at(found, 2, 3), 0.8 / pi * std::exp(-3));
    expect_energy_closes(found, 1e-5);
    EXPECT_GT(found.top(), 1.2 * black.top());
    EXPECT_GT(found.channel().ground.diffuse, 1.02 * black.channel().ground.diffuse) << "light that comes back twice";
    EXPECT_THROW(scattered(*grid, medium(3, 0.99), {sun()}, over(0.8, 0)), InputError);
}

TEST(Ground, ABlackOneChangesNoBitOfTheMedium)
{
    for (const int iterations : {0, 6}) {
        ScatterOptions o = over(std::nullopt, iterations);
        o.closure.change = 1e-3;
        const Outcome none = scattered(*layer(8), medium(2, 0.9, 0.3), {sun()}, o);
        o.ground_albedo = 0;
        const Outcome black = scattered(*layer(8), medium(2, 0.9, 0.3), {sun()}, o);
        EXPECT_FALSE(none.report.ground);
        ASSERT_TRUE(black.report.ground);
        EXPECT_EQ(ground_at(black, 3, 3), 0);
        const auto a = openvdb::gridPtrCast<FloatGrid>(none.light.phi),
                   b = openvdb::gridPtrCast<FloatGrid>(black.light.phi);
        size_t count = 0;
        for (auto v = a->cbeginValueOn(); v; ++v, ++count) ASSERT_EQ(*v, b->tree().getValue(v.getCoord()));
        EXPECT_GT(count, 500u);
        EXPECT_EQ(none.channel().budget.out, black.channel().budget.out);
        EXPECT_GT(black.channel().ground.absorbed, 0);
    }
}

TEST(Ground, HidesTheSkyBelowTheHorizon)
{
    ScatterOptions o = over(0.0, 0);
    o.sky = GradientSky{Vec3d(0), Vec3d(0), Vec3d(1.0)};
    const Outcome found = scattered(*layer(8), medium(2, 0.9), {}, o);
    EXPECT_EQ(found.channel().budget.largest, 0);
    const Sky sky = Sky::constant(Vec3d(2.0)).above_horizon();
    EXPECT_EQ(sky.radiance(Vec3d(0.8, -0.6, 0)), Vec3d(0.0));
    EXPECT_EQ(sky.radiance(Vec3d(0.8, 0.6, 0)), Vec3d(2.0));
    // Half of what a wall sees is sky.
    EXPECT_NEAR(sky.mean_inflow(Vec3d(1, 0, 0))[0], 1, 1e-5);
    EXPECT_NEAR(sky.mean_inflow(Vec3d(0, 1, 0))[0], 2, 1e-5);
    EXPECT_NEAR(sky.mean_inflow(Vec3d(0, -1, 0))[0], 0, 1e-5);
}

TEST(Ground, WhatItDoesNotAllowIsRefused)
{
    const FloatGridPtr grid = layer(8);
    const auto refused = [&](const ScatterOptions& o, const Light& light = sun()) {
        ScatterReport report;
        EXPECT_THROW(scatter_p1(*grid, nullptr, nullptr, medium(1, 1), {light}, o, {}, report), InputError);
    };
    refused(over(1.5, 0));
    refused(over(-0.1, 0));
    refused(over(0.5, 0), make_sun(Vec3d(0.8, -0.6, 0)));
    ScatterOptions o = over(0.5, 0);
    o.up = Vec3d(0, 0, 1);
    refused(o);
    o = over(0.5, 0);
    o.periodic = {true, false, false};
    refused(o);
    o = over(0.5, 0);
    o.up = Vec3d(0, 1, 1);
    refused(o);
}

}  // namespace
}  // namespace vdbcloud
