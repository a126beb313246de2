// The same body on voxels of other shapes: what is meant in the world must not follow the edges of voxels.
#include "scatter/p1_solve.h"
#include "support/p1_forms.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

using test::P1Case;

constexpr double radius = 16;

/// Edges of voxels; the longest is a quarter of the ball's radius at most, but for the last one.
const Vec3d shapes[] = {Vec3d(1, 1, 1), Vec3d(1, 2, 1), Vec3d(2, 1, 2), Vec3d(1, 4, 1),
                        Vec3d(4, 1, 4), Vec3d(1, 3, 2), Vec3d(4, 4, 4), Vec3d(1, 1, 8)};

/// A ball whose density falls from 1 to 0 over the length `edge` at its surface; a point of no symmetry is its centre.
struct Ball {
    Vec3d h, centre;
    FloatGridPtr grid;

    Ball(const Vec3d& spacing, double edge) : h(spacing)
    {
        Vec3i n;
        for (int a = 0; a < 3; ++a) {
            n[a] = int(2 * (radius + edge) / h[a]) + 4;
            centre[a] = (n[a] / 2 + 0.13 * (a + 1)) * h[a];
        }
        grid = test::voxel_field(n, h, [&](const Vec3i& p) {
            return std::clamp((radius - from_centre(p).length()) / edge + 0.5, 0.0, 1.0);
        });
    }
    Vec3d from_centre(const Vec3i& p) const { return Vec3d(p.x(), p.y(), p.z()) * h - centre; }
    double area(int axis) const { return h[(axis + 1) % 3] * h[(axis + 2) % 3]; }
};

TEST(VoxelShapes, WeightsOfTheBoundaryAreThoseOfTheBallsNormals)
{
    for (const Vec3d& h : shapes) {
        const Ball ball(h, 2);
        const P1Case c(ball.grid);
        double area = 0, exact = 0, squares = 0, faces = 0;
        for (const ExposedVoxel& voxel : c.exposed) {
            const Vec3d normal = ball.from_centre(c.index.blocks().voxel(voxel.slot)).unit();
            for (int face = 0; face < 6; ++face) {
                if (!(voxel.faces >> face & 1)) continue;
                const double size = ball.area(face / 2), truth = std::abs(normal[face / 2]);
                area += size * voxel.weight[face / 2];
                exact += size * truth;
                squares += size * std::pow(voxel.weight[face / 2] - truth, 2);
                faces += size;
            }
        }
        // The window is as wide as 6 of the longest edges. The ball curves by (3 longest / radius)^2 / 2 across half of
        // it, which turns no normal but blurs them where the staircase is coarse.
        EXPECT_NEAR(area / exact, 1, 0.003) << h;
        EXPECT_LT(std::sqrt(squares / faces), 0.025) << h;
    }
}

TEST(VoxelShapes, WeightsArePermutedWithTheAxes)
{
    const auto by_axis = [](const Vec3d& h) {
        const Ball ball(h, 2);
        const P1Case c(ball.grid);
        std::array<double, 3> sum{};
        for (const ExposedVoxel& voxel : c.exposed)
            for (int a = 0; a < 3; ++a) sum[size_t(a)] += voxel.weight[a];
        return sum;
    };
    // The ball's centre is not permuted, so the staircases differ: a voxel in some thousand.
    const auto x = by_axis(Vec3d(4, 1, 1)), y = by_axis(Vec3d(1, 4, 1)), z = by_axis(Vec3d(1, 1, 4));
    for (size_t a = 0; a < 3; ++a) {
        EXPECT_NEAR(y[(a + 1) % 3] / x[a], 1, 0.02) << a;
        EXPECT_NEAR(z[(a + 2) % 3] / x[a], 1, 0.02) << a;
    }
}

/// Area of a body's exposed faces by their weights, and without.
std::pair<double, double> leaking_area(const P1Case& c)
{
    const Vec3d h = c.index.spacing();
    double weighted = 0, whole = 0;
    for (const ExposedVoxel& voxel : c.exposed)
        for (int face = 0; face < 6; ++face) {
            if (!(voxel.faces >> face & 1)) continue;
            const double size = h[0] * h[1] * h[2] / h[face / 2];
            weighted += size * voxel.weight[face / 2];
            whole += size;
        }
    return {weighted, whole};
}

TEST(VoxelShapes, ThinBodiesLeakThroughTheirOwnArea)
{
    // The faces of a box are its area. At an edge or a corner a normal in between lessens the weights, by 1 / sqrt(3)
    // at most; the middle of a plate loses nothing.
    const Vec3i sizes[] = {{1, 1, 1}, {2, 2, 1}, {3, 3, 1}, {1, 2, 5}, {4, 4, 4}, {7, 2, 7}, {3, 3, 7}, {1, 9, 9}};
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(13.4, 0.0757, 0.627), Vec3d(0.6, 13, 0.08), Vec3d(1, 200, 1),
                           Vec3d(200, 1, 200), Vec3d(1, 1, 1e-5)})
        for (const Vec3i& n : sizes) {
            const P1Case c(test::voxel_field(n, h, [](const Vec3i&) { return 1.0; }));
            const auto [weighted, whole] = leaking_area(c);
            EXPECT_LE(weighted, whole * (1 + 1e-6)) << h << ' ' << n;
            EXPECT_GE(weighted, whole / std::sqrt(3.0)) << h << ' ' << n;
        }
    // A plate with edges of two voxels in forty loses under a tenth, whatever its voxels.
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(1, 0.01, 3), Vec3d(5, 0.3, 0.5)}) {
        const auto [weighted, whole] =
            leaking_area(P1Case(test::voxel_field(Vec3i(40, 1, 40), h, [](const Vec3i&) { return 1.0; })));
        EXPECT_LE(weighted, whole * (1 + 1e-6)) << h;
        EXPECT_GE(weighted, 0.9 * whole) << h;
    }
}

TEST(VoxelShapes, ThinSlantedSheetsLeakThroughTheAreaOfTheirPlane)
{
    // Voxels (i, j, k) with i = j along a diagonal, k across: staircases of 2 x 2 faces a voxel, sqrt(2) times as large
    // as the sheet's two sides. Faces at the rim are few.
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(1, 1, 0.2), Vec3d(1, 0.9, 1)}) {
        const P1Case c(test::voxel_field(Vec3i(40, 40, 40), h,
                                         [](const Vec3i& p) { return p[0] == p[1] || p[0] == p[1] + 1 ? 1.0 : 0.0; }));
        const double plane = 2 * 39.5 * std::hypot(h[0], h[1]) * 40 * h[2];
        EXPECT_NEAR(leaking_area(c).first / plane, 1, 0.08) << h;
    }
}

/// Relative error of the fluence at the voxel nearest to the centre, of a ball of even emission.
double sphere_error(const Vec3d& h, double tau)
{
    const Ball ball(h, 0.01);
    P1Case c(ball.grid);
    const double sigma = tau / radius;
    const P1Operator p1(c.index, c.density, c.exposed, {sigma, 1, nullptr, test::hg(0), true});
    P1Source source(p1);
    add_emission(p1, std::vector<float>(c.index.blocks().slots(), 1.0f), 1 / (4 * pi), source);
    const test::Solved s = test::solve(p1, source, 1e-8);
    // Of the volume that the voxels have: a ball on coarse voxels has another one than its own.
    const double volume = double(c.index.blocks().active_count()) * h[0] * h[1] * h[2];
    const test::P1Sphere exact{std::cbrt(volume * 3 / (4 * pi)), 1 / (3 * sigma), 0, 1, 0};
    double nearest = 1e9, error = 0;
    for (size_t slot = 0; slot < c.index.blocks().count() * 512; ++slot) {
        if (!c.index.blocks().active(slot)) continue;
        const double r = ball.from_centre(c.index.blocks().voxel(slot)).length();
        if (r < nearest) error = s.phi[slot] / exact.phi(r) - 1;
        nearest = std::min(nearest, r);
    }
    return error;
}

TEST(VoxelShapes, FluenceOfASphereErrsAsMuchAsTheLongestEdgeIsLong)
{
    // To first order a ball of voxels has less area than its volume's sphere, so it keeps its light longer. On cubes of
    // the edges 1, 2 and 4 the error is 0.9, 2.5, 6.5 % at optical radius 1, and a tenth of that at 8.
    for (const Vec3d& h : shapes) {
        const double longest = std::max({h[0], h[1], h[2]});
        const double thin = sphere_error(h, 1) / longest, thick = sphere_error(h, 8) / longest;
        EXPECT_GT(thin, 0.006) << h;
        EXPECT_LT(thin, 0.018) << h;
        EXPECT_GT(thick, -0.0005) << h;
        EXPECT_LT(thick, 0.003) << h;
    }
}

TEST(VoxelShapes, NoLightOfABallEntersItAgain)
{
    for (const Vec3d& h : shapes) {
        const Ball ball(h, 0.01);
        const P1Case c(ball.grid);
        const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(0), true});
        P1Source source(p1);
        const std::vector<double> phi(c.index.blocks().slots(), 1.0);
        EXPECT_LT(reentry_share(p1, source, phi, 20000), 0.01) << h;
    }
}

TEST(VoxelShapes, HalfTheLightOfFacingSheetsEntersAgain)
{
    // Sheets of 96 x 2 x 96, 6 apart: nearly all light of the inner sides hits again, about half of the total.
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(2, 0.5, 2), Vec3d(0.5, 1, 3), Vec3d(1, 0.25, 1)}) {
        const Vec3i n(int(96 / h[0]), int(10 / h[1]), int(96 / h[2]));
        const P1Case c(test::voxel_field(n, h, [&](const Vec3i& p) {
            const double y = (p.y() + 0.5) * h[1];
            return y < 2 || y > 8 ? 1.0 : 0.0;
        }));
        const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(0), true});
        P1Source source(p1);
        const std::vector<double> phi(c.index.blocks().slots(), 1.0);
        EXPECT_NEAR(reentry_share(p1, source, phi, 20000), 0.45, 0.06) << h;
    }
}

/// Power that a sun loses in a body, by voxel faces and by lines.
std::pair<double, double> lost(const P1Case& c, double sigma, const Vec3d& to_sun)
{
    const P1Operator p1(c.index, c.density, c.exposed, {sigma, 1, nullptr, test::hg(0), false});
    const BrickMap bricks(*c.grid);
    const Light sun = make_sun(to_sun);
    P1Source source(p1);
    add_beam(p1, beam_depths(c.index, c.exposed, bricks, sun), sigma, {{&source, 1.0}});
    return {source.deposited, lost_power(line_depths(c.index, c.density, sun), sigma)};
}

TEST(VoxelShapes, LinesAlongAnAxisAreExactInACube)
{
    // A cube of edge 32: 1024 (1 - exp(-6.4)), whatever its voxels. Faces have float depths.
    const double exact = 1024 * -std::expm1(-6.4);
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(4, 1, 4), Vec3d(1, 4, 1), Vec3d(2, 8, 1), Vec3d(4, 4, 4)}) {
        const P1Case c(test::voxel_field(Vec3i(int(32 / h[0]), int(32 / h[1]), int(32 / h[2])), h,
                                         [](const Vec3i&) { return 1.0; }));
        for (int axis = 0; axis < 6; ++axis) {
            Vec3d to(0, 0, 0);
            to[axis / 2] = axis % 2 ? 1 : -1;
            const auto [faces, lines] = lost(c, 0.2, to);
            EXPECT_NEAR(lines / exact, 1, 1e-12) << h << ' ' << to;
            EXPECT_NEAR(faces / exact, 1, 1e-6) << h << ' ' << to;
        }
    }
}

TEST(VoxelShapes, LinesThroughABallErrAtSecondOrderInTheLongestEdge)
{
    // (1 - r^2 / R^2) has the depth (4/3) R (1 - b^2 / R^2)^1.5 at the distance b from the centre; the integral over b
    // by the substitution u = 1 - b^2 / R^2 and Simpson's rule. Cells spread the ball by h^2 / 12, which lets less
    // through.
    const double sigma = 0.3, deepest = sigma * 4 / 3 * radius;
    double integral = 0;
    const int parts = 2000;
    for (int n = 0; n <= parts; ++n)
        integral += (n == 0 || n == parts ? 1
                     : n % 2              ? 4
                                          : 2) *
                    -std::expm1(-deepest * std::pow(double(n) / parts, 1.5));
    const double exact = pi * radius * radius * integral / (3 * parts);
    for (const Vec3d& h : shapes) {
        const Vec3i n(int(2 * radius / h[0]) + 4, int(2 * radius / h[1]) + 4, int(2 * radius / h[2]) + 4);
        const P1Case c(test::voxel_field(n, h, [&](const Vec3i& p) {
            const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) - 0.5 * Vec3d(n.x(), n.y(), n.z()) + Vec3d(0.7, 0.8, 0.9)) * h;
            return 1 - x.dot(x) / (radius * radius);
        }));
        for (const Vec3d& to : {Vec3d(0.3, 1, 0.2), Vec3d(0.7, 0.6, 0.5), Vec3d(1, -0.2, 0.4)}) {
            const double error = lost(c, sigma, to).second / exact - 1;
            const double longest = std::max({h[0], h[1], h[2]}) / radius;
            EXPECT_GT(error, 0.03 * longest * longest) << h << ' ' << to;
            EXPECT_LT(error, 0.8 * longest * longest) << h << ' ' << to;
        }
    }
}

TEST(VoxelShapes, FluenceOfABeamIsLinearFromCentreToCentreAlongTheBeam)
{
    // In a layer the fluence at depth d is exp(-sigma d). Thin voxels have it at the centre, divided by 1 + x^2 / 12,
    // thick ones the mean, x = sigma h along the beam.
    const double sigma = 0.15;
    for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(1, 4, 1), Vec3d(4, 1, 4), Vec3d(0.5, 2, 3)}) {
        P1Case c(test::voxel_field(Vec3i(8, 20, 8), h, [](const Vec3i&) { return 1.0; }), {true, false, true});
        const P1Operator p1(c.index, c.density, c.exposed, {sigma, 1, nullptr, test::hg(0), false});
        const Light sun = make_sun(Vec3d(0, 1, 0));
        const auto fluence = beam_fluence(p1, periodic_beam_depths(c.index, c.exposed, c.density, sun),
                                          periodic_centre_depths(c.index, c.density, sun), sigma);
        const double x = sigma * h[1], thick = x * x / (0.25 + x * x);
        for (int y = 0; y < 20; ++y) {
            const double centre = std::exp(-x * (20 - y - 0.5)), chord = centre / (1 + x * x / 12),
                         mean = centre * std::sinh(x / 2) / (x / 2);
            EXPECT_NEAR(fluence[c.index.blocks().slot(Vec3i(3, y, 5))] / (chord + thick * (mean - chord)), 1, 3e-6)
                << h << ' ' << y;
        }
    }
}

TEST(VoxelShapes, LinesCostTheBlocksThatTheyMeet)
{
    // Voxels 3000 apart along each axis. A line for each voxel of the box's side would be 10^9 lines. A body of 12
    // blocks has lines an eighth of a voxel apart.
    std::vector<std::pair<Vec3i, Vec3i>> voxels;
    for (int k = 0; k < 12; ++k) voxels.emplace_back(Vec3i(3000 * k), Vec3i(3000 * k));
    const P1Case c(test::voxel_clouds(voxels, Vec3d(1, 2, 1), 1.0));
    for (const Vec3d& to : {Vec3d(0, 1, 0), Vec3d(0.3, 1, 0.2)}) {
        const LineDepths lines = line_depths(c.index, c.density, make_sun(to));
        const size_t each = to[0] == 0 ? 1 : 8 * 8;
        EXPECT_GE(lines.depth.size(), each * voxels.size());
        EXPECT_LE(lines.depth.size(), 3 * each * voxels.size()) << "lines with depth above 0";
    }
}

TEST(VoxelShapes, RaysThatLeaveCrossEmptinessInFewSteps)
{
    // A ball and a voxel 1000 and 1000000 away along each axis: the cells that rays cross grow with the logarithm.
    const auto steps = [](int away) {
        const P1Case c(test::voxel_clouds({{Vec3i(0), Vec3i(15)}, {Vec3i(away), Vec3i(away)}}, Vec3d(1), 1.0));
        const P1Operator p1(c.index, c.density, c.exposed, {1, 1, nullptr, test::hg(0), true});
        P1Source source(p1);
        const std::vector<double> phi(c.index.blocks().slots(), 1.0);
        const OutflowRays rays = trace_outflow(p1, source, phi, nullptr, nullptr, 0, Hemisphere(Vec3d(0, 1, 0)), 2000);
        EXPECT_LT(rays.reentry, 1e-3);
        EXPECT_GT(rays.steps, 2000u);
        return double(rays.steps);
    };
    const double near = steps(1000), far = steps(100000);
    EXPECT_LT(near / 2000, 40);
    EXPECT_LT(far / 2000, 90) << "12500 blocks away";
}

TEST(VoxelShapes, ABallReflectsTheSameInVoxelsOfAnyShape)
{
    // What leaves into the hemisphere about the sun, of what the sun loses. The box about the voxels follows their
    // edges, and with it the power through its planes. Light is first order in the longest edge, as the fluence is.
    for (const int iterations : {0, 3}) {
        double cubes = 0;
        for (const Vec3d& h : {Vec3d(1, 1, 1), Vec3d(2, 1, 2), Vec3d(1, 4, 1), Vec3d(4, 1, 4), Vec3d(4, 4, 4)}) {
            const Ball ball(h, 2);
            Medium medium;
            medium.sigma_t_per_density = Vec3d(0.3);
            medium.albedo = Vec3d(1);
            ScatterOptions o;
            o.closure.iterations = iterations;
            ScatterReport report;
            scatter_p1(*ball.grid, nullptr, nullptr, medium, {make_sun(Vec3d(0, 1, 0))}, o, {}, report);
            const ChannelReport& r = report.channel[0];
            const double reflected = r.planes.reflected / r.deposited, longest = std::max({h[0], h[1], h[2]});
            if (longest == 1) cubes = reflected;
            EXPECT_NEAR(reflected / cubes, 1, 0.01 * longest) << h << ' ' << iterations;
        }
        EXPECT_NEAR(cubes, 0.67, 0.02) << iterations;
    }
}

}  // namespace
}  // namespace vdbcloud
