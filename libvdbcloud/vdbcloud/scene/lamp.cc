// The lamp: a point that shines alike in all directions.
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scene/light_kinds.h"
#include "vdbcloud/scene/solid_angle.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

class Lamp : public LightModel {
public:
    explicit Lamp(const Vec3d& position) : position_(position) {}

    Sight towards(const Vec3d& x) const override
    {
        const Vec3d to = position_ - x;
        const double r = to.length();
        return {r > 0 ? to / r : Vec3d(0.0), r};
    }

    double irradiance(const Vec3d& x) const override { return 1 / (position_ - x).lengthSqr(); }

    /// The mean of 1 / (b^2 + (t - foot)^2), b the ray's distance from the lamp; b no less than a hundredth of the
    /// piece, so that a ray through the lamp itself stays finite.
    double mean_irradiance(const WorldRay& ray, double t0, double t1) const override
    {
        const double foot = (position_ - ray.origin).dot(ray.direction);
        const double b = std::max((position_ - ray.at(foot)).length(), 0.01 * (t1 - t0));
        return (std::atan2(t1 - foot, b) - std::atan2(t0 - foot, b)) / (b * (t1 - t0));
    }

    /// By the exact solid angle. Which side of the face the lamp is on decides the sign.
    double power_through(const std::array<Vec3d, 4>& corner, const Vec3d& normal) const override
    {
        std::array<Vec3d, 4> from;
        for (int k = 0; k < 4; ++k) from[k] = corner[k] - position_;
        return std::copysign(solid_angle(from), (from[0] + from[2]).dot(normal));
    }

    std::optional<PointSource> source() const override { return PointSource{position_, 4 * pi}; }

private:
    Vec3d position_;
};

std::shared_ptr<const LightModel> model(const Vec3d& place, const std::vector<Vec3d>&)
{
    return std::make_shared<Lamp>(place);
}

}  // namespace

const LightKind lamp_kind{"point",
                          "lamp",
                          "position",
                          schema::light_position,
                          "position of a point light [world unit], x,y,z",
                          "at",
                          false,
                          // The key says irradiance for every kind; files keep it.
                          {{"intensity", schema::light_irradiance, "power per steradian, one number or r,g,b",
                            LightValue::Colour, Vec3d(1), 0, std::numeric_limits<double>::infinity()}},
                          model};

Light make_lamp(const Vec3d& position, const Vec3d& intensity, std::string name)
{
    return Light(lamp_kind, std::move(name), position, {intensity});
}

}  // namespace vdbcloud
