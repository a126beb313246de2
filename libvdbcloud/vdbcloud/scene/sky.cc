#include "vdbcloud/scene/sky.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/scatter_schema.h"

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
    if (s < 0 && ends_at_horizon) return Vec3d(0.0);
    const Vec3d& far = s >= 0 ? zenith : ground;
    return far + (horizon - far) * std::pow(1 - std::abs(s), haze);
}

Vec3d Sky::mean_inflow(const Vec3d& normal) const
{
    // At height angle a the cosine to the normal is A + B cos(azimuth); its positive part has a closed form around the
    // circle.
    const double along = std::clamp(normal.dot(up), -1.0, 1.0), across = std::sqrt(1 - along * along),
                 kink = std::asin(across);
    const auto around = [&](double a) {
        const double constant = along * std::sin(a), swing = across * std::cos(a);
        if (constant >= swing) return 2 * pi * constant;
        if (constant <= -swing) return 0.0;
        const double open = std::acos(-constant / swing);
        return 2 * (constant * open + swing * std::sin(open));
    };
    const double ends[] = {-pi / 2, -kink, 0, kink, pi / 2};
    constexpr int parts = 256;
    Vec3d sum(0.0);
    double weights = 0;
    for (int piece = 0; piece < 4; ++piece) {
        const double step = (ends[piece + 1] - ends[piece]) / parts;
        for (int k = 0; k < parts; ++k) {
            const double a = ends[piece] + (k + 0.5) * step, weight = step * std::cos(a) * around(a);
            const double s = std::sin(a);
            weights += weight;
            if (s < 0 && ends_at_horizon) continue;
            const Vec3d& far = s >= 0 ? zenith : ground;
            sum += weight * (far + (horizon - far) * std::pow(1 - std::abs(s), haze));
        }
    }
    return sum / weights;
}

Vec3d Sky::mean_radiance() const
{
    // int_0^1 (1 - s)^haze ds = 1/(haze + 1) is the horizon's share of each half.
    const double share = 1 / (haze + 1);
    return 0.5 * ((1 - share) * (zenith + ground) + 2 * share * horizon);
}

bool operator==(const Sky& a, const Sky& b)
{
    return a.zenith == b.zenith && a.horizon == b.horizon && a.ground == b.ground && a.haze == b.haze && a.up == b.up &&
           a.ends_at_horizon == b.ends_at_horizon;
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
    if (!(sky.up.length() > 0 && std::isfinite(sky.up.length()))) {
        std::ostringstream what;
        what << "sky's up " << sky.up << ": expected a vector with a length above 0";
        throw InputError(what.str());
    }
}

void write_sky(MetaMap& to, const Sky& sky)
{
    set_vector(to, schema::lit_sky, sky.zenith);
    set_vector(to, schema::lit_sky_horizon, sky.horizon);
    set_vector(to, schema::lit_sky_ground, sky.ground);
    set_number(to, schema::lit_sky_haze, sky.haze);
    set_vector(to, schema::lit_sky_up, sky.up);
}

std::optional<Sky> read_sky(const MetaMap& from)
{
    Sky sky;
    sky.zenith = get_vector(from, schema::lit_sky, Vec3d(0.0));
    sky.horizon = get_vector(from, schema::lit_sky_horizon, sky.zenith);
    sky.ground = get_vector(from, schema::lit_sky_ground, sky.zenith);
    sky.haze = get_number(from, schema::lit_sky_haze, sky.haze);
    sky.up = get_vector(from, schema::lit_sky_up, sky.up);
    check(sky);
    if (sky.dark()) return std::nullopt;
    sky.up.normalize();
    return sky;
}

}  // namespace vdbcloud
