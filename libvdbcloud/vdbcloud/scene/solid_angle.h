#pragma once
// The solid angle of a parallelogram. Private to scene/.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <cmath>

namespace vdbcloud {

/// Signed solid angle under which a triangle is seen from the origin (Van Oosterom & Strackee 1983).
inline double solid_angle(const Vec3d& a, const Vec3d& b, const Vec3d& c)
{
    const double la = a.length(), lb = b.length(), lc = c.length();
    return 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la);
}

/// The same of a parallelogram with these corners, in order around it; 0 or above.
inline double solid_angle(const std::array<Vec3d, 4>& corner)
{
    return std::abs(solid_angle(corner[0], corner[1], corner[2]) + solid_angle(corner[0], corner[2], corner[3]));
}

}  // namespace vdbcloud
