// Auto-framing: the camera that shows everything, as large as it fits.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/scene/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// v turned by the smallest rotation that takes +Y to `up` (unit); half a turn about X if up is -Y.
Vec3d turned_with_up(const Vec3d& v, const Vec3d& up)
{
    const double c = up[1];
    if (c < -1 + 1e-12) return {v[0], -v[1], -v[2]};
    const Vec3d k = Vec3d(0, 1, 0).cross(up);
    const Vec3d kv = k.cross(v);
    return v + kv + k.cross(kv) / (1 + c);  // Rodrigues' formula
}

struct Range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    void add(double x)
    {
        low = std::min(low, x);
        high = std::max(high, x);
    }
    double middle() const { return low + (high - low) / 2; }
    double length() const { return high - low; }
};

/// Points in the axes of a view: x to the right, y up, z along it.
std::vector<Vec3d> in_view(const std::vector<Vec3d>& points, const CameraView& axes)
{
    std::vector<Vec3d> out;
    out.reserve(points.size());
    for (const Vec3d& p : points) out.push_back({p.dot(axes.right()), p.dot(axes.up()), p.dot(axes.forward())});
    return out;
}

/// Where along one axis across the picture a perspective camera can stand. It sees every point if
/// |x - camera| <= slope (z - depth), that is, if  low + slope depth <= camera <= high - slope depth.
struct Stand {
    double low = -std::numeric_limits<double>::infinity();  // largest x - slope z
    double high = std::numeric_limits<double>::infinity();  // smallest x + slope z
    double slope;
    void add(double x, double z)
    {
        low = std::max(low, x - slope * z);
        high = std::min(high, x + slope * z);
    }
    double deepest() const { return (high - low) / (2 * slope); }
    double middle() const { return low + (high - low) / 2; }  // at any depth
};

constexpr double view_azimuth = 35,
                 view_elevation = -6;  // of the default camera, seen from the cloud [degrees]
constexpr double sun_azimuth = view_azimuth - 52, sun_elevation = 46;

/// Unit vector at an angle from +Z towards +X and one above the horizon [degrees], turned along with `up`.
Vec3d at_angles(double azimuth, double elevation, const Vec3d& up)
{
    const double a = azimuth * pi / 180, e = elevation * pi / 180;
    const Vec3d y_up(std::sin(a) * std::cos(e), std::sin(e), std::cos(a) * std::cos(e));
    return turned_with_up(y_up, up / up.length());
}

}  // namespace

Vec3d default_view_direction(const Vec3d& up) { return -at_angles(view_azimuth, view_elevation, up); }

Vec3d default_sun_direction(const Vec3d& up) { return at_angles(sun_azimuth, sun_elevation, up); }

Camera frame_points(const std::vector<Vec3d>& points, const ImageSize& size, const FramingOptions& options)
{
    if (points.empty()) throw InputError("framing: no point to look at");
    for (const Vec3d& p : points)
        if (!std::isfinite(p[0] + p[1] + p[2])) throw InputError("framing: a point is not finite");
    if (!(options.margin >= 0 && options.margin < 0.5))
        throw InputError("framing: margin " + std::to_string(options.margin) + ": expected a number in [0, 0.5)");
    if (!(options.up.length() > 0 && std::isfinite(options.up.length()))) throw InputError("framing: up has no length");

    Camera camera;
    camera.projection = options.projection;
    camera.up = options.up;
    camera.fov = options.fov;
    camera.position = Vec3d(0, 0, 0);
    camera.look_at = options.direction.length() > 0 ? options.direction : default_view_direction(options.up);
    const CameraView axes(camera, size);  // checks the other options, and gives the view's axes
    const auto seen = in_view(points, axes);

    Range x, y, z;
    for (const Vec3d& p : seen) x.add(p[0]), y.add(p[1]), z.add(p[2]);
    const double extent = std::max({x.length(), y.length(), z.length()});
    if (!(extent > 0)) throw InputError("framing: all points are at one place");

    const double room = 1 - 2 * options.margin;
    const double aspect = size.width * size.pixel_aspect / size.height;
    Vec3d stand;  // in the view's axes
    if (options.projection == Projection::Orthographic) {
        camera.width = std::max(x.length(), y.length() * aspect) / room;
        if (!(camera.width > 0)) camera.width = extent;  // a line along the view
        stand = Vec3d(x.middle(), y.middle(), z.low - 0.05 * extent);
    } else {
        const double slope = std::tan(options.fov * pi / 360) * room;
        Stand across, upward;
        across.slope = slope;
        upward.slope = slope / aspect;
        for (const Vec3d& p : seen) across.add(p[0], p[2]), upward.add(p[1], p[2]);
        const double depth = std::min({across.deepest(), upward.deepest(), z.low - 0.05 * extent});
        stand = Vec3d(across.middle(), upward.middle(), depth);
    }
    camera.position = stand[0] * axes.right() + stand[1] * axes.up() + stand[2] * axes.forward();
    camera.look_at = camera.position + (z.middle() - stand[2]) * axes.forward();
    return camera;
}

namespace {

/// `v` less its part in the space of `vectors`.
Vec3d part_across(const Vec3d& v, const std::vector<Vec3d>& vectors)
{
    std::vector<Vec3d> basis;
    const auto across = [&](Vec3d of) {
        for (const Vec3d& b : basis) of -= of.dot(b) * b;
        return of;
    };
    for (const Vec3d& vector : vectors) {
        const Vec3d next = across(vector.unit());
        if (next.length() > 1e-9) basis.push_back(next.unit());
    }
    return across(v);
}

}  // namespace

double way_before(const CameraView& view, const SeenExtent& extent)
{
    if (extent.points.empty()) return 0;
    const Vec3d across = part_across(view.forward(), extent.repeats);
    const double square = across.dot(across);
    if (square < 1e-12) return std::numeric_limits<double>::infinity();
    double nearest = std::numeric_limits<double>::infinity(), start = -nearest;
    for (const Vec3d& p : extent.points) nearest = std::min(nearest, p.dot(across));
    for (const double x : {0.0, double(view.size().width)})
        for (const double y : {0.0, double(view.size().height)})
            start = std::max(start, view.ray(x, y).origin.dot(across));
    return std::max(start - nearest, 0.0) / square;
}

Camera before_all(const Camera& camera, const ImageSize& size, const SeenExtent& extent)
{
    const CameraView view(camera, size);
    const double way = way_before(view, extent);
    Camera moved = camera;
    if (std::isfinite(way)) moved.position -= way * view.forward();
    return moved;
}

}  // namespace vdbcloud
