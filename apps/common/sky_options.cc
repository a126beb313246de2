#include "sky_options.h"

#include "options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/number_range.h"

#include <cmath>

namespace vdbcloud::app {

void declare_sky_shape(App& app, SkyOptions& o, const std::string& group)
{
    o.option.zenith = app.add_rgb("--sky-zenith", o.zenith,
                                  "radiance of the sky straight up, one number or r,g,b; without it a clear blue day")
                          ->check(nonnegative)
                          ->default_str("")
                          ->scene("sky")
                          ->group(group);
    o.option.horizon =
        app.add_rgb("--sky-horizon", o.horizon, "radiance of the sky along the horizon, one number or r,g,b")
            ->check(nonnegative)
            ->default_str("")
            ->scene("sky")
            ->group(group);
    o.option.ground = app.add_rgb("--sky-ground", o.ground, "radiance of the ground straight down, one number or r,g,b")
                          ->check(nonnegative)
                          ->default_str("")
                          ->scene("sky")
                          ->group(group);
    o.option.haze =
        app.add_option("--sky-haze", o.haze, "how narrow the bright band at the horizon is; larger is narrower")
            ->check(nonnegative)
            ->scene("sky")
            ->group(group);
}

bool sky_asked(const SkyOptions& o)
{
    return o.option.zenith.given() || o.option.horizon.given() || o.option.ground.given();
}

Sky with_asked(const SkyOptions& o, Sky sky)
{
    if (o.option.zenith.given()) sky.zenith = o.zenith;
    if (o.option.horizon.given()) sky.horizon = o.horizon;
    if (o.option.ground.given()) sky.ground = o.ground;
    if (o.option.haze.given()) sky.haze = o.haze;
    return sky;
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
