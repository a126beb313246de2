// A sun with a disc in the picture: the phase function's mean over the disc, and its penumbra by grids and by rays.
#include "pictures.h"
#include "vdbcloud/light/transmittance_grid.h"

#include <cmath>

namespace vdbcloud {
namespace {

using test::cube;
using test::fine;
using test::integrators;
using test::medium;
using test::one_pixel;
using test::Picture;
using test::volume_of;

/// The mean of Henyey-Greenstein's function over a cap about the forward direction, in closed form.
double mean_over_cap(double g, double half_angle)
{
    const double c = std::cos(half_angle);
    const double within = (1 - g * g) / (2 * g) * (1 / (1 - g) - 1 / std::sqrt(1 + g * g - 2 * g * c));
    return within / (2 * M_PI * (1 - c));
}

/// Looking into the sun through a thin medium: L = E <p> sigma_t length. The disc's points lie in the middles of rings
/// of equal solid angle, so the sum is a midpoint rule in the cosine: with 16 points it errs by 2e-3 here. Optical
/// depth 1.6e-4: the attenuation that the closed form leaves out.
TEST(SunDisc, ScattersByTheMeanOfThePhaseFunctionOverTheDisc)
{
    constexpr double g = 0.6, diameter = 40, half = diameter / 2 * M_PI / 180;
    Scene scene;
    scene.volumes.push_back(volume_of(cube(), medium(Vec3d(1e-5), Vec3d(1), g)));
    scene.lights.push_back(make_sun(Vec3d(0, 0, 1), Vec3d(1.0), diameter));
    const double expected = mean_over_cap(g, half) * 16e-5;
    for (const Integrator kind : integrators) {
        IntegratorOptions options = fine(kind);
        options.shadow_rays = true;
        const Picture picture(scene, one_pixel(Vec3d(7.6, 7.3, 7.9), Vec3d(0, 0, 1)), options);
        EXPECT_NEAR(picture.at("direct_sun", 0) / expected, 1, 3e-3) << name(kind);
    }
    EXPECT_GT(medium(Vec3d(1), Vec3d(1), g).phase(1.0) / mean_over_cap(g, half), 1.1) << "the centre alone is wrong";
}

/// In the penumbra of a dense roof rays to the disc see what the light grid holds, which is interpolated between
/// voxels: 3 % of the radiance without the roof, which changes by a fifth of it from voxel to voxel.
TEST(SunDisc, ShadowRaysSeeThePenumbraOfTheLightGrid)
{
    // A body of two parts: a dense roof over the half x < 8, and a thin floor below it.
    const auto body = test::box({16, 24, 16}, 1, [](openvdb::Coord p) {
        return p.y() < 4 ? 0.05 : p.y() >= 20 && p.x() < 8 ? 2.0 : 0.0;
    });
    Scene scene;
    scene.volumes.push_back(volume_of(body, medium(Vec3d(1), Vec3d(1), 0)));
    scene.lights.push_back(make_sun(Vec3d(0, 1, 0), Vec3d(1.0), 40));
    scene.volumes[0].transmittance.push_back(transmittance_grid(*body, scene.volumes[0].medium, scene.lights[0], {}));
    double before = 0;
    Scene open = scene;  // the floor alone
    open.volumes[0].density = test::box({16, 4, 16}, 1, [](openvdb::Coord) { return 0.05; });
    IntegratorOptions rays = fine(Integrator::Cells);
    rays.shadow_rays = true;
    const double unshaded = Picture(open, one_pixel(Vec3d(8, 1.5, 8), Vec3d(0, 0, 1)), rays).at("direct_sun", 0);
    for (const double x : {2.5, 6.5, 8.0, 9.5, 13.5}) {
        const CameraView view = one_pixel(Vec3d(x, 1.5, 8), Vec3d(0, 0, 1));
        const Picture grid(scene, view, fine(Integrator::Cells));
        const Picture exact(scene, view, rays);
        const double found = grid.at("direct_sun", 0), expected = exact.at("direct_sun", 0);
        EXPECT_NEAR(found, expected, 0.03 * unshaded) << x;
        EXPECT_GT(expected, before) << "light grows across the penumbra";
        before = expected;
    }
    EXPECT_GT(before, 0.5 * unshaded);
}

}  // namespace
}  // namespace vdbcloud
