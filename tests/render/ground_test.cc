// The ground that the integrators of grids see: its radiance through the media, layers, depth.
#include "render/periodic_scenes.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using namespace test;
using openvdb::Coord;

constexpr double tau = 0.8;

/// Over a layer of 8 voxels of 1/8 whose interpolant ends at y = -1/8: a ground of radiance `value(x, z)`, of which the
/// channels are 1, 2 and 3 times.
template<typename F>
Scene over_ground(const F& value)
{
    Scene scene;
    scene.volumes.push_back(volume_of(periodic_layer(8), medium(Vec3d(tau), Vec3d(0.0), 0)));
    scene.periodic = xz;
    scene.ground = ground_beneath({scene.volumes[0].density.get()}, Vec3d(0, 1, 0), 0.5);
    scene.ground_radiance = Vec3SGrid::create(Vec3f(0.0f));
    scene.ground_radiance->setTransform(scene.volumes[0].density->transform().copy());
    for (int x = 0; x < 8; ++x)
        for (int z = 0; z < 8; ++z)
            scene.ground_radiance->tree().setValueOn(Coord(x, -1, z), Vec3f(1, 2, 3) * float(value(x, z)));
    return scene;
}

TEST(GroundSeen, IsItsRadianceTimesTheTransmittance)
{
    const Scene scene = over_ground([](int, int) { return 0.7; });
    for (const Vec3d& along : {Vec3d(0, -1, 0), Vec3d(0.6, -0.8, 0), Vec3d(-3, -1, 2)}) {
        const Vec3d w = along.unit();
        for (const Integrator kind : integrators) {
            const Picture picture(scene, one_pixel(Vec3d(0.3, 0.5, 0.2), w), fine(kind));
            const double seen = 0.7 * std::exp(tau / w[1]);
            for (int c = 0; c < 3; ++c) {
                // Transmittance of the rules of points: 1e-5.
                EXPECT_NEAR(picture.at("ground", c) / (seen * (c + 1)), 1, 1e-4) << name(kind) << w;
                EXPECT_EQ(picture.at("", c), picture.at("ground", c));
                EXPECT_EQ(picture.at("background", c), 0);
                EXPECT_NEAR(picture.at("transmittance", c), std::exp(tau / w[1]), 1e-5);
            }
            EXPECT_EQ(picture.at("", 3), 1);
            // The camera is 100 before the target at y = 0.5. Thin layers show the ground at -1/8.
            if (w[1] == -1) {
                EXPECT_LT(picture.at("Z", 0), 100.5);
            }
        }
    }
}

TEST(GroundSeen, IsAtItsDepthUnderThinAir)
{
    Scene scene = over_ground([](int, int) { return 0.7; });
    scene.volumes[0].medium.sigma_t_per_density = Vec3d(0.1);
    const Picture picture(scene, one_pixel(Vec3d(0.3, 0.5, 0.2), Vec3d(0, -1, 0)), {});
    EXPECT_NEAR(picture.at("Z", 0), 100 + 0.5 + 0.125, 1e-4);
}

TEST(GroundSeen, IsInterpolatedAlongTheGroundAndRepeats)
{
    const Scene scene = over_ground([](int x, int z) { return x == 3 ? 1.0 + z : 0.0; });
    // A ray down through x, z [voxels].
    const auto seen = [&](double x, double z) {
        return Picture(scene, one_pixel(Vec3d(x / 8, 0.5, z / 8), Vec3d(0, -1, 0)), {}).at("ground", 0) * std::exp(tau);
    };
    EXPECT_NEAR(seen(3, 2), 3, 1e-5);
    EXPECT_NEAR(seen(3.25, 2), 0.75 * 3, 1e-5);
    EXPECT_NEAR(seen(2.5, 2.5), 0.5 * 3.5, 1e-5);
    EXPECT_NEAR(seen(5, 2), 0, 1e-5);
    EXPECT_NEAR(seen(3 + 16, 2 - 8), 3, 1e-5);
    EXPECT_NEAR(seen(3, 7.5), 0.5 * 8 + 0.5 * 1, 1e-5) << "across the seam";
}

TEST(GroundSeen, HasItsBackgroundBeyondItsGrid)
{
    // A patch by voxels of twice the edge, whose first middle is that of voxel 2, 3.
    Scene scene = over_ground([](int, int) { return 0.0; });
    scene.periodic = {false, false, false};
    scene.volumes[0].medium.sigma_t_per_density = Vec3d(0.0);
    scene.ground_radiance = Vec3SGrid::create(Vec3f(0.25f));
    auto transform = scene.volumes[0].density->transform().copy();
    transform->preTranslate(openvdb::Vec3d(2, -1, 3));
    transform->preScale(openvdb::Vec3d(2, 1, 2));
    scene.ground_radiance->setTransform(transform);
    for (int x = 0; x < 2; ++x)
        for (int z = 0; z < 2; ++z) scene.ground_radiance->tree().setValueOn(Coord(x, 0, z), Vec3f(1.25f + float(x)));
    const auto seen = [&](double x, double z) {
        return Picture(scene, one_pixel(Vec3d(x / 8, 0.5, z / 8), Vec3d(0, -1, 0)), {}).at("ground", 0);
    };
    EXPECT_NEAR(seen(2, 3), 1.25, 1e-5);
    EXPECT_NEAR(seen(4, 5), 2.25, 1e-5);
    EXPECT_NEAR(seen(3, 4), 1.75, 1e-5);
    EXPECT_NEAR(seen(2, 2), 0.75, 1e-5) << "half way to the background";
    EXPECT_NEAR(seen(50, -30), 0.25, 1e-5);
    EXPECT_NEAR(seen(2, 8), 0.25, 1e-5);
}

TEST(GroundSeen, OfARayThatGoesUpIsTheSky)
{
    Scene scene = over_ground([](int, int) { return 0.7; });
    scene.background = Sky::constant(Vec3d(2.0));
    const Picture picture(scene, one_pixel(Vec3d(0.3, 101, 0.2), Vec3d(0.1, 1, 0)), {});
    EXPECT_EQ(picture.at("ground", 0), 0);
    EXPECT_EQ(picture.at("background", 0), 2);
    EXPECT_EQ(picture.at("", 3), 0);
}

TEST(GroundSeen, NeedsItsRadianceAndLightsAbove)
{
    Scene scene = over_ground([](int, int) { return 0.7; });
    const CameraView view = one_pixel(Vec3d(0.3, 0.5, 0.2), Vec3d(0, -1, 0));
    scene.lights = {make_sun(Vec3d(0, -1, 0))};
    add_light(scene);
    EXPECT_THROW(Picture(scene, view, {}), InputError);
    scene.lights.clear();
    scene.volumes[0].transmittance.clear();
    scene.ground_radiance = nullptr;
    EXPECT_THROW(Picture(scene, view, {}), InputError);
}

}  // namespace
}  // namespace vdbcloud
