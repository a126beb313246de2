// The gradient: a sky whose radiance changes with height alone; a constant background is one.
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/scene/sky_kinds.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

class Gradient : public SkyModel {
public:
    Gradient(const GradientSky& sky, bool ends_at_horizon) : sky_(sky), ends_at_horizon_(ends_at_horizon) {}

    Vec3d radiance(const Vec3d& direction) const override
    {
        return of_height(std::clamp(direction.dot(sky_.up), -1.0, 1.0));
    }

    /// By quadrature in height, exact around it; relative error below 1e-5.
    Vec3d mean_inflow(const Vec3d& normal) const override;

    std::vector<Vec3d> tones() const override { return {sky_.zenith, sky_.horizon, sky_.ground}; }

    bool uniform() const override
    {
        return sky_.zenith == sky_.horizon && sky_.horizon == sky_.ground && !ends_at_horizon_;
    }

private:
    Vec3d of_height(double s) const
    {
        if (s < 0 && ends_at_horizon_) return Vec3d(0.0);
        const Vec3d& far = s >= 0 ? sky_.zenith : sky_.ground;
        return far + (sky_.horizon - far) * std::pow(1 - std::abs(s), sky_.haze);
    }

    GradientSky sky_;
    bool ends_at_horizon_;
};

Vec3d Gradient::mean_inflow(const Vec3d& normal) const
{
    // At height angle a the cosine to the normal is A + B cos(azimuth); its positive part has a closed form around the
    // circle.
    const double along = std::clamp(normal.dot(sky_.up), -1.0, 1.0), across = std::sqrt(1 - along * along),
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
            weights += weight;
            sum += weight * of_height(std::sin(a));
        }
    }
    return sum / weights;
}

std::shared_ptr<const SkyModel> model(const SkyDescription& sky)
{
    const auto& p = sky.parameters;
    return std::make_shared<Gradient>(GradientSky{p[0], p[1], p[2], p[3][0], sky.up}, sky.ends_at_horizon);
}

constexpr double infinity = std::numeric_limits<double>::infinity(), first = std::numeric_limits<double>::quiet_NaN();

}  // namespace

const SkyKind gradient_kind{"gradient",
                            {{"zenith", schema::lit_sky, true, 0, 0, infinity},
                             {"horizon", schema::lit_sky_horizon, true, first, 0, infinity},
                             {"ground", schema::lit_sky_ground, true, first, 0, infinity},
                             {"haze", schema::lit_sky_haze, false, 4, 0, infinity}},
                            model};

Sky::Sky(const GradientSky& sky) : Sky(gradient_kind, sky.up, {sky.zenith, sky.horizon, sky.ground, Vec3d(sky.haze)}) {}

std::optional<GradientSky> Sky::gradient() const
{
    if (kind_ != &gradient_kind) return std::nullopt;
    const auto& p = description_.parameters;
    return GradientSky{p[0], p[1], p[2], p[3][0], up()};
}

GradientSky GradientSky::clear_day(const Vec3d& sun_irradiance, const Vec3d& up)
{
    GradientSky sky;
    sky.zenith = sun_irradiance * Vec3d(0.0168, 0.0420, 0.1083);
    sky.horizon = sun_irradiance * Vec3d(0.0818, 0.1216, 0.1790);
    sky.ground = sun_irradiance * Vec3d(0.0405, 0.0560, 0.0762);
    sky.up = up;
    return sky;
}

}  // namespace vdbcloud
