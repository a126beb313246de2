#include "vdbcloud/scene/camera.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"

#include <cmath>
#include <sstream>

namespace vdbcloud {

namespace {

constexpr int most_pixels = 65536;      // on a side
constexpr double near_fraction = 1e-3;  // near plane over the distance to look_at, for worldToNDC

/// v / |v|, or a refusal. Scaled first, so that a length of 1e-200 or 1e200 is as good as any.
Vec3d unit_or_refuse(const char* what, const Vec3d& v, const char* expected)
{
    const double largest = std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
    if (!(largest > 0 && std::isfinite(largest))) refuse(what, v, expected);
    const Vec3d scaled = v / largest;
    return scaled / scaled.length();
}

void check(const Camera& camera, const ImageSize& size)
{
    if (camera.projection == Projection::Perspective && !(camera.fov > 0 && camera.fov < 180))
        refuse("field of view", camera.fov, "degrees in (0, 180)");
    if (camera.projection == Projection::Orthographic && !(camera.width > 0 && std::isfinite(camera.width)))
        refuse("orthographic width", camera.width, "a finite length above 0");
    for (const int n : {size.width, size.height})
        if (n < 1 || n > most_pixels) refuse("picture size", n, "1 to 65536 pixels");
    if (!(size.pixel_aspect > 0 && std::isfinite(size.pixel_aspect)))
        refuse("pixel aspect", size.pixel_aspect, "a finite number above 0");
    const PixelWindow w = size.window();
    if (w.x0 < 0 || w.y0 < 0 || w.x1 > size.width || w.y1 > size.height || w.width() < 1 || w.height() < 1) {
        std::ostringstream text;
        text << w.x0 << "," << w.y0 << "," << w.x1 << "," << w.y1;
        refuse("crop", text.str(), "x0,y0,x1,y1 within the picture, x0 < x1 and y0 < y1");
    }
}

}  // namespace

CameraView::CameraView(const Camera& camera, const ImageSize& size) : camera_(camera), size_(size)
{
    check(camera, size);
    for (int c = 0; c < 3; ++c)
        if (!std::isfinite(camera.position[c])) refuse("camera position", camera.position, "finite coordinates");

    forward_ = unit_or_refuse("camera's way from position to look-at", camera.look_at - camera.position,
                              "two different finite points");
    Vec3d up = unit_or_refuse("camera's up", camera.up, "a vector of some length");
    if (std::abs(up.dot(forward_)) > 1 - 1e-12) {
        int axis = 0;
        for (int c = 1; c < 3; ++c)
            if (std::abs(forward_[c]) < std::abs(forward_[axis])) axis = c;
        up = Vec3d(0, 0, 0);
        up[axis] = 1;
    }
    right_ = forward_.cross(up);
    right_.normalize();
    up_ = right_.cross(forward_);

    half_width_ = camera.projection == Projection::Perspective ? std::tan(camera.fov * pi / 360) : camera.width / 2;
    half_height_ = half_width_ * size.height / (size.width * size.pixel_aspect);
}

WorldRay CameraView::ray(double x, double y) const
{
    const double u = (2 * x / size_.width - 1) * half_width_;
    const double v = (1 - 2 * y / size_.height) * half_height_;
    const Vec3d aside = u * right_ + v * up_;
    if (camera_.projection == Projection::Orthographic) return {camera_.position + aside, forward_};
    const Vec3d direction = forward_ + aside;
    return {camera_.position, direction / direction.length()};
}

double CameraView::depth(double x, double y, double t) const { return t * ray(x, y).direction.dot(forward_); }

Matrix44 CameraView::world_to_camera() const
{
    const Vec3d& o = camera_.position;
    return {right_[0],      up_[0],      forward_[0],      0,  //
            right_[1],      up_[1],      forward_[1],      0,  //
            right_[2],      up_[2],      forward_[2],      0,  //
            -o.dot(right_), -o.dot(up_), -o.dot(forward_), 1};
}

Matrix44 CameraView::world_to_ndc() const
{
    // From camera space: x' = w/2 + x/(2 half_width), y' = w/2 - y/(2 half_height), w = z or 1.
    const double sx = 0.5 / half_width_, sy = -0.5 / half_height_;
    const double distance = (camera_.look_at - camera_.position).length();
    Matrix44 project{};
    project[0] = sx;
    project[5] = sy;
    if (camera_.projection == Projection::Perspective) {
        project[8] = project[9] = 0.5;
        project[10] = 1;
        project[11] = 1;
        project[14] = -near_fraction * distance;
    } else {
        project[10] = 1 / distance;
        project[12] = project[13] = 0.5;
        project[15] = 1;
    }
    const Matrix44 view = world_to_camera();
    Matrix44 out{};
    for (size_t row = 0; row < 4; ++row)
        for (size_t column = 0; column < 4; ++column)
            for (size_t k = 0; k < 4; ++k) out[4 * row + column] += view[4 * row + k] * project[4 * k + column];
    return out;
}

}  // namespace vdbcloud
