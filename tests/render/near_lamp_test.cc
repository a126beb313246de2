// Single scattering of a lamp within the medium, on rays that pass it closely.
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/render/media.h"

#include "support/fields.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

constexpr int n = 24;

/// Light of a lamp at `lamp` scattered once towards the eye, in a medium of extinction sigma_t that a ray enters at its
/// origin and leaves after `length`: the integral over the angle at the lamp, in which irradiance is constant.
double scattered_once(const WorldRay& ray, double length, const Vec3d& lamp, double sigma_t, const PhaseFunction& phase)
{
    const double s = (lamp - ray.origin).dot(ray.direction), b = (ray.at(s) - lamp).length();
    const double first = std::atan(-s / b), last = std::atan((length - s) / b);
    const int steps = 20000;
    double sum = 0;
    for (int k = 0; k < steps; ++k) {
        const double angle = first + (last - first) * (k + 0.5) / steps, t = s + b * std::tan(angle);
        const double r = b / std::cos(angle);
        // From the lamp the light travels along (ray.at(t) - lamp) / r, and on to the eye against the ray.
        sum += phase(-std::sin(angle)) * std::exp(-sigma_t * (r + t));
    }
    return sigma_t / b * sum * (last - first) / steps;
}

class NearLamp : public testing::TestWithParam<double> {};

/// Voxels of 0.5 and 2 mean free paths, rays that pass the lamp at a twentieth to three voxels; at a node of the grid,
/// on a face and between. Steps of half their distance from the lamp, extrapolated to fourth order, err by some 1e-4.
TEST_P(NearLamp, ScattersOnceAsTheIntegralSays)
{
    const double sigma_t = GetParam(), h = 1;
    const auto density = test::box(Vec3i(n, n, n), h, [](const openvdb::Coord&) { return 1.0; });
    for (const double g : {0.0, 0.6})
        for (const Vec3d& lamp : {Vec3d(12, 12, 12), Vec3d(11.5, 12, 12.5), Vec3d(12.31, 11.87, 12.05)}) {
            Scene scene;
            scene.volumes.resize(1);
            Volume& volume = scene.volumes[0];
            volume.density = density;
            volume.medium.sigma_t_per_density = Vec3d(sigma_t);
            volume.medium.phase = PhaseFunction::henyey_greenstein(g);
            scene.lights = {make_lamp(lamp)};
            volume.transmittance = {transmittance_grid(*density, volume.medium, scene.lights[0], {})};
            const PreparedScene prepared(scene, {});
            const auto integrate = make_cells_integrator(prepared, {});
            for (const double b : {0.05, 0.3, 1.0, 3.0}) {
                // From within the medium, so that its faces, where density ramps to 0, do not count.
                const Vec3d direction = Vec3d(0.6, 0.64, -0.48), across = Vec3d(0.8, -0.48, 0.36);
                const WorldRay ray{lamp + b * across - 7.0 * direction, direction};
                RayResult result;
                (*integrate)(ray, result);
                const double whole = scattered_once(ray, 1e3, lamp, sigma_t, volume.medium.phase);
                // Beyond 14 the integrand is below exp(-sigma_t 14) of that at the lamp.
                EXPECT_NEAR(result.direct[0][0] / whole, 1, 0.001)
                    << "g " << g << ", lamp " << lamp << ", passed at " << b;
            }
        }
}

INSTANTIATE_TEST_SUITE_P(Extinctions, NearLamp, testing::Values(0.5, 2.0),
                         [](const auto& of) { return of.param < 1 ? "Half" : "Two"; });

}  // namespace
}  // namespace vdbcloud::test
