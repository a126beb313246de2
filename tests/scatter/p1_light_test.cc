// P1 with suns and lamps: convergence in hard media, the balance of energy, and scatter_p1() as a whole.
#include "scatter/p1_solve.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/beam.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::bumpy;
using test::P1Case;
using test::solve;
using test::Solved;

TEST(Sun, ConvergesAndBalancesInHardMedia)
{
    const std::pair<const char*, FloatGridPtr> cases[] = {
        {"salt and pepper with voids",
         test::voxel_field(Vec3i(20, 22, 18), Vec3d(1), [](const Vec3i& p) { return bumpy(p, 3); })},
        {"thin as 1e-12", test::voxel_field(Vec3i(16), Vec3d(1), [](const Vec3i&) { return 1e-12; })},
        {"100 a voxel", test::voxel_field(Vec3i(16), Vec3d(1), [](const Vec3i&) { return 100.0; })},
        {"1e4 deep", test::voxel_field(Vec3i(8, 200, 8), Vec3d(1), [](const Vec3i&) { return 50.0; })},
        {"one voxel", test::voxel_field(Vec3i(1), Vec3d(1), [](const Vec3i&) { return 1.0; })},
        {"two clouds far apart",
         test::voxel_field(Vec3i(200, 4, 4), Vec3d(1),
                           [](const Vec3i& p) { return p.x() < 5 || p.x() > 190 ? 1.0 : 0.0; })},
    };
    for (const auto& [name, grid] : cases)
        for (double g : {0.0, 0.85, 0.99, -0.9})
            for (double albedo : {1.0, 0.9}) {
                Medium medium;
                medium.sigma_t_per_density = Vec3d(1);
                medium.phase = test::hg(g);
                medium.albedo = Vec3d(albedo);
                const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
                ScatterOptions options;
                options.solve.max_iterations = 400;
                ScatterReport report;
                const auto fields = scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
                const auto& c = report.channel[0];
                EXPECT_TRUE(report.converged) << name << " g " << g << " residual " << c.solve.residual;
                EXPECT_TRUE(std::isfinite(c.budget.smallest) && std::isfinite(c.budget.largest)) << name;
                EXPECT_GT(c.budget.largest, 0) << name;
                EXPECT_EQ(c.budget.negative > 0, c.budget.smallest < -1e-7 * c.budget.largest) << name;
                if (g == 0 && std::string(name) != "salt and pepper with voids" &&
                    std::string(name) != "thin as 1e-12") {
                    EXPECT_EQ(c.budget.negative, 0) << name << ' ' << c.budget.smallest;
                }
                // The power that a medium of 1e-12 removes from the beam is a difference of doubles near 1.
                EXPECT_LT(c.budget.defect * c.deposited, 1e-6 * c.deposited + 1e-13 * c.beam_in) << name << " g " << g;
            }
}

/// A smooth cloud in the unit box at n voxels per edge: power that the sun loses, by voxel faces and by lines.
std::pair<double, double> cloud_power(int n, const Vec3d& to_light, double* defect)
{
    const double h = 1.0 / n;
    const auto grid = test::voxel_field(Vec3i(n), Vec3d(h), [&](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) + Vec3d(0.5)) * h - Vec3d(0.5);
        const double r2 = x.dot(x) / 0.16;
        return r2 < 1 ? (1 - r2) * (1 - r2) * (1.2 + std::sin(9 * x[0] + 4 * x[1])) : 0.0;
    });
    P1Case c(grid);
    const P1Operator p1(c.index, c.density, c.exposed, {12, 0.99, nullptr, test::hg(0.85), true});
    const BrickMap bricks(*grid);
    const Light sun = make_sun(to_light);
    P1Source source(p1);
    const double extinction = 12 * p1.scaling(0).extinction;
    add_beam(p1, beam_depths(c.index, c.exposed, bricks, sun), extinction, {{&source, 1.0}});
    const double deposited = source.deposited;
    const Solved s = solve(p1, source, 1e-6);
    EXPECT_TRUE(s.solve.converged);
    EXPECT_EQ(s.budget.negative, 0);
    *defect = s.budget.defect;
    return {deposited, lost_power(line_depths(c.index, c.density, sun), extinction)};
}

TEST(Energy, CloudBalancesAndMatchesLinesAtSecondOrder)
{
    for (const Vec3d& to_light : {Vec3d(0, 1, 0), Vec3d(0.3, 1, 0.2)}) {
        double defect[2];
        const auto coarse = cloud_power(24, to_light, &defect[0]), fine = cloud_power(48, to_light, &defect[1]);
        EXPECT_LT(defect[0], 1e-6);
        EXPECT_LT(defect[1], 1e-6);
        const double e[2] = {std::abs(coarse.first / coarse.second - 1), std::abs(fine.first / fine.second - 1)};
        EXPECT_LT(e[1], 2e-3);  // at 2 voxels to the gradient's length faces err by h^2, lines by a third of that
        EXPECT_TRUE(e[1] < e[0] / 3 || e[1] < 1e-6) << e[0] << ' ' << e[1];  // along an axis both are the same sum
    }
}

TEST(PointLight, InsideACloudDepositsItsWholePower)
{
    P1Case c(test::voxel_field(Vec3i(17), Vec3d(0.25), [](const Vec3i&) { return 1.0; }));
    const P1Operator p1(c.index, c.density, c.exposed, {2, 1, nullptr, test::hg(0.5), true});
    const BrickMap bricks(*c.grid);
    const Light lamp = make_lamp(Vec3d(2.03, 1.98, 2.01));
    P1Source source(p1);
    add_beam(p1, beam_depths(c.index, c.exposed, bricks, lamp), 2 * p1.scaling(0).extinction, {{&source, 3.0}});
    EXPECT_NEAR(source.beam_in, 3 * 4 * pi, 1e-9);
    EXPECT_NEAR(source.beam_out / source.beam_in, std::exp(-2 * p1.scaling(0).extinction * 2.1), 0.05);
    const Solved s = solve(p1, source);
    EXPECT_LT(s.budget.defect, 1e-6);
    double out = source.beam_out;
    for (double o : s.budget.out) out += o;
    EXPECT_NEAR(out, 3 * 4 * pi, 1e-4);
}

TEST(ScatterP1, SharesSolutionsBetweenChannelsAndWritesMetadata)
{
    const auto grid =
        test::voxel_field(Vec3i(12), Vec3d(0.2), [](const Vec3i& p) { return bumpy(p, 11) > 0 ? 1.0 : 0.0; });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    medium.albedo = Vec3d(0.99, 0.99, 0.9);
    medium.phase = test::hg(0.85);
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(2, 1, 1));
    ScatterReport report;
    const auto fields = scatter_p1(*grid, nullptr, nullptr, medium, {sun}, {}, {}, report);
    ASSERT_TRUE(fields.phi);
    EXPECT_EQ(report.solves, 2);
    EXPECT_EQ(report.channel[1].solved_as, 0);
    EXPECT_DOUBLE_EQ(report.channel[1].scale, 0.5);
    EXPECT_EQ(report.channel[2].solved_as, 2);
    EXPECT_TRUE(report.converged);
    for (const auto& channel : report.channel) EXPECT_LT(channel.budget.defect, 1e-6);
    EXPECT_NEAR(report.channel[1].deposited * 2, report.channel[0].deposited, 1e-12);
    EXPECT_GT(report.channel[0].reentry, 0);
    EXPECT_LT(report.bytes / report.voxels, 2000u);

    // In a grey medium all channels share one matrix, whatever the colour of the sun.
    Medium grey = medium;
    grey.albedo = Vec3d(0.99);
    const Light blue_sun = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(0, 0, 4));
    ScatterReport blue;
    scatter_p1(*grid, nullptr, nullptr, grey, {blue_sun}, {}, {}, blue);
    EXPECT_NEAR(blue.channel[2].budget.largest, 2 * report.channel[0].budget.largest,
                1e-5 * blue.channel[2].budget.largest);
    EXPECT_EQ(blue.channel[0].budget.largest, 0);
}

TEST(ScatterP1, RaysOfASunServeAllChannelsAndSweeps)
{
    // Each channel has a matrix of its own, and under forward scattering an extinction; density depths are the same.
    const auto grid =
        test::voxel_field(Vec3i(20, 17, 12), Vec3d(0.2), [](const Vec3i& p) { return bumpy(p, 11) > 0 ? 1.0 : 0.0; });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    medium.albedo = Vec3d(0.99, 0.95, 0.9);
    medium.phase = test::hg(0.85);
    const std::vector<Light> suns{make_sun(Vec3d(0.3, 1, 0.2)), make_sun(Vec3d(-1, 0.2, 0.4))};
    ScatterOptions o;
    o.closure.iterations = 2;
    ScatterReport report;
    const auto colours =
        openvdb::gridPtrCast<Vec3SGrid>(scatter_p1(*grid, nullptr, nullptr, medium, suns, o, {}, report).phi);
    EXPECT_EQ(report.solves, 3);
    for (int c = 0; c < 3; ++c) {
        Medium grey = medium;
        grey.albedo = Vec3d(medium.albedo[c]);
        ScatterReport alone;
        const auto phi =
            openvdb::gridPtrCast<FloatGrid>(scatter_p1(*grid, nullptr, nullptr, grey, suns, o, {}, alone).phi);
        for (auto v = phi->cbeginValueOn(); v; ++v)
            ASSERT_EQ(colours->tree().getValue(v.getCoord())[c], *v) << c << ' ' << v.getCoord();
        EXPECT_EQ(report.work.of("lattice_product"), alone.work.of("lattice_product")) << "one pass for each sun";
        EXPECT_EQ(report.channel[size_t(c)].lines, alone.channel[size_t(c)].lines);
    }
}

TEST(ScatterP1, UniformTintMatchesUniformAlbedo)
{
    // A uniform tint equals a uniform albedo, including delta scaling and beam.
    const auto grid = test::voxel_field(Vec3i(16), Vec3d(0.1), [](const Vec3i&) { return 1.0; });
    const auto tint = test::constant_like(*grid, Vec3f(0.9f, 0.9f, 0.9f));
    Medium medium;
    medium.sigma_t_per_density = Vec3d(4);
    medium.phase = test::hg(0.7);
    const Light sun = make_sun(Vec3d(0, 1, 0));
    ScatterReport tinted, plain;
    scatter_p1(*grid, tint.get(), nullptr, medium, {sun}, {}, {}, tinted);
    medium.albedo = Vec3d(double(0.9f));
    scatter_p1(*grid, nullptr, nullptr, medium, {sun}, {}, {}, plain);
    EXPECT_EQ(tinted.solves, 1);
    EXPECT_NEAR(tinted.channel[0].budget.largest / plain.channel[0].budget.largest, 1, 1e-5);
    EXPECT_NEAR(tinted.channel[0].budget.absorbed / plain.channel[0].budget.absorbed, 1, 1e-5);
    EXPECT_GT(plain.channel[0].budget.absorbed, 0.01);
}

TEST(ScatterP1, EmptyDensityGivesNoGrids)
{
    const auto grid = test::voxel_field(Vec3i(4), Vec3d(1), [](const Vec3i&) { return 0.0; });
    ScatterReport report;
    EXPECT_FALSE(scatter_p1(*grid, nullptr, nullptr, {}, {make_sun(Vec3d(0, 1, 0))}, {}, {}, report).phi);
    EXPECT_TRUE(report.converged);
}

}  // namespace
}  // namespace vdbcloud
