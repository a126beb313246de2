// The sun: light from infinity, of one direction or from a disc about it.
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scene/light_kinds.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

class Sun : public LightModel {
public:
    Sun(const Vec3d& to_light, double angular_diameter) : to_(to_light.unit()), diameter_(angular_diameter) {}

    Sight towards(const Vec3d&) const override { return {to_, std::numeric_limits<double>::infinity()}; }
    double irradiance(const Vec3d&) const override { return 1; }
    double mean_irradiance(const WorldRay&, double, double) const override { return 1; }
    std::optional<Vec3d> common_direction() const override { return to_; }

    double power_through(const std::array<Vec3d, 4>& corner, const Vec3d& normal) const override
    {
        const double area = (corner[1] - corner[0]).cross(corner[3] - corner[0]).length();
        return -to_.dot(normal.unit()) * area;
    }

    Sight sample(const Vec3d& x, double u, double v) const override
    {
        return diameter_ > 0 ? Sight{of_disc(u, 2 * pi * v), std::numeric_limits<double>::infinity()} : towards(x);
    }

    /// A sunflower spiral over the disc: equal solid angles, no randomness.
    std::vector<std::shared_ptr<const LightModel>> parts(int count) const override
    {
        std::vector<std::shared_ptr<const LightModel>> parts;
        if (!(diameter_ > 0) || count < 2) return parts;
        for (int n = 0; n < count; ++n)
            parts.push_back(std::make_shared<Sun>(of_disc((n + 0.5) / count, n * golden_angle), 0));
        return parts;
    }

private:
    /// The direction at azimuth `turn` of the circle about the disc's centre that holds a share u of the disc.
    Vec3d of_disc(double u, double turn) const
    {
        const Vec3d& z = to_;
        const Vec3d x = (std::abs(z[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(z).unit(), y = z.cross(x);
        const double cos_edge = std::cos(diameter_ / 2 * pi / 180);
        const double c = 1 - (1 - cos_edge) * u, s = std::sqrt(std::max(0.0, 1 - c * c));
        return c * z + s * (std::cos(turn) * x + std::sin(turn) * y);
    }

    Vec3d to_;
    double diameter_;  // [degrees]
};

std::shared_ptr<const LightModel> model(const Vec3d& place, const std::vector<Vec3d>& parameters)
{
    return std::make_shared<Sun>(place, parameters[1][0]);
}

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

const LightKind sun_kind{"directional",
                         "sun",
                         "direction",
                         schema::light_to,
                         "direction towards the sun, x,y,z",
                         "towards",
                         true,
                         {{"irradiance", schema::light_irradiance, "irradiance across the beam, one number or r,g,b",
                           LightValue::Colour, Vec3d(1), 0, infinity},
                          {"diameter", schema::light_angular_diameter, "angular diameter of the disc [degrees]",
                           LightValue::Number, Vec3d(0), 0, 180}},
                         model};

Light make_sun(const Vec3d& to_light, const Vec3d& irradiance, double angular_diameter, std::string name)
{
    return Light(sun_kind, std::move(name), to_light, {irradiance, Vec3d(angular_diameter)});
}

}  // namespace vdbcloud
