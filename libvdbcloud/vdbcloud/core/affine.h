#pragma once
// An affine map and a ray in world space: the geometry that ray marching needs.
#include "vdbcloud/core/fwd.h"

#include <array>

namespace vdbcloud {

/// p -> a p + b.
struct Affine {
    std::array<Vec3d, 3> a{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};  ///< rows
    Vec3d b{0, 0, 0};

    Vec3d vector(const Vec3d& v) const { return {a[0].dot(v), a[1].dot(v), a[2].dot(v)}; }
    Vec3d point(const Vec3d& p) const { return vector(p) + b; }
};

/// A ray in world space: unit direction, so the parameter t is a distance [world unit].
struct WorldRay {
    Vec3d origin;
    Vec3d direction;
    Vec3d at(double t) const { return origin + t * direction; }
};

}  // namespace vdbcloud
