#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud {

Sky Sky::constant(const Vec3d& radiance)
{
    Sky sky;
    sky.zenith = sky.horizon = sky.ground = radiance;
    return sky;
}

Sky Sky::clear_day(const Vec3d& sun_irradiance, const Vec3d& up)
{
    Sky sky;
    sky.zenith = sun_irradiance * Vec3d(0.0038, 0.0095, 0.0245);
    sky.horizon = sun_irradiance * Vec3d(0.0185, 0.0275, 0.0405);
    sky.ground = sun_irradiance * Vec3d(0.017, 0.0235, 0.032);
    sky.up = up / up.length();
    return sky;
}

Vec3d Sky::radiance(const Vec3d& direction) const
{
    const double s = std::clamp(direction.dot(up), -1.0, 1.0);
    const Vec3d& far = s >= 0 ? zenith : ground;
    return far + (horizon - far) * std::pow(1 - std::abs(s), haze);
}

Vec3d Sky::mean_radiance() const
{
    // int_0^1 (1 - s)^haze ds = 1/(haze + 1) is the horizon's share of each half.
    const double share = 1 / (haze + 1);
    return 0.5 * ((1 - share) * (zenith + ground) + 2 * share * horizon);
}

void check(const Sky& sky)
{
    for (const auto& [name, colour] :
         {std::pair{"zenith", sky.zenith}, {"horizon", sky.horizon}, {"ground", sky.ground}})
        for (int c = 0; c < 3; ++c)
            if (!(colour[c] >= 0 && std::isfinite(colour[c]))) {
                std::ostringstream what;
                what << "sky's " << name << " " << colour << ": expected finite radiances, 0 or above";
                throw InputError(what.str());
            }
    if (!(sky.haze >= 0 && std::isfinite(sky.haze)))
        throw InputError("sky's haze " + std::to_string(sky.haze) + ": expected a finite number, 0 or above");
    if (!(sky.up.length() > 0 && std::isfinite(sky.up.length()))) throw InputError("sky's up has no length");
}

}  // namespace vdbcloud
