// Channels that share what they can: each has the light of a solve of its own, and nothing is built twice.
#include "scatter/sweep_cases.h"

#include "support/voxel_field.h"
#include "vdbcloud/scatter/multiple_scattering.h"
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scatter/streaming.h"

#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

constexpr int edge = 24;

FloatGridPtr billowing()
{
    return test::voxel_field(Vec3i(edge), Vec3d(1.0 / edge), [](const Vec3i& p) { return test::billows(p, edge); });
}

Medium coloured(double g)
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(40);
    medium.albedo = Vec3d(0.999, 0.99, 0.95);
    medium.phase = test::hg(g);
    return medium;
}

ScatterOptions sweeps(int iterations, int degree)
{
    ScatterOptions o;
    o.closure = test::options(32, iterations, degree, 1e-12);
    o.reentry_rays = o.line_rays = 0;
    return o;
}

const Light& sun()
{
    static const Light light = make_sun(Vec3d(0.3, 1, 0.2));
    return light;
}

/// Largest difference of a component of phi of three channels to that of a grey medium, over the largest phi.
double difference(const CollidedLight& three, int channel, const CollidedLight& grey)
{
    const auto of = fluence(three), one = fluence(grey);
    auto at = one->getConstAccessor();
    double worst = 0, largest = 0;
    for (auto v = of->cbeginValueOn(); v; ++v) {
        worst = std::max(worst, double(std::abs((*v)[channel] - at.getValue(v.getCoord())[0])));
        largest = std::max(largest, double(std::abs((*v)[channel])));
    }
    return worst / largest;
}

TEST(Channels, EachHasTheLightOfAGreyMediumOfItsAlbedo)
{
    // The same arithmetic in single precision, and solves to 1e-9, so equal to a few of its roundings.
    const auto grid = billowing();
    for (const double g : {0.0, 0.6})
        for (const int iterations : {0, 3}) {
            const Medium medium = coloured(g);
            ScatterReport report, of_one;
            ScatterOptions o = sweeps(iterations, g == 0 ? 1 : 3);
            o.solve.tolerance = 1e-9;
            o.closure.solve_share = 0;
            const CollidedLight three = scatter_p1(*grid, nullptr, nullptr, medium, {sun()}, o, {}, report);
            for (int c = 0; c < 3; ++c) {
                Medium grey = medium;
                grey.albedo = Vec3d(medium.albedo[c]);
                const CollidedLight one = scatter_p1(*grid, nullptr, nullptr, grey, {sun()}, o, {}, of_one);
                EXPECT_LT(difference(three, c, one), 1e-6) << g << ' ' << iterations << ' ' << c;
                EXPECT_NEAR(report.channel[c].budget.absorbed / of_one.channel[0].budget.absorbed, 1, 1e-6);
            }
        }
}

TEST(Channels, BuildOneMatrixEachAndFindDepthsOnce)
{
    const auto grid = billowing();
    for (const double g : {0.0, 0.6}) {
        ScatterReport three, one;
        Medium medium = coloured(g);
        scatter_p1(*grid, nullptr, nullptr, medium, {sun()}, sweeps(2, 1), {}, three);
        medium.albedo = Vec3d(0.99);
        scatter_p1(*grid, nullptr, nullptr, medium, {sun()}, sweeps(2, 1), {}, one);
        const double voxels = 512.0 * double(one.blocks);
        EXPECT_EQ(one.work.of("p1_setup_voxel"), voxels);  // sweeps close the matrix of P1
        EXPECT_EQ(three.work.of("p1_setup_voxel"), 3 * voxels);
        EXPECT_EQ(one.work.of("beam_voxel"), 2 * voxels);  // found, and added
        // With g = 0 beams of one channel are those of another times a number.
        EXPECT_EQ(three.work.of("beam_voxel"), (g == 0 ? 2 : 4) * voxels);
        EXPECT_EQ(three.work.of("lattice_product"), one.work.of("lattice_product"));
        // With g = 0 channels share sigma_tr and with it the bound of its diffusion.
        // Channels of one extinction are swept together; with g = 0.6 extinction depends on the albedo.
        const double followers = g == 0 ? 2 * 64 : 0;
        EXPECT_EQ(three.work.of("sweep_channel_voxel"), followers * voxels);
        EXPECT_EQ(three.work.of("sweep_voxel"),
                  (3 * 64 - followers + (g == 0 ? 1 : 3) * streaming_directions) * voxels);
    }
}

TEST(Channels, StartFromThoseBeforeWithinTheTolerance)
{
    // Solves to 1e-3 of the last change move light by less than a hundredth of the change. Those that start from
    // another channel's light take fewer iterations, and two such solves differ by less than twice that, at the worst
    // voxel thrice.
    const auto grid = billowing();
    ScatterReport three, one;
    Medium medium = coloured(0);
    const CollidedLight colours = scatter_p1(*grid, nullptr, nullptr, medium, {sun()}, sweeps(3, 1), {}, three);
    for (int c = 1; c < 3; ++c) {
        Medium grey = medium;
        grey.albedo = Vec3d(medium.albedo[c]);
        const CollidedLight own = scatter_p1(*grid, nullptr, nullptr, grey, {sun()}, sweeps(3, 1), {}, one);
        const ClosureReport& closure = three.channel[size_t(c)].closure;
        EXPECT_LT(difference(colours, c, own), 0.03 * closure.change.back()) << c;
        EXPECT_GT(difference(colours, c, own), 0) << c;
        const auto iterations = [](const ClosureReport& of) {
            int sum = 0;
            for (const SolveResult& solve : of.solves) sum += solve.iterations;
            return sum;
        };
        EXPECT_LT(iterations(closure), 0.85 * iterations(one.channel[0].closure)) << c;
    }
}

TEST(Channels, OfEqualSigmaTrShareLinksAndAbsorbByThemselves)
{
    const auto grid = billowing();
    const VoxelIndex index(*grid);
    const auto density = index.gather(*grid);
    const auto exposed = exposed_voxels(index, density);
    const P1Medium white{40, 1, nullptr, test::hg(0), true}, grey{40, 0.9, nullptr, test::hg(0), true};
    const P1Operator first(index, density, exposed, white), alone(index, density, exposed, grey), early(first, grey);
    EXPECT_EQ(early.stencil().extra, alone.stencil().extra);  // built before that of `first`
    EXPECT_NE(&early.stencil().face, &first.stencil().face);
    const P1Operator second(first, grey), scaled(second, 3);
    EXPECT_EQ(&second.stencil().face, &first.stencil().face);
    EXPECT_EQ(second.stencil().face, alone.stencil().face);
    EXPECT_EQ(second.stencil().extra, alone.stencil().extra);
    EXPECT_EQ(&scaled.stencil(), &second.stencil());
    EXPECT_EQ(4 * second.bytes(), first.bytes());
}

TEST(Channels, DoNotDependOnThreads)
{
    const auto grid = billowing();
    ScatterReport report;
    const CollidedLight many = scatter_p1(*grid, nullptr, nullptr, coloured(0), {sun()}, sweeps(2, 1), {}, report);
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, 1);
    const CollidedLight one = scatter_p1(*grid, nullptr, nullptr, coloured(0), {sun()}, sweeps(2, 1), {}, report);
    const auto of = fluence(many), again = fluence(one);
    auto at = again->getConstAccessor();
    for (auto v = of->cbeginValueOn(); v; ++v) ASSERT_EQ(*v, at.getValue(v.getCoord()));
}

}  // namespace
}  // namespace vdbcloud
