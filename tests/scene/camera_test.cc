// Cameras: rays through known points, and matrices that agree with the rays and with OpenEXR's conventions.
#include "vdbcloud/scene/camera.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

Vec3d homogeneous(const Vec3d& p, const Matrix44& m)
{
    double out[4];
    for (size_t c = 0; c < 4; ++c) out[c] = p[0] * m[c] + p[1] * m[4 + c] + p[2] * m[8 + c] + m[12 + c];
    return Vec3d(out[0], out[1], out[2]) / out[3];
}

void expect_near(const Vec3d& a, const Vec3d& b, double tolerance)
{
    EXPECT_LT((a - b).length(), tolerance) << a << " against " << b;
}

Camera ahead()  // from +Z to the origin, +Y up, 90 degrees across
{
    Camera camera;
    camera.position = Vec3d(0, 0, 4);
    camera.fov = 90;
    return camera;
}

TEST(Camera, RaysOfKnownPixelsMeetKnownPoints)
{
    const CameraView view(ahead(), {200, 100, 1, {}});
    const auto hit = [&](double x, double y) {  // where the ray meets the plane z = 0
        const WorldRay ray = view.ray(x, y);
        EXPECT_NEAR(ray.direction.length(), 1, 1e-15);
        return Vec3d(ray.origin - ray.direction * (ray.origin[2] / ray.direction[2]));
    };
    expect_near(hit(100, 50), Vec3d(0, 0, 0), 1e-14);
    expect_near(hit(200, 50), Vec3d(4, 0, 0), 1e-12);  // x of the picture is to the right
    expect_near(hit(100, 0), Vec3d(0, 2, 0), 1e-12);   // its y is down, and half as high as wide
    expect_near(hit(0, 100), Vec3d(-4, -2, 0), 1e-12);
}

TEST(Camera, OrthographicRaysAreParallelAndSpanItsWidth)
{
    Camera camera = ahead();
    camera.projection = Projection::Orthographic;
    camera.width = 3;
    const CameraView view(camera, {300, 100, 1, {}});
    for (const double x : {0.0, 17.5, 300.0}) expect_near(view.ray(x, 3).direction, Vec3d(0, 0, -1), 1e-15);
    expect_near(view.ray(0, 0).origin, Vec3d(-1.5, 0.5, 4), 1e-14);
    expect_near(view.ray(300, 100).origin, Vec3d(1.5, -0.5, 4), 1e-14);
}

TEST(Camera, PixelAspectOfTwoHalvesTheHeightSeen)
{
    Camera camera = ahead();
    camera.projection = Projection::Orthographic;
    camera.width = 4;
    const CameraView view(camera, {100, 100, 2.0, {}});
    expect_near(view.ray(0, 0).origin - view.ray(100, 100).origin, Vec3d(-4, 2, 0), 1e-14);
}

TEST(Camera, DepthIsTheDistanceAlongTheAxis)
{
    const CameraView view(ahead(), {100, 100, 1, {}});
    EXPECT_NEAR(view.depth(50, 50, 2), 2, 1e-15);
    EXPECT_NEAR(view.depth(100, 50, 2), 2 / std::sqrt(2.0), 1e-14);  // 45 degrees off the axis
}

class AnyProjection : public testing::TestWithParam<Projection> {
protected:
    CameraView view() const
    {
        Camera camera;
        camera.projection = GetParam();
        camera.position = Vec3d(3, -2, 7);
        camera.look_at = Vec3d(-1, 0.5, 1);
        camera.up = Vec3d(0.1, 2, 0.3);
        camera.fov = 50;
        camera.width = 6;
        return {camera, {640, 360, 1.1, {}}};
    }
};

TEST_P(AnyProjection, NdcOfAPointOnARayIsItsPicturePosition)
{
    const CameraView v = view();
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {640.0, 360.0}, {123.4, 300.0}})
        for (const double t : {0.5, 3.0, 100.0}) {
            const WorldRay ray = v.ray(x, y);
            const Vec3d ndc = homogeneous(ray.origin + t * ray.direction, v.world_to_ndc());
            EXPECT_NEAR(ndc[0], x / 640, 1e-12);
            EXPECT_NEAR(ndc[1], y / 360, 1e-12);
        }
}

TEST_P(AnyProjection, NdcDepthGrowsAlongTheView)
{
    const CameraView v = view();
    double before = -1e9;
    for (const double t : {0.1, 1.0, 10.0, 1000.0}) {
        const WorldRay ray = v.ray(100, 200);
        const double z = homogeneous(ray.origin + t * ray.direction, v.world_to_ndc())[2];
        EXPECT_GT(z, before);
        before = z;
    }
}

TEST_P(AnyProjection, CameraSpaceIsLeftHandedWithDepthAlongZ)
{
    const CameraView v = view();
    const Matrix44 m = v.world_to_camera();
    expect_near(homogeneous(v.camera().position, m), Vec3d(0, 0, 0), 1e-13);
    const double distance = (v.camera().look_at - v.camera().position).length();
    expect_near(homogeneous(v.camera().look_at, m), Vec3d(0, 0, distance), 1e-13);
    expect_near(homogeneous(v.camera().position + v.right(), m), Vec3d(1, 0, 0), 1e-13);
    expect_near(homogeneous(v.camera().position + v.up(), m), Vec3d(0, 1, 0), 1e-13);
    // World space is right-handed: the change to a left-handed one is a reflection.
    const Vec3d x(m[0], m[4], m[8]), y(m[1], m[5], m[9]), z(m[2], m[6], m[10]);
    EXPECT_NEAR(x.cross(y).dot(z), -1, 1e-13);
    EXPECT_GT(v.up().dot(v.camera().up), 0);

    const WorldRay ray = v.ray(77, 300);
    EXPECT_NEAR(homogeneous(ray.origin + 5.0 * ray.direction, m)[2], v.depth(77, 300, 5), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Both, AnyProjection, testing::Values(Projection::Perspective, Projection::Orthographic));

TEST(Camera, HasAxesWhenLookingAlongUp)
{
    for (const double y : {-3.0, 3.0}) {
        Camera camera;
        camera.position = Vec3d(0, y, 0);
        const CameraView view(camera, {64, 64, 1, {}});
        expect_near(view.ray(32, 32).direction, Vec3d(0, -y / 3, 0), 1e-14);
        EXPECT_NEAR(view.right().length(), 1, 1e-14);
        EXPECT_NEAR(view.right().dot(view.forward()), 0, 1e-14);
    }
}

TEST(Camera, CropLeavesRaysUnchanged)
{
    const CameraView whole(ahead(), {200, 100, 1, {}}), part(ahead(), {200, 100, 1, {20, 30, 50, 60}});
    expect_near(whole.ray(33.5, 40.5).direction, part.ray(33.5, 40.5).direction, 1e-300);
    EXPECT_EQ(part.size().window(), (PixelWindow{20, 30, 50, 60}));
    EXPECT_EQ(whole.size().window(), (PixelWindow{0, 0, 200, 100}));
}

TEST(Camera, RefusesInadmissibleCameras)
{
    const ImageSize size{64, 64, 1, {}};
    const auto refused = [&](auto change) {
        Camera camera = ahead();
        ImageSize image = size;
        change(camera, image);
        EXPECT_THROW(CameraView(camera, image), InputError);
    };
    refused([](Camera& c, ImageSize&) { c.look_at = c.position; });
    refused([](Camera& c, ImageSize&) { c.up = Vec3d(0, 0, 0); });
    refused([](Camera& c, ImageSize&) { c.position[1] = std::nan(""); });
    refused([](Camera& c, ImageSize&) { c.fov = 180; });
    refused([](Camera& c, ImageSize&) { c.fov = 0; });
    refused([](Camera& c, ImageSize&) { c.projection = Projection::Orthographic, c.width = 0; });
    refused([](Camera&, ImageSize& s) { s.width = 0; });
    refused([](Camera&, ImageSize& s) { s.height = 70000; });
    refused([](Camera&, ImageSize& s) { s.pixel_aspect = -1; });
    refused([](Camera&, ImageSize& s) { s.crop = {10, 10, 65, 20}; });
    refused([](Camera&, ImageSize& s) { s.crop = {10, 20, 20, 20}; });
    refused([](Camera&, ImageSize& s) { s.crop = {20, 0, 10, 10}; });
}

}  // namespace
}  // namespace vdbcloud
