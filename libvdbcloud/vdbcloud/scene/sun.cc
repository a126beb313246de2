// The sun: light from infinity, of one direction or from a disc about it.
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scene/light_kinds.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

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

    /// A sunflower spiral over the disc: equal solid angles, no randomness.
    std::vector<std::shared_ptr<const LightModel>> parts(int count) const override
    {
        std::vector<std::shared_ptr<const LightModel>> parts;
        if (!(diameter_ > 0) || count < 2) return parts;
        const Vec3d& z = to_;
        const Vec3d x = (std::abs(z[0]) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(z).unit(), y = z.cross(x);
        const double cos_edge = std::cos(diameter_ / 2 * pi / 180);
        for (int n = 0; n < count; ++n) {
            const double c = 1 - (1 - cos_edge) * (n + 0.5) / count, s = std::sqrt(1 - c * c);
            const double turn = n * golden_angle;
            parts.push_back(std::make_shared<Sun>(c * z + s * (std::cos(turn) * x + std::sin(turn) * y), 0));
        }
        return parts;
    }

private:
    Vec3d to_;
    double diameter_;  // [degrees]
};

std::shared_ptr<const LightModel> model(const Vec3d& place, const std::vector<Vec3d>& parameters)
{
    return std::make_shared<Sun>(place, parameters[1][0]);
}

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

const LightKind sun_kind{
    "directional",
    "sun",
    "direction",
    schema::light_to,
    "direction towards the sun, x,y,z",
    "towards",
    true,
    {{"irradiance", schema::light_irradiance, "irradiance across the beam, one number or r,g,b", true, 1, 0, infinity},
     {"diameter", schema::light_angular_diameter, "angular diameter of the disc [degrees]", false, 0, 0, 180}},
    model};

Light make_sun(const Vec3d& to_light, const Vec3d& irradiance, double angular_diameter, std::string name)
{
    return Light(sun_kind, std::move(name), to_light, {irradiance, Vec3d(angular_diameter)});
}

}  // namespace vdbcloud
