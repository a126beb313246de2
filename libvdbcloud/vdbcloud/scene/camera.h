#pragma once
// Cameras: from pixels to rays in world space, and the matrices that tell other programs about it.
#include "vdbcloud/core/affine.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

enum class Projection { Perspective, Orthographic };

/// Position and direction of a view. Any position is admissible, also inside the cloud.
struct Camera {
    Projection projection = Projection::Perspective;
    Vec3d position{0, 0, 5};  ///< [world]
    Vec3d look_at{0, 0, 0};   ///< in the middle of the picture [world]
    Vec3d up{0, 1, 0};        ///< upwards in the picture as far as the view allows; any length
    double fov = 40;          ///< perspective: angle across the picture's width [degrees], in (0, 180)
    double width = 2;         ///< orthographic: the picture's width [world unit], > 0
};

/// A rectangle of pixels, [x0, x1) x [y0, y1).
struct PixelWindow {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    bool operator==(const PixelWindow& o) const { return x0 == o.x0 && y0 == o.y0 && x1 == o.x1 && y1 == o.y1; }
};

/// The picture's size in pixels, and the part of it that is wanted.
struct ImageSize {
    int width = 512, height = 512;
    double pixel_aspect = 1;  ///< width of a pixel over its height
    PixelWindow crop;         ///< all zero (the default): all of it

    PixelWindow window() const { return crop == PixelWindow{} ? PixelWindow{0, 0, width, height} : crop; }
};

/// A matrix for row vectors, as OpenEXR's: (x, y, z, 1) M; m[4 * row + column].
using Matrix44 = std::array<double, 16>;

/// A camera made ready for one picture. A value; share it between threads.
///
/// Picture coordinates are in pixels, x to the right and y down, (0, 0) the upper left corner of the whole
/// picture, so the centre of pixel (i, j) is (i + 0.5, j + 0.5). A crop changes nothing here.
class CameraView {
public:
    /// Throws InputError if the camera looks nowhere (position at look_at, up of no length), if fov, width or
    /// pixel aspect is out of range, if the picture has no pixels or more than 65536 on a side, or the crop
    /// is not in it. Where up is along the view, the world axis least along it takes its place.
    CameraView(const Camera&, const ImageSize&);

    /// The ray through picture point (x, y). Orthographic rays start in the plane through the camera's
    /// position; what is behind that plane is not seen.
    WorldRay ray(double x, double y) const;

    /// Distance along the view axis of the point at distance `t` along the ray through (x, y): the depth that
    /// goes to Z.
    double depth(double x, double y, double t) const;

    /// OpenEXR's worldToCamera: left-handed, x right, y up, z along the view, in world units.
    Matrix44 world_to_camera() const;

    /// OpenEXR's worldToNDC: after division by w, (0, 0) is the upper left and (1, 1) the lower right corner
    /// of the whole picture; z grows from 0 at the near plane (a thousandth of the distance to look_at) to 1
    /// at infinity for a perspective camera, and is the depth over the distance to look_at for an
    /// orthographic one.
    Matrix44 world_to_ndc() const;

    const Camera& camera() const { return camera_; }
    const ImageSize& size() const { return size_; }
    Vec3d right() const { return right_; }
    Vec3d up() const { return up_; }
    Vec3d forward() const { return forward_; }

private:
    Camera camera_;
    ImageSize size_;
    Vec3d right_, up_, forward_;       // orthonormal, world
    double half_width_, half_height_;  // of the picture, at unit depth or in world units
};

/// The default direction of view, unit: three quarters from the front, nearly level and a little from below.
/// For up = Y the camera stands towards +Z and +X; for any other `up` the direction is turned by the
/// smallest rotation from Y to `up`.
Vec3d default_view_direction(const Vec3d& up);

/// The direction TOWARDS a sun that goes with that view: high to the left, a little on the viewer's side.
/// Unit.
Vec3d default_sun_direction(const Vec3d& up);

struct FramingOptions {
    Projection projection = Projection::Perspective;
    Vec3d up{0, 1, 0};
    Vec3d direction{0, 0, 0};  ///< in which to look, any length; 0: default_view_direction(up)
    double fov = 40;           ///< of a perspective camera, across the width [degrees]
    double margin = 0.08;      ///< of the picture's width and height left free at each edge, in [0, 0.5)
};

/// The camera that looks along a direction and has all `points` in the picture as large as fits within the
/// margin, centred. Give the corners of boxes around what should be seen (rotated ones too); more points fit
/// more tightly. The same picture results if points, up and direction are scaled, turned or moved together.
/// Throws InputError if there is no point or one is not finite.
Camera frame_points(const std::vector<Vec3d>& points, const ImageSize&, const FramingOptions& = {});

/// What rays can see: all matter lies within the hull of `points` [world], and repeats along `repeats`, vectors of any
/// length that are linearly independent. Framing may leave thin matter out, a ray may not.
struct SeenExtent {
    std::vector<Vec3d> points;
    std::vector<Vec3d> repeats;
};

/// The way [world unit] that a camera has to go back against its view until all matter lies before it; 0 for one that
/// stands there or if there is no matter. Before it: along the view, less the part of the view along which matter
/// repeats. Infinity if the view has no other part.
double way_before(const CameraView&, const SeenExtent&);

/// A camera that stands before all matter: moved back by way_before(), where that is finite. It looks at the same
/// point.
Camera before_all(const Camera&, const ImageSize&, const SeenExtent&);

}  // namespace vdbcloud
