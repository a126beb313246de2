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

ScatterFields solved(const FloatGrid& grid, const PhaseFunction& phase, const Vec3d& irradiance, int iterations,
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
    const ScatterFields shared = solved(*grid, test::hg(0.6), irradiance, 4, 3);
    ASSERT_EQ(shared.moments[0].size(), 12u);
    for (int c = 0; c < 3; ++c) {
        const ScatterFields one = solved(*grid, test::hg(0.6), Vec3d(irradiance[c]), 4, 3);
        double phi = 0, flux = 0, moment = 0, moment_error = 0;
        for (auto v = one.phi->cbeginValueOn(); v; ++v) {
            const auto at = v.getCoord();
            phi = std::max(phi, std::abs(double(shared.phi->tree().getValue(at)[c]) / double((*v)[0]) - 1));
            const Vec3d f(one.flux[0]->tree().getValue(at));
            flux = std::max(flux, (Vec3d(shared.flux[size_t(c)]->tree().getValue(at)) - f).length() / f.length());
            for (size_t k = 0; k < 12; ++k) {
                const double m = one.moment_scale[0] * double(one.moments[0][k]->tree().getValue(at));
                moment = std::max(moment, std::abs(m));
                moment_error = std::max(
                    moment_error,
                    std::abs(shared.moment_scale[c] * double(shared.moments[size_t(c)][k]->tree().getValue(at)) - m));
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
                const ScatterFields fields = solved(*grid, phase, Vec3d(1), iterations, degree, delta);
                const DeltaScaling made = delta ? delta_scaling(phase, degree) : no_scaling(phase, degree);
                for (const GridBase* of : {static_cast<const GridBase*>(fields.phi.get()),
                                           static_cast<const GridBase*>(fields.flux[1].get())}) {
                    const DeltaScaling read = read_delta_scaling(*of, PhaseFunction());
                    EXPECT_EQ(read.degree, degree);
                    EXPECT_EQ(read.delta_f, made.delta_f);
                    EXPECT_EQ(read.moments, made.moments);
                    EXPECT_EQ(read_medium(*of).phase, phase);
                }
                EXPECT_EQ(fields.scaling.moments, made.moments);
            }
}

}  // namespace
}  // namespace vdbcloud
