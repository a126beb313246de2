#include "vdbcloud/render/light_sampling.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

EquiangularSampler::EquiangularSampler(const WorldRay& ray, const Vec3d& lamp, double t0, double t1) : t0_(t0), t1_(t1)
{
    const Vec3d to_lamp = lamp - ray.origin;
    foot_ = to_lamp.dot(ray.direction);
    const double least = std::max(1e-9 * to_lamp.length(), 1e-300);
    distance_ = std::max(to_lamp.cross(ray.direction).length(), least);
    first_angle_ = std::atan2(t0 - foot_, distance_);
    // The difference of two angles, without cancellation.
    angle_ = std::atan2(distance_ * (t1 - t0), distance_ * distance_ + (t0 - foot_) * (t1 - foot_));
}

double EquiangularSampler::sample(double u) const
{
    return std::clamp(foot_ + distance_ * std::tan(first_angle_ + u * angle_), t0_, t1_);
}

double EquiangularSampler::density(double t) const
{
    if (!(t >= t0_ && t <= t1_ && angle_ > 0)) return 0;
    return distance_ / (angle_ * (distance_ * distance_ + (t - foot_) * (t - foot_)));
}

Vec3d direction_near_lamp(const Vec3d& to_lamp, double u, double v)
{
    const Vec3d x = (std::abs(to_lamp[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(to_lamp).unit(),
                y = to_lamp.cross(x);
    const double c = std::cos(pi * u), s = std::sin(pi * u);
    return (c * to_lamp + s * std::cos(2 * pi * v) * x + s * std::sin(2 * pi * v) * y).unit();
}

double density_near_lamp(const Vec3d& to_lamp, const Vec3d& direction)
{
    return 1 / (2 * pi * pi * std::max(to_lamp.cross(direction).length(), 1e-300));
}

}  // namespace vdbcloud
