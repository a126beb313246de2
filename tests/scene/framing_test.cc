// Auto-framing: everything in the picture, as large as it fits, wherever and however large the cloud is.
#include "vdbcloud/scene/camera.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

struct Placement {
    Vec3d axis{0, 1, 0};
    double angle = 0, scale = 1;
    Vec3d shift{0, 0, 0};
    Vec3d turned(const Vec3d& v) const
    {
        const Vec3d k = axis / axis.length();
        return v * std::cos(angle) + k.cross(v) * std::sin(angle) + k * (k.dot(v) * (1 - std::cos(angle)));
    }
    Vec3d placed(const Vec3d& p) const { return turned(p) * scale + shift; }
};

std::vector<Vec3d> box(const Placement& where)
{
    std::vector<Vec3d> out;
    for (int corner = 0; corner < 8; ++corner)
        out.push_back(where.placed(Vec3d(corner & 1 ? 2 : -1, corner & 2 ? 1 : 0, corner & 4 ? 0.5 : -1.5)));
    return out;
}

/// Where a point appears, as fractions of the picture from its upper left corner.
Vec3d in_picture(const CameraView& view, const Vec3d& p)
{
    const Matrix44 m = view.world_to_ndc();
    double out[4];
    for (size_t c = 0; c < 4; ++c) out[c] = p[0] * m[c] + p[1] * m[4 + c] + p[2] * m[8 + c] + m[12 + c];
    EXPECT_GT(out[3], 0) << "behind the camera";
    return Vec3d(out[0], out[1], out[2]) / out[3];
}

std::vector<Placement> placements()
{
    std::vector<Placement> out{Placement{}};
    for (int k = 0; k < 40; ++k) {
        const auto u = [k](int d) { return uniform(hash_bits(7, uint64_t(k), uint64_t(d))) * 2 - 1; };
        out.push_back({Vec3d(u(0), u(1), u(2)), pi * u(3), std::pow(10.0, 4 * u(4)), Vec3d(u(5), u(6), u(7)) * 20.0});
    }
    return out;
}

class Framing : public testing::TestWithParam<Projection> {};

TEST_P(Framing, KeepsEveryCornerWithinTheMarginAndReachesIt)
{
    for (const ImageSize& size : {ImageSize{512, 512, 1, {}}, ImageSize{640, 200, 1, {}}, ImageSize{100, 300, 1.5, {}}})
        for (const Placement& where : placements()) {
            FramingOptions options;
            options.projection = GetParam();
            options.margin = 0.1;
            const auto corners = box(where);
            const CameraView view(frame_points(corners, size, options), size);
            double left = 1, right = 1, top = 1, bottom = 1;  // room left at each edge
            for (const Vec3d& corner : corners) {
                const Vec3d at = in_picture(view, corner);
                left = std::min(left, at[0]);
                right = std::min(right, 1 - at[0]);
                top = std::min(top, at[1]);
                bottom = std::min(bottom, 1 - at[1]);
            }
            const double slack = 1e-9 * (1 + where.shift.length() / where.scale);  // rounding far from the origin
            EXPECT_GE(std::min({left, right, top, bottom}), 0.1 - slack);
            // As large as it fits: both edges of one axis are reached.
            EXPECT_NEAR(std::min(std::max(left, right), std::max(top, bottom)), 0.1, slack);
        }
}

TEST_P(Framing, CameraTurnsAndScalesWithItsScene)
{
    const ImageSize size{320, 240, 1, {}};
    FramingOptions options;
    options.projection = GetParam();
    const Placement rest;
    const CameraView before(frame_points(box(rest), size, options), size);
    for (const Placement& where : placements()) {
        FramingOptions moved = options;
        moved.up = where.turned(options.up);
        moved.direction = where.turned(default_view_direction(options.up));
        const CameraView after(frame_points(box(where), size, moved), size);
        const double unit = where.scale + where.shift.length();
        EXPECT_LT((after.camera().position - where.placed(before.camera().position)).length(), 1e-10 * unit);
        const Vec3d w = before.ray(31, 200).direction;
        EXPECT_LT((after.ray(31, 200).direction - where.turned(w)).length(), 1e-9 * unit / where.scale);
    }
}

TEST_P(Framing, CentresALineAlongTheView)
{
    FramingOptions options;
    options.projection = GetParam();
    options.direction = Vec3d(0, 0, -1);
    const ImageSize size{64, 64, 1, {}};
    const CameraView view(frame_points({Vec3d(0, 0, 0), Vec3d(0, 0, 3)}, size, options), size);
    for (const double z : {0.0, 3.0}) EXPECT_NEAR(in_picture(view, Vec3d(0, 0, z))[0], 0.5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Both, Framing, testing::Values(Projection::Perspective, Projection::Orthographic));

TEST_P(Framing, StandsBeforeAllThatRaysSee)
{
    // A small box in a veil that reaches 30 units towards the camera and 4 aside, in odd places.
    const ImageSize size{64, 48, 1, {}};
    for (const Placement& where : placements()) {
        SeenExtent extent;
        for (const Vec3d& p : box(Placement{})) extent.points.push_back(where.placed(p * Vec3d(4, 4, 20)));
        FramingOptions options;
        options.projection = GetParam();
        options.up = where.turned(Vec3d(0, 1, 0));
        options.direction = where.turned(Vec3d(0.1, -0.2, -1));
        const Camera framed = frame_points(box(where), size, options);
        const CameraView before(framed, size);
        const double way = way_before(before, extent);
        EXPECT_GT(way, 2 * where.scale);
        const Camera camera = before_all(framed, size, extent);
        const CameraView view(camera, size);
        EXPECT_LT(way_before(view, extent), 1e-9 * way);
        EXPECT_EQ(camera.look_at, framed.look_at);
        EXPECT_LT(((framed.position - camera.position) - way * before.forward()).length(), 1e-9 * way);
        double nearest = 1e300;
        for (const Vec3d& p : extent.points) nearest = std::min(nearest, (p - camera.position).dot(view.forward()));
        EXPECT_NEAR(nearest / way, 0, 1e-9) << "no further back than it must";
        EXPECT_EQ(before_all(camera, size, {box(where), {}}).position, camera.position) << "stands before the box";
        EXPECT_EQ(way_before(view, {}), 0);
    }
}

TEST_P(Framing, StandsOutsideALayerThatRepeats)
{
    // A layer 0..1 along y that repeats along x and z, seen from below at a slope of 1 in 5.
    const ImageSize size{64, 64, 1, {}};
    SeenExtent layer;
    for (int k = 0; k < 8; ++k) layer.points.push_back(Vec3d(k & 1 ? 3 : 0, k & 2 ? 1 : 0, k & 4 ? 3 : 0));
    layer.repeats = {Vec3d(7, 0, 0), Vec3d(0, 0, -2)};
    FramingOptions options;
    options.projection = GetParam();
    options.direction = Vec3d(0, 1, -5);
    const Camera framed = frame_points(layer.points, size, options);
    const Camera camera = before_all(framed, size, layer);
    const CameraView view(camera, size);
    double highest = -1e300;
    for (const double x : {0.0, 64.0})
        for (const double y : {0.0, 64.0}) highest = std::max(highest, view.ray(x, y).origin[1]);
    EXPECT_NEAR(highest, std::min(0.0, CameraView(framed, size).ray(0, 0).origin[1]), 1e-9);
    EXPECT_GT(way_before(CameraView(framed, size), layer), GetParam() == Projection::Orthographic ? 1 : -1);
    options.direction = Vec3d(0, 0, -1);
    const Camera level = frame_points(layer.points, size, options);
    EXPECT_TRUE(std::isinf(way_before(CameraView(level, size), layer)));
    EXPECT_EQ(before_all(level, size, layer).position, level.position);
}

TEST(DefaultView, IsNearlyLevelFromTheFrontForAnyUp)
{
    const Vec3d y = default_view_direction(Vec3d(0, 1, 0));
    EXPECT_NEAR(y.length(), 1, 1e-14);
    EXPECT_LT(y[2], -0.5);  // from +Z
    EXPECT_LT(y[0], 0);     // and +X
    EXPECT_GT(y[1], 0);     // a little upwards
    EXPECT_LT(y[1], 0.3);
    const Vec3d z = default_view_direction(Vec3d(0, 0, 2));  // +Y to +Z takes +Z to -Y: a front view of a Z-up program
    EXPECT_NEAR(z[2], y[1], 1e-14);
    EXPECT_NEAR(z[1], -y[2], 1e-14);
    EXPECT_NEAR(default_view_direction(Vec3d(0, -1, 0)).dot(Vec3d(0, -1, 0)), y[1], 1e-14);
}

TEST(DefaultSun, IsHighToTheLeftOnTheViewersSideForAnyUp)
{
    for (const Vec3d& up : {Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(-3, 0, 0)}) {
        const Vec3d sun = default_sun_direction(up), view = default_view_direction(up);
        EXPECT_NEAR(sun.length(), 1, 1e-14);
        EXPECT_GT(sun.dot(up) / up.length(), 0.5);
        EXPECT_LT(sun.dot(view.cross(up)), 0);  // view x up is to the right
        EXPECT_LT(sun.dot(view), -0.1);
    }
}

TEST(Framing, RefusesPointsWithoutExtent)
{
    EXPECT_THROW(frame_points({}, {}), InputError);
    EXPECT_THROW(frame_points({Vec3d(1, 1, 1), Vec3d(1, 1, 1)}, {}), InputError);
    EXPECT_THROW(frame_points({Vec3d(1, 1, 1), Vec3d(1, std::nan(""), 1)}, {}), InputError);
}

}  // namespace
}  // namespace vdbcloud
