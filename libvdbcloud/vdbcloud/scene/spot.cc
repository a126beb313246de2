// The spot: a point that shines into a cone, whose edge may be soft.
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scene/light_kinds.h"
#include "vdbcloud/scene/solid_angle.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace vdbcloud {

namespace {

/// Intensity over that on the axis: 1 up to the inner half angle, 0 beyond the outer, between 3 s^2 - 2 s^3 with s
/// linear in the cosine.
class Spot : public LightModel {
public:
    Spot(const Vec3d& position, const Vec3d& axis, double angle, double blend)
        : position_(position), axis_(axis), outer_(angle / 2 * pi / 180), inner_(outer_ * (1 - blend)),
          cos_outer_(std::cos(outer_)), cos_inner_(std::cos(inner_))
    {
    }

    Sight towards(const Vec3d& x) const override
    {
        const Vec3d to = position_ - x;
        const double r = to.length();
        return {r > 0 ? to / r : Vec3d(0.0), r};
    }

    double irradiance(const Vec3d& x) const override
    {
        const Vec3d from = x - position_;
        const double r = from.length();
        return r > 0 ? falloff(from.dot(axis_) / r) / (r * r) : std::numeric_limits<double>::infinity();
    }

    double mean_irradiance(const WorldRay&, double t0, double t1) const override;
    double power_through(const std::array<Vec3d, 4>& corner, const Vec3d& normal) const override;

    std::optional<PointSource> source() const override
    {
        return PointSource{position_, 2 * pi * (1 - (cos_inner_ + cos_outer_) / 2)};
    }

private:
    double falloff(double cosine) const
    {
        if (cosine >= cos_inner_) return 1;
        if (cosine <= cos_outer_) return 0;
        const double s = (cosine - cos_outer_) / (cos_inner_ - cos_outer_);
        return s * s * (3 - 2 * s);
    }
    double falloff_integral(double reach, double u) const;
    double power_into(const std::array<Vec3d, 4>& corner, int splits) const;

    Vec3d position_, axis_;
    double outer_, inner_;  // half angles
    double cos_outer_, cos_inner_;
};

/// The integral of falloff(reach cos(v)) over 0 <= v <= u: the inner part in closed form, the edge by Gauss-Legendre
/// quadrature of 8 points, whose error is below 1e-8.
double Spot::falloff_integral(double reach, double u) const
{
    constexpr std::pair<double, double> points[] = {{0.1834346424956498, 0.3626837833783620},
                                                    {0.5255324099163290, 0.3137066458778873},
                                                    {0.7966664774136267, 0.2223810344533745},
                                                    {0.9602898564975363, 0.1012285362903763}};
    const double turns = std::round(u / (2 * pi)), within = std::abs(u - 2 * pi * turns);
    const auto up_to = [&](double v) {
        const double a = std::acos(std::clamp(cos_inner_ / reach, -1.0, 1.0)),
                     b = std::min(v, std::acos(std::clamp(cos_outer_ / reach, -1.0, 1.0)));
        if (v <= a) return v;
        double edge = 0;
        for (const auto& [x, weight] : points)
            for (const double side : {-1.0, 1.0})
                edge += weight * falloff(reach * std::cos((a + b) / 2 + side * x * (b - a) / 2)) * (b - a) / 2;
        return a + edge;
    };
    return 2 * turns * up_to(pi) + std::copysign(up_to(within), u - 2 * pi * turns);
}

/// With t = foot + b tan(v), b the ray's distance from the spot, the cosine to the axis is reach cos(v - middle), and
/// dt / r^2 = dv / b. b is no less than a hundredth of the piece, so that a ray through the spot stays finite.
double Spot::mean_irradiance(const WorldRay& ray, double t0, double t1) const
{
    const double foot = (position_ - ray.origin).dot(ray.direction);
    const Vec3d across = ray.at(foot) - position_;
    const double distance = across.length(), b = std::max(distance, 0.01 * (t1 - t0));
    const double along = axis_.dot(ray.direction), aside = distance > 0 ? axis_.dot(across) / distance : 0;
    const double v0 = std::atan2(t0 - foot, b), v1 = std::atan2(t1 - foot, b), reach = std::hypot(along, aside);
    if (!(reach > 1e-9)) return falloff(0) * (v1 - v0) / (b * (t1 - t0));
    const double middle = std::atan2(along, aside);
    return (falloff_integral(reach, v1 - middle) - falloff_integral(reach, v0 - middle)) / (b * (t1 - t0));
}

/// Parts of the parallelogram on which the cone's edge lies are split: an error below 1e-3 of the solid angle where the
/// edge is soft over a tenth of the cone or more, below 1e-2 where the edge is sharp.
double Spot::power_into(const std::array<Vec3d, 4>& corner, int splits) const
{
    const Vec3d centre = ((corner[0] + corner[2]) / 2).unit();
    double widest = 1;
    for (const Vec3d& c : corner) widest = std::min(widest, centre.dot(c) / std::max(c.length(), 1e-300));
    const double angle = std::acos(std::clamp(centre.dot(axis_), -1.0, 1.0)),
                 radius = std::acos(std::clamp(widest, -1.0, 1.0));
    if (splits == 0 || angle + radius <= inner_ || angle - radius >= outer_)
        return falloff(centre.dot(axis_)) * solid_angle(corner);
    const Vec3d u = (corner[1] - corner[0]) / 2, v = (corner[3] - corner[0]) / 2;
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
        const Vec3d first = corner[0] + (k % 2) * u + (k / 2) * v;
        sum += power_into({first, first + u, first + u + v, first + v}, splits - 1);
    }
    return sum;
}

double Spot::power_through(const std::array<Vec3d, 4>& corner, const Vec3d& normal) const
{
    std::array<Vec3d, 4> from;
    for (int k = 0; k < 4; ++k) from[k] = corner[k] - position_;
    const Vec3d middle = from[0] + from[2];
    if (middle.length() == 0) return 0;
    return std::copysign(power_into(from, 5), middle.dot(normal));
}

std::shared_ptr<const LightModel> model(const Vec3d& place, const std::vector<Vec3d>& parameters)
{
    return std::make_shared<Spot>(place, parameters[1], parameters[2][0], parameters[3][0]);
}

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

const LightKind spot_kind{
    "spot",
    "spot",
    "position",
    schema::light_position,
    "position of a point light that shines into a cone [world unit], x,y,z",
    "at",
    false,
    {{"intensity", schema::light_irradiance, "power per steradian on its axis, one number or r,g,b", LightValue::Colour,
      Vec3d(1), 0, infinity},
     {"direction", schema::light_axis, "direction in which it shines, x,y,z", LightValue::Direction, Vec3d(0, -1, 0),
      -infinity, infinity},
     {"angle", schema::light_cone, "angle of the cone, from edge to edge [degrees]", LightValue::Number, Vec3d(45), 0.1,
      179.9},
     {"blend", schema::light_blend, "part of the cone over which its edge is soft, 0 to 1", LightValue::Number,
      Vec3d(0.15), 0, 1}},
    model};

Light make_spot(const Vec3d& position, const Vec3d& direction, double angle, double blend, const Vec3d& intensity,
                std::string name)
{
    return Light(spot_kind, std::move(name), position, {intensity, direction, Vec3d(angle), Vec3d(blend)});
}

}  // namespace vdbcloud
