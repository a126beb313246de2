// The endless ground beneath a medium that ends on all sides: closed forms, energy, furnace, symmetry, sums of lights.
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/size.h"
#include "support/voxel_field.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbcloud {
namespace {

constexpr double mu = 0.8;  // of the sun

Light sun() { return make_sun(Vec3d(0.6, mu, 0)); }

Medium medium(double sigma_t, double w0, double g = 0)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    m.albedo = Vec3d(w0);
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

/// A ball of diameter 1 whose density falls smoothly to 0, n voxels across.
FloatGridPtr ball(int n)
{
    return test::voxel_field(Vec3i(n, n, n), Vec3d(1.0 / n), [n](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) * (2.0 / n) - Vec3d(1.0);
        return std::max(0.0, 1 - x.dot(x));
    });
}

/// A slab of thickness 1.
FloatGridPtr slab(int width, int n)
{
    return test::voxel_field(Vec3i(width, n, width), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; });
}

ScatterOptions over(std::optional<double> albedo, int iterations)
{
    ScatterOptions o;
    o.ground_albedo = albedo;
    o.closure.iterations = iterations;
    o.closure.directions = 32;
    o.closure.change = 1e-6;
    o.solve.tolerance = 1e-9;
    o.reentry_rays = 0;
    o.line_rays = 0;
    return o;
}

struct Outcome {
    ScatterReport report;
    CollidedLight light;
    const ChannelReport& channel() const { return report.channel[0]; }
    const FloatGrid& phi() const { return static_cast<const FloatGrid&>(*light.phi); }
    double phi_at(int x, int y, int z) const { return phi().tree().getValue(openvdb::Coord(x, y, z)); }
    const Vec3SGrid& ground() const { return static_cast<const Vec3SGrid&>(*report.ground); }
};

Outcome scattered(const FloatGrid& grid, const Medium& m, const std::vector<Light>& lights, const ScatterOptions& o,
                  const Vec3SGrid* emission = nullptr)
{
    Outcome out;
    out.light = scatter_p1(grid, nullptr, emission, m, lights, o, {}, out.report);
    EXPECT_TRUE(out.report.converged);
    return out;
}

double sum(const std::array<double, 6>& of) { return of[0] + of[1] + of[2] + of[3] + of[4] + of[5]; }

/// What the beams lose in the medium, what it emits and what comes in from sky and ground leaves the box or is
/// absorbed.
void expect_energy_closes(const Outcome& found)
{
    const ChannelReport& c = found.channel();
    const double in = c.deposited + c.emitted + sum(c.planes.sky_in) + c.planes.from_ground;
    EXPECT_NEAR((sum(c.planes.out) + c.planes.reentered + c.budget.absorbed) / in, 1, 1e-5);
}

/// The largest difference of two fields of the same voxels, relative to the largest value.
template<typename Other>
double difference(const FloatGrid& a, const Other& b)
{
    double worst = 0, largest = 0;
    for (auto v = a.cbeginValueOn(); v; ++v) {
        worst = std::max(worst, std::abs(double(*v) - b(v.getCoord())));
        largest = std::max(largest, double(std::abs(*v)));
    }
    EXPECT_GT(largest, 0);
    return worst / largest;
}

TEST(EndlessGround, LightsAThinCloudAsAnInfinitePlane)
{
    // Radiance B = A mu E / pi from the lower half of all directions: fluence 2 pi B. A cloud of 1e-3 mean free paths
    // adds light that it scatters, and a shadow, of that order.
    for (const double albedo : {0.3, 0.8})
        for (const int iterations : {0, 6}) {
            const Outcome found = scattered(*ball(12), medium(1e-3, 1), {sun()}, over(albedo, iterations));
            const double plane = 2 * albedo * mu;
            EXPECT_NEAR(found.channel().budget.smallest, plane, 3e-3 * plane) << albedo << " " << iterations;
            EXPECT_NEAR(found.channel().budget.largest, plane, 3e-3 * plane);
            EXPECT_NEAR(found.ground().background()[1], albedo * mu / pi, 1e-6);
            expect_energy_closes(found);
        }
}

TEST(EndlessGround, ABlackOneChangesNoBit)
{
    for (const int iterations : {0, 3}) {
        const Outcome none = scattered(*ball(12), medium(8, 0.95, 0.5), {sun()}, over(std::nullopt, iterations));
        const Outcome black = scattered(*ball(12), medium(8, 0.95, 0.5), {sun()}, over(0.0, iterations));
        EXPECT_FALSE(none.report.ground);
        EXPECT_EQ(difference(none.phi(), [&](auto p) { return black.phi().tree().getValue(p); }), 0);
        EXPECT_EQ(none.channel().budget.out, black.channel().budget.out);
        EXPECT_EQ(black.ground().background(), Vec3f(0.0f));
        EXPECT_EQ(black.channel().planes.from_ground, 0);
        EXPECT_LT(black.channel().ground.direct, 0);
        EXPECT_GT(black.channel().ground.diffuse, 0);
    }
}

TEST(EndlessGround, WhiteFurnaceIsUniform)
{
    for (const double sigma_t : {2.0, 60.0})
        for (const int iterations : {0, 12}) {
            ScatterOptions o = over(1, iterations);
            o.sky = Sky::constant(Vec3d(1.0));
            const Outcome found = scattered(*ball(12), medium(sigma_t, 1), {}, o);
            EXPECT_NEAR(found.channel().budget.smallest, 4 * pi, 1e-4);
            EXPECT_NEAR(found.channel().budget.largest, 4 * pi, 1e-4);
            for (auto v = found.ground().cbeginValueOn(); v; ++v) ASSERT_NEAR((*v)[0], 1, 1e-5);
            expect_energy_closes(found);
        }
}

TEST(EndlessGround, UnderAnIsothermalMediumItIsAFurnaceAndShinesByEmissionAlone)
{
    // j = sigma_a B under a sky of radiance B over a white ground: 4 pi B. Without the sky the light on the ground is
    // the medium's: over a ground that sends it back, phi is larger.
    const double sigma_t = 4, albedo = 0.6;
    const FloatGridPtr grid = ball(12);
    auto emission = Vec3SGrid::create(Vec3f(0.0f));
    emission->setTransform(grid->transform().copy());
    for (auto v = grid->cbeginValueOn(); v; ++v)
        emission->tree().setValueOn(v.getCoord(), Vec3f(float((1 - albedo) * sigma_t * *v)));
    for (const int iterations : {0, 6}) {
        ScatterOptions o = over(1, iterations);
        o.sky = Sky::constant(Vec3d(1.0));
        const Outcome furnace = scattered(*grid, medium(sigma_t, albedo), {}, o, emission.get());
        EXPECT_NEAR(furnace.channel().budget.smallest / (4 * pi), 1, 1e-5) << iterations;
        EXPECT_NEAR(furnace.channel().budget.largest / (4 * pi), 1, 1e-5);
        o.sky = {};
        const Outcome white = scattered(*grid, medium(sigma_t, albedo), {}, o, emission.get());
        o.ground_albedo = 0;
        const Outcome black = scattered(*grid, medium(sigma_t, albedo), {}, o, emission.get());
        EXPECT_EQ(white.ground().background()[0], 0);
        EXPECT_EQ(white.channel().ground.direct, 0);
        EXPECT_GT(white.channel().ground.diffuse, 0.25 * white.channel().emitted);
        EXPECT_GT(white.phi_at(6, 1, 6), 1.1 * black.phi_at(6, 1, 6));
        EXPECT_LT(white.phi_at(6, 10, 6), 1.1 * black.phi_at(6, 10, 6));
        expect_energy_closes(white);
        expect_energy_closes(black);
    }
}

TEST(EndlessGround, ItsShadowIsWhatTheBeamsLose)
{
    // The same power by faces of voxels and by cells of the plane: of second order in the voxel, 1.2 % at 16 across.
    // The light that comes down again is less, and where nothing absorbs, nearly half of the rest of what goes out.
    for (const Vec3d& to_sun : {Vec3d(0, 1, 0), Vec3d(0.6, 0.8, 0), Vec3d(-0.3, 0.3, 0.9)}) {
        const Outcome found = scattered(*ball(16), medium(6, 1), {make_sun(to_sun)}, over(0.5, 6));
        const ChannelReport& c = found.channel();
        EXPECT_NEAR(-c.ground.direct / c.deposited, 1, 0.02);
        EXPECT_GT(c.ground.diffuse, 0.15 * c.deposited);
        EXPECT_LT(c.ground.diffuse, 0.7 * c.deposited);
        EXPECT_NEAR(c.ground.sent_up, 0.5 * (c.ground.direct + c.ground.diffuse), 1e-6 * c.deposited);
        EXPECT_GT(c.planes.from_ground, 0);
        expect_energy_closes(found);
    }
}

TEST(EndlessGround, TheLightOnItIsWhatLeavesDownwards)
{
    // Over a black ground and under a sun at the zenith: what goes out through the base, and of the sides the part that
    // goes down, lands on the patch but for what lands beyond two heights. Of a thin cloud a half goes down; of an
    // isotropic source in the middle of the box 10 to 25 % of that lands beyond the patch.
    const Outcome found = scattered(*ball(16), medium(1e-2, 1), {make_sun(Vec3d(0, 1, 0))}, over(0.0, 6));
    const ChannelReport& c = found.channel();
    EXPECT_GT(c.ground.diffuse / c.deposited, 0.5 * 0.75);
    EXPECT_LT(c.ground.diffuse / c.deposited, 0.5 * 0.9);
}

/// What a ground of albedo 0.8 makes of the middle of a slab: its radiance there, and the lowest and the highest
/// voxel's fluence against that without a ground.
std::array<double, 3> gain(int width, int n, int iterations, bool repeats)
{
    ScatterOptions bare = over(std::nullopt, iterations), lit = over(0.8, iterations);
    bare.periodic = lit.periodic = {repeats, false, repeats};
    const FloatGridPtr grid = slab(width, n);
    const Outcome with = scattered(*grid, medium(2, 1), {sun()}, lit),
                  without = scattered(*grid, medium(2, 1), {sun()}, bare);
    if (!repeats) expect_energy_closes(with);
    const int at = width / 2;
    return {double(with.ground().tree().getValue(openvdb::Coord(at, -1, at))[0]),
            with.phi_at(at, 0, at) / without.phi_at(at, 0, at),
            with.phi_at(at, n - 1, at) / without.phi_at(at, n - 1, at)};
}

TEST(EndlessGround, UnderAWideSlabIsThatOfALayer)
{
    // The ground makes the lowest voxels 3 times as bright. What a slab loses at its sides falls as its width
    // grows: 1.2 % at 6 thicknesses. At 9 and more the rest is that the ground of a layer lies beneath voxels of
    // constant density, this one beneath trilinear ones. P1 takes the light on the ground from a sweep of its light: it
    // is 7 % less than that of its own currents.
    const int n = 4, width = test::sized(9, 12);
    for (const int iterations : {0, 12}) {
        const auto layer = gain(8, n, iterations, true), narrow = gain(6 * n, n, iterations, false),
                   wide = gain(width * n, n, iterations, false);
        EXPECT_GT(layer[1], 2.5);
        for (size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(wide[k] / layer[k], 1, iterations ? 0.02 : 0.08) << iterations << " " << k;
            if (iterations > 0 || k == 0) {
                EXPECT_LT(narrow[k], wide[k]) << "light is lost at the sides";
            }
        }
    }
}

TEST(EndlessGround, TurnsWithTheSun)
{
    const FloatGridPtr grid = ball(12);
    for (const int iterations : {0, 4}) {
        const Outcome a = scattered(*grid, medium(6, 0.98), {make_sun(Vec3d(0.6, 0.8, 0))}, over(0.8, iterations)),
                      b = scattered(*grid, medium(6, 0.98), {make_sun(Vec3d(0, 0.8, 0.6))}, over(0.8, iterations));
        // Single precision; the sweep's layouts of the axes differ.
        EXPECT_LT(
            difference(a.phi(), [&](auto p) { return b.phi().tree().getValue(openvdb::Coord(p.z(), p.y(), p.x())); }),
            2e-5)
            << iterations;
        EXPECT_GT(difference(a.phi(), [&](auto p) { return b.phi().tree().getValue(p); }), 0.01);
    }
}

TEST(EndlessGround, LiesAcrossAnyAxis)
{
    // Up along -y is the picture upside down: 8e-4, and 2e-3 without a ground. The body fills whole blocks of 8 voxels
    // either way, for the sweep crosses voids within blocks otherwise than between them. Without its place and its way
    // the ground would be off by tens of per cent.
    ScatterOptions o = over(0.8, 4);
    const int n = 16;
    const FloatGridPtr body = test::voxel_field(Vec3i(n, n, n), Vec3d(1.0 / n), [](const Vec3i& p) {
        return p.y() < 8 ? 1.0 : p.x() < 11 && p.z() > 4 ? 0.5 : 0.0;
    });
    const FloatGridPtr turned = test::voxel_field(Vec3i(n, n, n), Vec3d(1.0 / n), [&](const Vec3i& p) {
        return double(body->tree().getValue(openvdb::Coord(p.x(), n - 1 - p.y(), p.z())));
    });
    const FloatGridPtr along_z = test::voxel_field(Vec3i(n, n, n), Vec3d(1.0 / n), [&](const Vec3i& p) {
        return double(body->tree().getValue(openvdb::Coord(p.x(), p.z(), p.y())));
    });
    const Outcome upright = scattered(*body, medium(4, 0.98), {make_sun(Vec3d(0.6, 0.8, 0))}, o);
    o.up = Vec3d(0, -1, 0);
    const Outcome down = scattered(*turned, medium(4, 0.98), {make_sun(Vec3d(0.6, -0.8, 0))}, o);
    o.up = Vec3d(0, 0, 1);
    const Outcome z_up = scattered(*along_z, medium(4, 0.98), {make_sun(Vec3d(0.6, 0, 0.8))}, o);
    EXPECT_LT(
        difference(upright.phi(),
                   [&](auto p) { return down.phi().tree().getValue(openvdb::Coord(p.x(), n - 1 - p.y(), p.z())); }),
        3e-3);
    EXPECT_LT(difference(upright.phi(),
                         [&](auto p) { return z_up.phi().tree().getValue(openvdb::Coord(p.x(), p.z(), p.y())); }),
              2e-5);
    EXPECT_NEAR(upright.channel().planes.from_ground / down.channel().planes.from_ground, 1, 1e-4);
}

TEST(EndlessGround, LightOfSunsAndSkyAddsUp)
{
    // P1 to rounding; sweeps to their change at the fixed point, times ten.
    const Light a = make_sun(Vec3d(0.6, 0.8, 0)), b = make_sun(Vec3d(-0.3, 0.9, 0.2), Vec3d(0.5));
    for (const int iterations : {0, 30}) {
        ScatterOptions o = over(0.7, iterations);
        const auto phi = [&](const std::vector<Light>& lights, double sky) {
            o.sky = Sky::constant(Vec3d(sky));
            return scattered(*ball(8), medium(6, 0.98, 0.4), lights, o);
        };
        const Outcome all = phi({a, b}, 0.2), first = phi({a}, 0), second = phi({b}, 0), sky = phi({}, 0.2);
        EXPECT_LT(difference(all.phi(),
                             [&](auto p) {
                                 return double(first.phi().tree().getValue(p)) + second.phi().tree().getValue(p) +
                                        sky.phi().tree().getValue(p);
                             }),
                  iterations ? 1e-5 : 2e-6)
            << iterations;
    }
}

TEST(EndlessGround, CellsGrowWhereThePatchIsWide)
{
    // A thin tower: cells of several voxels, whose shadow still has the power that the sun loses along lines, and which
    // lie where the ground lies.
    const FloatGridPtr tower = test::voxel_field(Vec3i(4, 96, 4), Vec3d(0.01), [](const Vec3i&) { return 1.0; });
    ScatterOptions o = over(0.6, 3);
    o.line_rays = 1;
    const Outcome found = scattered(*tower, medium(2, 0.9), {make_sun(Vec3d(3, 1, 0))}, o);
    const Vec3SGrid& ground = found.ground();
    EXPECT_GE(ground.voxelSize()[0], 0.02 - 1e-9);
    EXPECT_NEAR(ground.voxelSize()[1], 0.01, 1e-9);
    EXPECT_LE(ground.activeVoxelCount(), size_t(1) << 16);
    EXPECT_NEAR(-found.channel().ground.direct / found.channel().lines, 1, 0.02);
    const auto box = ground.evalActiveVoxelBoundingBox();
    const openvdb::Vec3d low = ground.indexToWorld(box.min()), high = ground.indexToWorld(box.max());
    EXPECT_NEAR(low[1], -0.01, 1e-9);
    EXPECT_NEAR(high[1], -0.01, 1e-9);
    EXPECT_LT(low[0], -3 * 0.97) << "the shadow falls towards -x";
    EXPECT_GT(low[0], -3 * 1.1);
    EXPECT_LT(low[2], -1.9);
    EXPECT_GT(high[2], 1.9);
    expect_energy_closes(found);
}

TEST(EndlessGround, WhatItDoesNotAllowIsRefused)
{
    const FloatGridPtr grid = ball(8);
    const auto refused = [&](const ScatterOptions& o, const Light& light = sun()) {
        ScatterReport report;
        EXPECT_THROW(scatter_p1(*grid, nullptr, nullptr, medium(1, 1), {light}, o, {}, report), InputError);
    };
    refused(over(1.5, 0));
    refused(over(-0.1, 0));
    refused(over(0.5, 0), make_sun(Vec3d(0.8, -0.6, 0)));
    refused(over(0.5, 0), make_lamp(Vec3d(0.5, 3, 0.5), Vec3d(1.0)));
    ScatterOptions o = over(0.5, 0);
    o.up = Vec3d(0, 1, 1);
    refused(o);
}

}  // namespace
}  // namespace vdbcloud
