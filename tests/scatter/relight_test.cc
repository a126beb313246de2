// Relighting from a series against the solve at the albedo asked for: phi, and the flux with all of its factors.
#include "vdbcloud/scatter/series_grids.h"

#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr int edge = 20;

/// || a - b || / || b || over all voxels.
double difference(const Vec3SGrid& a, const Vec3SGrid& b)
{
    double sum = 0, size = 0;
    for (auto v = b.cbeginValueOn(); v; ++v) {
        sum += double((a.tree().getValue(v.getCoord()) - *v).lengthSqr());
        size += double((*v).lengthSqr());
    }
    return std::sqrt(sum / size);
}

class Relight : public testing::TestWithParam<PhaseFunction> {};

TEST_P(Relight, PhiAndFluxMatchTheDirectSolve)
{
    // Thin towards one corner, where the beam's part of the flux is the larger.
    const auto grid = test::voxel_field(Vec3i(edge), Vec3d(0.05), [](const Vec3i& p) {
        return std::max(0.0, 1.1 - Vec3d(p.x(), p.y(), p.z()).length() / edge);
    });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(6);
    medium.phase = GetParam();
    const std::vector<Light> lights{make_sun(Vec3d(0.3, 1, 0.2), Vec3d(2)), make_lamp(Vec3d(0.2, 0.31, 1.5), Vec3d(3))};
    ScatterOptions options;
    options.sky = Sky::constant(Vec3d(0.1));
    options.reentry_rays = options.line_rays = 0;
    options.solve.tolerance = 1e-8;
    SeriesOptions how;
    how.galerkin = true;
    how.least_albedo = 0.7;
    SeriesReport made;
    GridFile file;
    file.grids = series_p1(*grid, nullptr, medium, lights, options, how, false, made);
    for (double albedo : {0.98, 0.8}) {
        medium.albedo = Vec3d(albedo);
        ScatterReport report;
        const CollidedLight direct = scatter_p1(*grid, nullptr, nullptr, medium, lights, options, {}, report);
        ScatterReport told;
        const CollidedLight relit = relight(file, *grid, nullptr, medium, lights, {}, told);
        EXPECT_EQ(relit.scaling.delta_f, direct.scaling.delta_f);
        EXPECT_EQ(relit.scaling.moments, direct.scaling.moments);
        EXPECT_EQ(relit.flux_limit, direct.flux_limit);
        // A Galerkin sum of 9 orders; the error estimate is in the energy norm, in which constants count little.
        const double error = difference(*fluence(relit), *fluence(direct));
        EXPECT_LT(error, 1e-3) << albedo;
        EXPECT_GT(told.channel[0].solve.error, 0.2 * error) << albedo;
        EXPECT_LT(told.channel[0].solve.error, 5 * error + 1e-6) << albedo;
        if (direct.scaling.mean_cosine() == 0) continue;
        EXPECT_LT(difference(*flux_of(relit, 0), *flux_of(direct, 0)), 1e-3) << albedo;
    }
}

INSTANTIATE_TEST_SUITE_P(Phases, Relight,
                         testing::Values(test::hg(0.6), PhaseFunction("rayleigh"),
                                         PhaseFunction("double-henyey-greenstein", {0.8, -0.3, 0.6})),
                         [](const auto& test) { return "Phase" + std::to_string(test.index); });

}  // namespace
}  // namespace vdbcloud
