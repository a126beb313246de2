// Grids of collided light: channels that share one solution, and the delta scaling in the metadata.
#include "vdbcloud/scatter/multiple_scattering.h"

#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

FloatGridPtr ball()
{
    return test::voxel_field(Vec3i(12), Vec3d(0.2), [](const Vec3i& p) {
        const Vec3d x = (Vec3d(p.x(), p.y(), p.z()) - Vec3d(5.5)) / 6;
        return std::max(0.0, 1 - x.dot(x));
    });
}

CollidedLight solved(const FloatGrid& grid, const PhaseFunction& phase, const Vec3d& irradiance, int iterations,
                     int degree, bool delta = true)
{
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    medium.albedo = Vec3d(0.95);
    medium.phase = phase;
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2), irradiance);
    ScatterOptions options;
    options.delta = delta;
    options.closure.iterations = iterations;
    options.closure.degree = degree;
    options.closure.directions = 64;
    options.closure.change = 1e-7;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    return scatter_p1(grid, nullptr, nullptr, medium, {sun}, options, {}, report);
}

TEST(CollidedGrids, SharedSolutionsScaleWithTheIrradiance)
{
    const auto grid = ball();
    const Vec3d irradiance(2, 1, 0.5);
    const CollidedLight shared = solved(*grid, test::hg(0.6), irradiance, 4, 3);
    ASSERT_EQ(shared.moments[0].size(), 12u);
    ASSERT_TRUE(shared.phi->isType<FloatGrid>());
    EXPECT_EQ(shared.flux[1], shared.flux[0]);
    EXPECT_EQ(shared.moments[2], shared.moments[0]);
    for (int c = 0; c < 3; ++c) {
        const CollidedLight one = solved(*grid, test::hg(0.6), Vec3d(irradiance[c]), 4, 3);
        EXPECT_EQ(one.channel_scale, Vec3d(1));
        const auto phi_of_all = fluence(shared), flux_of_channel = flux_of(shared, c);
        double phi = 0, flux = 0, moment = 0, moment_error = 0;
        for (auto v = openvdb::gridPtrCast<FloatGrid>(one.phi)->cbeginValueOn(); v; ++v) {
            const auto at = v.getCoord();
            phi = std::max(phi, std::abs(double(phi_of_all->tree().getValue(at)[c]) / double(*v) - 1));
            const Vec3d f(one.flux[0]->tree().getValue(at));
            flux = std::max(flux, (Vec3d(flux_of_channel->tree().getValue(at)) - f).length() / f.length());
            for (size_t k = 0; k < 12; ++k) {
                const double m = double(one.moments[0][k]->tree().getValue(at));
                moment = std::max(moment, std::abs(m));
                moment_error = std::max(
                    moment_error,
                    std::abs(shared.channel_scale[c] * double(shared.moments[size_t(c)][k]->tree().getValue(at)) - m));
            }
        }
        EXPECT_LT(phi, 1e-4) << c;
        EXPECT_LT(flux, 1e-3) << c;
        EXPECT_LT(moment_error, 1e-4 * moment) << c;
        EXPECT_GT(moment, 0);
    }
}

TEST(CollidedGrids, MetadataHoldsTheDeltaScalingOfPhaseAndDegree)
{
    const auto grid = ball();
    for (const PhaseFunction& phase : {test::hg(0.8), PhaseFunction("rayleigh"), PhaseFunction("hg-draine", {10})})
        for (const auto& [iterations, degree] : {std::pair(0, 1), {1, 3}})
            for (bool delta : {true, false}) {
                const CollidedLight fields = solved(*grid, phase, Vec3d(1), iterations, degree, delta);
                const DeltaScaling made = delta ? delta_scaling(phase, degree) : no_scaling(phase, degree);
                for (const GridBase* of : {static_cast<const GridBase*>(fields.phi.get()),
                                           static_cast<const GridBase*>(fields.flux[1].get())}) {
                    if (!of) continue;
                    const DeltaScaling read = read_delta_scaling(*of, PhaseFunction());
                    EXPECT_EQ(read.degree, degree);
                    EXPECT_EQ(read.delta_f, made.delta_f);
                    EXPECT_EQ(read.moments, made.moments);
                    EXPECT_EQ(read_medium(*of).phase, phase);
                }
                EXPECT_EQ(fields.scaling.moments, made.moments);
            }
}

TEST(CollidedGrids, AreThoseThatPicturesWeigh)
{
    const auto grid = ball();
    const CollidedLight isotropic = solved(*grid, test::hg(0), Vec3d(1), 1, 3),
                        rayleigh = solved(*grid, PhaseFunction("rayleigh"), Vec3d(1), 1, 3),
                        forward = solved(*grid, test::hg(0.6), Vec3d(1), 1, 3);
    for (size_t c = 0; c < 3; ++c) {
        EXPECT_FALSE(isotropic.flux[c]);
        EXPECT_TRUE(isotropic.moments[c].empty());
        EXPECT_FALSE(rayleigh.flux[c]);  // its moments are those of degree 0 and 2
        EXPECT_EQ(rayleigh.moments[c].size(), 5u);
        EXPECT_TRUE(forward.flux[c]);
        EXPECT_EQ(forward.moments[c].size(), 12u);
    }
    EXPECT_TRUE(isotropic.phi);
}

/// The root mean square of phi and flux of two suns less those of each, relative to the flux. `both` is their report.
double off_from_sum(const ScatterOptions& options, ScatterReport& both)
{
    const auto grid = ball();
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    medium.phase = test::hg(0.85);
    const Light low = make_sun(Vec3d(1, 0.2, 0)), high = make_sun(Vec3d(-0.3, 1, 0.2), Vec3d(2, 1, 0.5));
    const auto of = [&](const std::vector<Light>& lights, ScatterReport& report) {
        return scatter_p1(*grid, nullptr, nullptr, medium, lights, options, {}, report);
    };
    ScatterReport alone;
    const CollidedLight sum = of({low, high}, both), a = of({low}, alone), b = of({high}, alone);
    EXPECT_FALSE(sum.phi->isType<FloatGrid>()) << "the two suns differ in colour";
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
        const auto flux = flux_of(sum, c), flux_a = flux_of(a, c), flux_b = flux_of(b, c);
        const auto phi = fluence(sum), phi_a = fluence(a), phi_b = fluence(b);
        double error = 0, size = 0;
        for (auto v = flux->cbeginValueOn(); v; ++v) {
            const auto at = v.getCoord();
            error += (Vec3d(*v) - Vec3d(flux_a->tree().getValue(at)) - Vec3d(flux_b->tree().getValue(at))).lengthSqr();
            error += std::pow(double(phi->tree().getValue(at)[c]) - double(phi_a->tree().getValue(at)[c]) -
                                  double(phi_b->tree().getValue(at)[c]),
                              2);
            size += Vec3d(*v).lengthSqr();
        }
        worst = std::max(worst, std::sqrt(error / size));
    }
    return worst;
}

/// The light of several lights is the sum of the lights of each, also where P1's flux is longer than phi / 3: to the
/// tolerance of the solver, of each of three solves.
TEST(CollidedGrids, P1OfTwoSunsIsTheSumOfBoth)
{
    ScatterOptions options;
    options.solve.tolerance = 1e-7;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    EXPECT_LT(off_from_sum(options, report), 10 * options.solve.tolerance);
    EXPECT_GT(report.channel[0].flux_limited, 100) << "there are long fluxes";
}

/// At the fixed point of the sweeps too: to the change at which the three iterations end.
TEST(CollidedGrids, SweepsOfTwoSunsAreTheSumOfBoth)
{
    for (const auto& [degree, directions] : {std::pair(1, 32), {3, 64}}) {
        ScatterOptions options;
        options.reentry_rays = options.line_rays = 0;
        options.closure.iterations = 40;
        options.closure.degree = degree;
        options.closure.directions = directions;
        options.closure.change = 1e-5;
        ScatterReport report;
        EXPECT_LT(off_from_sum(options, report), 10 * options.closure.change) << degree;
        EXPECT_TRUE(report.channel[0].closure.converged) << degree;
    }
}

}  // namespace
}  // namespace vdbcloud
