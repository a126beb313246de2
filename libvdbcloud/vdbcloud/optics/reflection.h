#pragma once
// How the surface of a solid sends light back: value, density and sampler of directions.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/scene/solid.h"

namespace vdbcloud {

/// The direction at an angle of cosine `c` from `axis` (unit), turned about it by `angle`.
Vec3d direction_about(const Vec3d& axis, double c, double angle);

/// The directions in which a surface sends light that a viewer sees, for one point of view. All directions point away
/// from the surface, unit. With the colour apart, scattering into a solid angle is value(w) dw:
///
///     diffuse   value = density = cos / pi
///     glossy    value = (n + 2) / (2 pi) cos^n(a) cos,   density = (n + 1) / (2 pi) cos^n(a),   n = 2 / roughness^2 - 2
///     mirror    all from the mirror image
///
/// cos: of the angle to the normal; a: the angle to the mirror image of the viewer. Below the surface the value is 0.
/// The integral of value is 1 (diffuse) or at most 1: a glossy surface seen at a grazing angle loses the part of its
/// lobe that lies below it, and is symmetric in viewer and light.
/// Source: Lafortune & Willems 1994, "Using the modified Phong reflectance model for physically based rendering".
class Reflection {
public:
    /// `to_viewer`: unit, on the outer side of `normal`.
    Reflection(const Material&, const Vec3d& normal, const Vec3d& to_viewer);

    bool mirror() const { return finish_ == Finish::Mirror; }
    const Vec3d& image() const { return image_; }  ///< the mirror image of the viewer
    /// Not of a mirror.
    double value(const Vec3d& direction) const;
    /// With which sample() draws a direction. Not of a mirror.
    double density(const Vec3d& direction) const;
    /// A direction for u, v uniform in [0, 1); that of the mirror image for a mirror. It may lie below the surface,
    /// where nothing comes from.
    Vec3d sample(double u, double v) const;

private:
    Finish finish_;
    double power_ = 0;
    Vec3d normal_, image_;
};

}  // namespace vdbcloud
