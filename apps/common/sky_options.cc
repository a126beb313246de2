#include "sky_options.h"

#include "formed.h"
#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/number_range.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

/// The sky by its --sky, before single values of it.
Sky base_of(const SkyOptions& o, const LightOptions& of_lights, const std::vector<Light>& lights, const Vec3d& up)
{
    if (o.environment->asked())
        return environment_sky(o.environment->panorama(), o.environment->turn, o.environment->gain, up);
    if (!o.sky.empty() && o.sky != "day" && o.sky != "preetham") {
        GradientSky sky;
        sky.zenith = sky.horizon = sky.ground = colour_asked("--sky", o.sky, "day, preetham, one number or r,g,b");
        sky.up = up;
        return sky;
    }
    const Vec3d irradiance = brightest_sun(lights);
    if (!o.sky.empty() && irradiance == Vec3d(0.0))
        throw UsageError("--sky " + o.sky +
                         " has no effect without a sun that shines: its brightness follows from the suns'; add --sun");
    if (o.sky != "preetham") return GradientSky::clear_day(irradiance, up);
    const auto dimmer = [](const Light& a, const Light& b) {
        const auto sum = [](const Light& l) {
            return l.kind().at_infinity ? l.strength()[0] + l.strength()[1] + l.strength()[2] : -1;
        };
        return sum(a) < sum(b);
    };
    const Light& sun = *std::max_element(lights.begin(), lights.end(), dimmer);
    return preetham_sky(sun.place(), sun.strength(), of_lights.turbidity, up,
                        o.option.ground.given() ? std::optional<Vec3d>(o.ground) : std::nullopt);
}

}  // namespace

void declare_sky(App& app, SkyOptions& o, LightOptions& lights, const std::string& group, const std::string& otherwise)
{
    o.option.sky =
        app.add_option("--sky", o.sky,
                       "preetham: the clear sky about the brightest sun, of --turbidity; day: a clear sky that depends "
                       "on height alone, whose brightness follows from the suns; or the radiance of a uniform sky, one "
                       "number or r,g,b; without it " +
                           otherwise)
            ->check(formed("day, preetham, one number or r,g,b",
                           [](const std::string& text) {
                               return text.empty() || text == "day" || text == "preetham" || is_colour(text);
                           }))
            ->not_with([&lights] { return lights.environment.asked(); }, "--environment")
            ->scene("sky", "model")
            ->group(group);
    const auto of_gradient = [&](const Option& option) {
        return option
            .not_with([&o] { return o.sky == "preetham" || o.environment->asked(); }, "--sky preetham or --environment")
            .scene("sky")
            .group(group);
    };
    o.option.zenith = of_gradient(app.add_rgb("--sky-zenith", o.zenith,
                                              "radiance of the sky straight up, one number or r,g,b; without it a "
                                              "clear blue day"))
                          ->check(nonnegative)
                          ->default_str("");
    o.option.horizon = of_gradient(app.add_rgb("--sky-horizon", o.horizon,
                                               "radiance of the sky along the horizon, one number or r,g,b"))
                           ->check(nonnegative)
                           ->default_str("");
    o.option.ground =
        app.add_rgb("--sky-ground", o.ground,
                    "radiance of the ground straight down, one number or r,g,b; without it that of --sky preetham is a "
                    "ground of albedo 0.2")
            ->check(nonnegative)
            ->default_str("")
            ->not_with([&lights] { return lights.environment.asked(); }, "--environment")
            ->scene("sky")
            ->group(group);
    o.option.haze = of_gradient(app.add_option("--sky-haze", o.haze,
                                               "how narrow the bright band at the horizon is; larger is narrower"))
                        ->check(nonnegative);
    o.environment = &lights.environment;
    lights.sky_has_turbidity = [&o] { return o.sky == "preetham"; };
}

bool shape_asked(const SkyOptions& o)
{
    return o.option.zenith.given() || o.option.horizon.given() || o.option.ground.given();
}

bool sky_asked(const SkyOptions& o) { return o.option.sky.given() || shape_asked(o) || o.environment->asked(); }

Sky sky_of(const SkyOptions& o, const LightOptions& of_lights, const std::vector<Light>& lights, const Vec3d& up,
           const std::optional<Sky>& otherwise)
{
    try {
        const Sky base =
            o.sky.empty() && !o.environment->asked() && otherwise && (otherwise->gradient() || !shape_asked(o))
                ? *otherwise
                : base_of(o, of_lights, lights, up);
        auto sky = base.gradient();
        if (!sky) return base;
        if (o.option.zenith.given()) sky->zenith = o.zenith;
        if (o.option.horizon.given()) sky->horizon = o.horizon;
        if (o.option.ground.given()) sky->ground = o.ground;
        if (o.option.haze.given()) sky->haze = o.haze;
        return *sky;
    } catch (const InputError& e) {
        throw UsageError(std::string("--sky: ") + e.what());
    }
}

Sky lighting_sky(const SkyOptions& o, const LightOptions& of_lights, const std::vector<Light>& lights, const Vec3d& up)
{
    GradientSky none;
    none.up = up;
    return sky_asked(o) ? sky_of(o, of_lights, lights, up) : Sky(none);
}

Vec3d colour_asked(const std::string& option, const std::string& text, const std::string& expected)
{
    const auto c = numbers(text);
    if (!c || (c->size() != 1 && c->size() != 3))
        throw UsageError(option + " " + printable(text) + ": expected " + expected);
    for (const double x : *c)
        if (std::abs(x) > largest_number)
            throw UsageError(option + " " + printable(text) + ": expected numbers of a size up to " +
                             shortest(largest_number));
    return c->size() == 1 ? Vec3d((*c)[0]) : Vec3d((*c)[0], (*c)[1], (*c)[2]);
}

}  // namespace vdbcloud::app
