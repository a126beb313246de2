// Relighting from a series against the solve at the albedo asked for: phi, and the flux with all of its factors.
#include "vdbcloud/scatter/series_grids.h"

#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

constexpr int edge = 20, rim = 4;

/// || a - b || / || b || over the voxels at least `rim` voxels inside: at the surface the beam's part of the flux is
/// taken at voxel centres by relight() and as a mean of two faces by the solve.
double difference(const Vec3SGrid& a, const Vec3SGrid& b)
{
    double sum = 0, size = 0;
    for (auto v = b.cbeginValueOn(); v; ++v) {
        const auto at = v.getCoord();
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) inside = inside && at[axis] >= rim && at[axis] < edge - rim;
        if (!inside) continue;
        sum += double((a.tree().getValue(at) - *v).lengthSqr());
        size += double((*v).lengthSqr());
    }
    return std::sqrt(sum / size);
}

class Relight : public testing::TestWithParam<PhaseFunction> {};

TEST_P(Relight, PhiAndFluxMatchTheDirectSolve)
{
    const auto grid = test::voxel_field(Vec3i(edge), Vec3d(0.05), [](const Vec3i&) { return 1.0; });
    Medium medium;
    medium.sigma_t_per_density = Vec3d(6);
    medium.phase = GetParam();
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(2));
    ScatterOptions options;
    options.reentry_rays = options.line_rays = 0;
    options.solve.tolerance = 1e-8;
    SeriesOptions how;
    how.galerkin = true;
    how.least_albedo = 0.7;
    SeriesReport made;
    GridFile file;
    file.grids = series_p1(*grid, nullptr, medium, {sun}, options, how, false, made);
    for (double albedo : {0.98, 0.8}) {
        medium.albedo = Vec3d(albedo);
        ScatterReport report;
        const CollidedLight direct = scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
        Medium scaled = medium;
        scaled.sigma_t_per_density *= direct.scaling.extinction(albedo);
        const CollidedLight relit = relight(file, medium, {sun}, {transmittance_grid(*grid, scaled, sun, {})});
        EXPECT_EQ(relit.scaling.delta_f, direct.scaling.delta_f);
        EXPECT_EQ(relit.scaling.moments, direct.scaling.moments);
        EXPECT_LT(difference(*fluence(relit), *fluence(direct)), 0.001) << albedo;
        // 0.3 mean free paths a voxel.
        if (direct.scaling.mean_cosine() == 0) continue;
        EXPECT_LT(difference(*relit.flux[0], *direct.flux[0]), 0.01) << albedo;
    }
}

INSTANTIATE_TEST_SUITE_P(Phases, Relight,
                         testing::Values(test::hg(0.6), PhaseFunction("rayleigh"),
                                         PhaseFunction("double-henyey-greenstein", {0.8, -0.3, 0.6})),
                         [](const auto& test) { return "Phase" + std::to_string(test.index); });

}  // namespace
}  // namespace vdbcloud
