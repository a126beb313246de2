#include "sky_options.h"

#include "options.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::app {

void declare_sky_shape(App& app, SkyOptions& o, const std::string& group)
{
    app.add_rgb("--sky-zenith", o.zenith, "radiance straight up; without it a clear blue day")
        ->check(nonnegative)
        ->default_str("")
        ->group(group);
    app.add_rgb("--sky-horizon", o.horizon, "radiance along the horizon")
        ->check(nonnegative)
        ->default_str("")
        ->group(group);
    app.add_rgb("--sky-ground", o.ground, "radiance straight down")->check(nonnegative)->default_str("")->group(group);
    app.add_option("--sky-haze", o.haze, "how narrow the horizon's band is")->check(nonnegative)->group(group);
}

bool sky_asked(const App& app)
{
    return app.given("--sky-zenith") || app.given("--sky-horizon") || app.given("--sky-ground");
}

Sky with_asked(const App& app, const SkyOptions& o, Sky sky)
{
    if (app.given("--sky-zenith")) sky.zenith = o.zenith;
    if (app.given("--sky-horizon")) sky.horizon = o.horizon;
    if (app.given("--sky-ground")) sky.ground = o.ground;
    if (app.given("--sky-haze")) sky.haze = o.haze;
    return sky;
}

Vec3d colour_asked(const std::string& option, const std::string& text, const std::string& expected)
{
    const auto c = numbers(text);
    if (!c || (c->size() != 1 && c->size() != 3))
        throw UsageError(option + " " + printable(text) + ": expected " + expected);
    return c->size() == 1 ? Vec3d((*c)[0]) : Vec3d((*c)[0], (*c)[1], (*c)[2]);
}

}  // namespace vdbcloud::app
