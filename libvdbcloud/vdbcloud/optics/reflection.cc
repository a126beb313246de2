#include "vdbcloud/optics/reflection.h"

#include "vdbcloud/core/constants.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double most_power = 1e8;  // beyond it a lobe is a mirror's to 1e-4

}  // namespace

Vec3d direction_about(const Vec3d& axis, double c, double angle)
{
    const Vec3d a = (std::abs(axis[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(axis).unit(), b = axis.cross(a);
    const double s = std::sqrt(std::max(0.0, 1 - c * c));
    return (c * axis + s * (std::cos(angle) * a + std::sin(angle) * b)).unit();
}

Reflection::Reflection(const Material& material, const Vec3d& normal, const Vec3d& to_viewer)
    : finish_(material.finish), normal_(normal), image_((2 * normal.dot(to_viewer) * normal - to_viewer).unit())
{
    const double r = material.roughness;
    power_ = r * r * (most_power + 2) > 2 ? 2 / (r * r) - 2 : most_power;
}

double Reflection::value(const Vec3d& direction) const
{
    const double c = normal_.dot(direction);
    if (!(c > 0)) return 0;
    if (finish_ == Finish::Diffuse) return c / pi;
    return (power_ + 2) / (2 * pi) * std::pow(std::max(0.0, image_.dot(direction)), power_) * c;
}

double Reflection::density(const Vec3d& direction) const
{
    if (finish_ == Finish::Diffuse) return std::max(0.0, normal_.dot(direction)) / pi;
    return (power_ + 1) / (2 * pi) * std::pow(std::max(0.0, image_.dot(direction)), power_);
}

Vec3d Reflection::sample(double u, double v) const
{
    if (finish_ == Finish::Mirror) return image_;
    if (finish_ == Finish::Diffuse) return direction_about(normal_, std::sqrt(1 - u), 2 * pi * v);
    return direction_about(image_, std::pow(1 - u, 1 / (power_ + 1)), 2 * pi * v);
}

}  // namespace vdbcloud
