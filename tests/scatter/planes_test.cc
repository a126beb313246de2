// Power through the planes of the box about a medium: symmetry, balance, furnace, and a light path tracer.
#include "scatter/sweep_cases.h"
#include "support/monte_carlo.h"
#include "support/slab_exact.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace vdbcloud {
namespace {

using test::billows;
using test::constant_like;

Medium grey(double sigma_t, double albedo, double g = 0)
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(sigma_t);
    medium.albedo = Vec3d(albedo);
    medium.phase = test::hg(g);
    return medium;
}

ScatterOptions with_sweeps(int iterations, int directions = 64, OrdinateKind kind = OrdinateKind::Product)
{
    ScatterOptions o;
    o.solve.tolerance = 1e-8;
    o.closure.iterations = iterations;
    o.closure.directions = directions;
    o.closure.kind = kind;
    return o;
}

ChannelReport solved(const FloatGrid& grid, const Medium& medium, const std::vector<Light>& lights,
                     const ScatterOptions& o, const Vec3SGrid* emission = nullptr)
{
    ScatterReport report;
    scatter_p1(grid, nullptr, emission, medium, lights, o, {}, report);
    EXPECT_TRUE(report.channel[0].planes.known);
    return report.channel[0];
}

double sum(const std::array<double, 6>& of) { return std::accumulate(of.begin(), of.end(), 0.0); }

/// A ball of constant density in the middle of a cube of n voxels of edge 1 / n.
FloatGridPtr ball(int n)
{
    return test::voxel_field(Vec3i(n), Vec3d(1.0 / n), [n](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) / n - Vec3d(0.5);
        return x.length() < 0.5 ? 1.0 : 0.0;
    });
}

TEST(Planes, OfALayerAreItsFaces)
{
    const int n = 32;
    const double tau = 4, mu = 0.8;
    const auto slab = test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [&](const Vec3i&) { return tau; });
    const Light sun = make_sun(Vec3d(0.6, mu, 0));
    for (const int iterations : {0, 12}) {
        ScatterOptions o = with_sweeps(iterations);
        o.periodic = {true, false, true};
        const ChannelReport r = solved(*slab, grey(1, 0.9), {sun}, o);
        const double area = 64.0 / n / n;
        for (const int face : {0, 1, 4, 5}) EXPECT_EQ(r.planes.out[size_t(face)], 0);
        // P1: the faces' powers. Sweeps: the division into reflected and transmitted is that of radiance on the faces.
        for (const int face : {2, 3})
            EXPECT_NEAR(r.planes.out[size_t(face)] / r.budget.out[size_t(face)], 1, iterations ? 0.01 : 1e-9);
        EXPECT_NEAR((r.planes.reflected + r.planes.transmitted() + r.budget.absorbed) / r.deposited, 1, 1e-6);
        EXPECT_NEAR(r.planes.reflected / r.planes.out[Blocks::YPlus], 1, 1e-9);
        EXPECT_NEAR(r.planes.transmitted() / r.planes.out[Blocks::YMinus], 1, 1e-9);
        EXPECT_NEAR(r.planes.reentered, 0, 1e-12);
        EXPECT_NEAR(r.planes.scaled_by, 0, 0.01);
        if (!iterations) continue;
        test::SlabExact::Options exact;
        exact.tau = tau;
        exact.w0 = 0.9;
        exact.mu0 = mu;
        const test::SlabExact truth(exact);
        EXPECT_NEAR(r.planes.reflected / area / truth.reflected(), 1, 0.01);
        EXPECT_NEAR(r.planes.transmitted() / area / truth.transmitted(), 1, 0.01);
    }
}

TEST(Planes, OfABallLitFromItsCentreAreAlike)
{
    // A lamp in the middle voxel of 25, and a glow of 24 voxels.
    for (const int n : {25, 24})
        for (const bool sweeps : {false, true}) {
            const auto grid = ball(n);
            const auto glow = n == 24 ? constant_like(*grid, Vec3f(1.0f)) : nullptr;
            const std::vector<Light> lights(n == 24 ? 0 : 1, make_lamp(Vec3d(12.0 / 25)));
            const ScatterOptions o = with_sweeps(sweeps ? 8 : 0, 80, OrdinateKind::LevelSymmetric);
            const ChannelReport r = solved(*grid, grey(8, 1), lights, o, glow.get());
            // By 20000 rays: 3 standard errors of a share of a sixth, 0.0026. By sweeps: a box of whole blocks has the
            // symmetry of the directions; where blocks are cut, light on planes and faces differs by 0.5 %.
            const double most = !sweeps ? 0.008 : n == 24 ? 1e-5 : 0.001;
            for (size_t face = 0; face < 6; ++face) {
                EXPECT_NEAR(r.planes.out[face] / sum(r.planes.out), 1.0 / 6, most) << n << ' ' << sweeps;
                EXPECT_NEAR(r.budget.out[face] / sum(r.budget.out), 1.0 / 6, n == 24 ? 1e-5 : 1e-4);
            }
            EXPECT_NEAR(r.planes.reflected / sum(r.planes.out), 0.5, most) << "without a sun: the half that goes up";
            // What a staircase of faces sends to itself counts as entering again.
            EXPECT_NEAR(r.planes.reentered / sum(r.budget.out), 0, sweeps ? 1e-12 : 0.05);
        }
}

TEST(Planes, HalfTheGlowOfTwoFacingLayersEntersAgain)
{
    const int n = 8, gap = 16;
    const auto grid = test::voxel_field(Vec3i(8, 2 * n + gap, 8), Vec3d(1.0 / n),
                                        [&](const Vec3i& p) { return p.y() < n || p.y() >= n + gap ? 4.0 : 0.0; });
    const auto glow = constant_like(*grid, Vec3f(0.3f));
    ScatterOptions o = with_sweeps(0);
    o.periodic = {true, false, true};
    const ChannelReport r = solved(*grid, grey(1, 0.5), {}, o, glow.get());
    const double out = sum(r.budget.out);
    EXPECT_NEAR(r.planes.reentered / out, 0.5, 0.001);
    EXPECT_NEAR(r.planes.out[Blocks::YMinus] / out, 0.25, 0.001);
    EXPECT_NEAR(r.planes.out[Blocks::YPlus] / out, 0.25, 0.001);
    EXPECT_NEAR(r.budget.out[Blocks::YPlus] / out, 0.5, 1e-3) << "of both layers' upper faces";
    EXPECT_NEAR((sum(r.planes.out) + r.planes.reentered + r.budget.absorbed) / r.emitted, 1, 1e-6);
}

TEST(Planes, BalanceWithTheBudget)
{
    // A cloud with voids, under a sun and a sky of three colours in height.
    const auto grid = test::voxel_field(Vec3i(30, 21, 26), Vec3d(0.04, 0.05, 0.06),
                                        [](const Vec3i& p) { return std::max(billows(p, 30) - 0.1, 0.0); });
    const Light sun = make_sun(Vec3d(0.9, 0.4, 0.2));
    for (const int iterations : {0, 3}) {
        ScatterOptions o = with_sweeps(iterations);
        o.sky = GradientSky{Vec3d(0.05, 0.1, 0.2), Vec3d(0.3), Vec3d(0.02)};
        const ChannelReport r = solved(*grid, grey(40, 0.95, 0.5), {sun}, o);
        const double in = r.deposited + sum(r.planes.sky_in);
        EXPECT_NEAR((sum(r.planes.out) + r.planes.reentered + r.budget.absorbed) / in, 1, 1e-6) << iterations;
        EXPECT_NEAR(r.planes.reflected + r.planes.transmitted(), sum(r.planes.out), 1e-12);
        EXPECT_GT(r.planes.reflected, 0.2 * in);
        EXPECT_GT(r.planes.transmitted(), 0.2 * in);
        EXPECT_GT(r.planes.sky_in[Blocks::YPlus], 1.5 * r.planes.sky_in[Blocks::YMinus]) << "the ground is dark";
        EXPECT_GT(r.planes.reentered, iterations ? -1e-12 : 0.01 * in);
        EXPECT_LT(std::abs(r.planes.scaled_by), 0.15);
        EXPECT_EQ(r.planes.scaled_by != 0, iterations > 0);
    }
}

TEST(Planes, UnderAUniformSkyAWhiteMediumChangesNothing)
{
    const auto grid = test::voxel_field(Vec3i(26), Vec3d(0.04), [](const Vec3i& p) { return billows(p, 26); });
    for (const int iterations : {0, 2}) {
        ScatterOptions o = with_sweeps(iterations);
        o.sky = Sky::constant(Vec3d(0.7));
        const ChannelReport r = solved(*grid, grey(30, 1), {}, o);
        for (size_t face = 0; face < 6; ++face) {
            const double through = r.planes.out[face] + r.planes.reentered / 6;
            // Sweeps: exact. P1: light that enters again was the sky's, which P1 takes in as if in the open.
            EXPECT_NEAR(through / r.planes.sky_in[face], 1, iterations ? 1e-5 : 0.1) << iterations << ' ' << face;
        }
        const auto size = grid->evalActiveVoxelBoundingBox().dim().asVec3d() * 0.04;
        EXPECT_NEAR(sum(r.planes.sky_in), pi * 0.7 * 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]),
                    1e-5);
    }
}

TEST(Planes, LetTheSkyThroughTheVoidOfTheBox)
{
    // Two cubes of 4 voxels at opposite corners of a box of 40. The sky is bright above and dark below: its light that
    // comes in through the top half space leaves through the base and the sides.
    const auto grid = test::voxel_clouds({{Vec3i(0), Vec3i(3)}, {Vec3i(36), Vec3i(39)}}, Vec3d(0.1), 1.0);
    for (const int iterations : {0, 2}) {
        ScatterOptions o = with_sweeps(iterations);
        o.sky = GradientSky{Vec3d(1), Vec3d(1), Vec3d(0), 100};
        const ChannelReport r = solved(*grid, grey(5, 0.5), {}, o);
        EXPECT_NEAR(r.planes.out[Blocks::YMinus] / r.planes.sky_in[Blocks::YPlus], 1, 0.05) << iterations;
        EXPECT_NEAR(r.planes.out[Blocks::YPlus] / r.planes.sky_in[Blocks::YPlus], 0, 0.05) << iterations;
        EXPECT_NEAR(r.planes.out[Blocks::XPlus] / r.planes.sky_in[Blocks::XMinus], 1, 0.05) << iterations;
        EXPECT_NEAR(r.planes.transmitted() / sum(r.planes.out), 1, 0.05) << "the sky's light goes down " << iterations;
    }
}

/// A plate of 45 degrees in its grid: its stairs look along x and y alike. The sun is overhead.
struct TiltedPlate {
    static constexpr int n = 32;
    static FloatGridPtr grid()
    {
        return test::voxel_field(Vec3i(n), Vec3d(1.0 / n), [](const Vec3i& p) {
            const double off = (p.x() + p.y() - 31) / std::sqrt(2.0);
            return std::max(0.0, std::min(1.0, (5 - std::abs(off)) / 2));
        });
    }
    static constexpr double sigma = 14;

    /// Of collided light through a plane, by light paths. The plane stands off by the half voxel that the trilinear
    /// density reaches beyond the voxels.
    static test::McPower by_paths(const FloatGrid& grid, const Vec3d& to_sun, int face, uint64_t paths)
    {
        const BrickMap bricks(grid);
        test::McMedium medium;
        medium.density = &bricks;
        medium.sigma_t = sigma;
        medium.to_sun = to_sun;
        const double lo = -1.0 / n, edge = (n + 1.0) / n;
        const int axis = face / 2;
        Vec3d corner(lo), u(0.0), v(0.0), inward(0.0);
        corner[axis] += face % 2 ? edge : 0;
        u[(axis + 1) % 3] = v[(axis + 2) % 3] = edge;
        inward[axis] = face % 2 ? -1 : 1;
        return test::power_through(medium, corner, u, v, inward, 3, uint64_t(face), paths);
    }
};

TEST(Planes, OfATiltedPlateMatchLightPathsWhereItsFacesDoNot)
{
    const auto grid = TiltedPlate::grid();
    const Vec3d to_sun(0, 1, 0);
    const ChannelReport r = solved(*grid, grey(TiltedPlate::sigma, 1), {make_sun(to_sun)}, with_sweeps(15, 128));
    const ChannelReport p1 = solved(*grid, grey(TiltedPlate::sigma, 1), {make_sun(to_sun)}, with_sweeps(0));
    double total = 0, worst_of_faces = 0;
    std::array<test::McPower, 6> truth;
    for (int face = 0; face < 6; ++face) {
        truth[size_t(face)] = TiltedPlate::by_paths(*grid, to_sun, face, 20000);
        total += truth[size_t(face)].power;
    }
    for (size_t face = 0; face < 6; ++face) {
        const double share = truth[face].power / total, error = truth[face].error / total;
        // 3 standard errors of the paths, and 1 % of all light for voxels of 0.4 mean free paths and 128 directions.
        EXPECT_NEAR(r.planes.out[face] / sum(r.planes.out), share, 3 * error + 0.01) << face;
        EXPECT_NEAR(p1.planes.out[face] / sum(p1.planes.out), share, 3 * error + 0.04) << "P1 " << face;
        worst_of_faces = std::max(worst_of_faces, std::abs(r.budget.out[face] / sum(r.budget.out) - share));
    }
    EXPECT_GT(worst_of_faces, 0.04) << "sorted by the faces' orientation";
    // The trilinear edge of the plate takes 3 % more light than lines one voxel apart see.
    EXPECT_NEAR(sum(r.planes.out) / total, 1, 0.05);
}

TEST(Planes, TurnWithTheGrid)
{
    // Grid and sun turned by 30 degrees about z: the powers through the index planes and the light
    // that is reflected stay.
    const auto grid = TiltedPlate::grid();
    const auto turned = grid->deepCopy();
    const auto transform = grid->transform().copy();
    transform->postRotate(pi / 6, openvdb::math::Z_AXIS);
    turned->setTransform(transform);
    const double c = std::cos(pi / 6), s = std::sin(pi / 6);
    for (const int iterations : {0, 3}) {
        const ScatterOptions o = with_sweeps(iterations);
        const Vec3d sun(0.2, 1, 0.4);
        const ChannelReport a = solved(*grid, grey(14, 0.9), {make_sun(sun)}, o);
        const ChannelReport b = solved(*turned, grey(14, 0.9),
                                       {make_sun(Vec3d(c * sun[0] - s * sun[1], s * sun[0] + c * sun[1], sun[2]))}, o);
        for (size_t face = 0; face < 6; ++face)
            EXPECT_NEAR(a.planes.out[face], b.planes.out[face], 2e-5 * sum(a.planes.out)) << iterations << ' ' << face;
        EXPECT_NEAR(a.planes.reflected, b.planes.reflected, 1e-4 * a.planes.reflected);
    }
}

TEST(Planes, ReflectWhatTheirPhaseFunctionSendsBack)
{
    // A ball of optical radius 0.01 scatters once. Of Henyey-Greenstein's light the part with cos < 0 goes into the
    // hemisphere about the sun:  (1 - g^2) / (2 g) (1 / sqrt(1 + g^2) - 1 / (1 + g)).
    // Sweeps sum 512 directions, of which a hemisphere cuts the cells of some dozens: 1.5 % of all light.
    const auto grid = ball(12);
    for (const double g : {-0.4, 0.0, 0.5})
        for (const Vec3d& sun : {Vec3d(0, 1, 0), Vec3d(0.5, 0.7, -0.2), Vec3d(-1, 0.1, 0.3)}) {
            ScatterOptions o = with_sweeps(1, 512);
            o.delta = false;
            const ChannelReport r = solved(*grid, grey(0.02, 1, g), {make_sun(sun)}, o);
            const double exact = g == 0 ? 0.5 : (1 - g * g) / (2 * g) * (1 / std::sqrt(1 + g * g) - 1 / (1 + g));
            EXPECT_NEAR(r.planes.reflected / sum(r.planes.out), exact, 0.015) << g << ' ' << sun;
        }
}

TEST(Planes, ReflectTheSameInAnyBox)
{
    // A ball, and the ball with a speck at some distance: the box about both is another one. The speck holds a part in
    // 4000 of the voxels. P1's rays have the error of 20000 rays; sweeps divide the same radiance.
    const auto body = [](const Vec3i& away) {
        const auto grid = ball(16);
        grid->tree().setValue(openvdb::Coord(away[0], away[1], away[2]), 1.0f);
        return grid;
    };
    for (const int iterations : {0, 3}) {
        const ScatterOptions o = with_sweeps(iterations);
        const Light sun = make_sun(Vec3d(0.2, 1, 0.4));
        const ChannelReport near = solved(*ball(16), grey(10, 0.98), {sun}, o);
        EXPECT_GT(near.planes.reflected, 0.5 * sum(near.planes.out)) << iterations;
        for (const Vec3i& away : {Vec3i(8, 90, 8), Vec3i(120, 8, 8), Vec3i(8, -300, 8), Vec3i(4000, 4000, 4000)}) {
            const ChannelReport far = solved(*body(away), grey(10, 0.98), {sun}, o);
            EXPECT_NEAR(far.planes.reflected / near.planes.reflected, 1, 0.01) << iterations << ' ' << away;
        }
    }
}

TEST(Planes, OfP1NeedRays)
{
    ScatterOptions o;
    o.reentry_rays = 0;
    ScatterReport report;
    scatter_p1(*ball(12), nullptr, nullptr, grey(4, 1), {make_sun(Vec3d(0, 1, 0))}, o, {}, report);
    EXPECT_FALSE(report.channel[0].planes.known);
    o.closure.iterations = 1;
    scatter_p1(*ball(12), nullptr, nullptr, grey(4, 1), {make_sun(Vec3d(0, 1, 0))}, o, {}, report);
    EXPECT_TRUE(report.channel[0].planes.known) << "sweeps need none";
}

}  // namespace
}  // namespace vdbcloud
