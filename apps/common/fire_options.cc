#include "fire_options.h"

#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/density.h"
#include "vdbcloud/grid/emission.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scene/blackbody.h"

#include <algorithm>
#include <limits>

namespace vdbcloud::app {

namespace {

constexpr double least_kelvin = 100;   // a greatest value below this is no temperature of a fire in kelvin
constexpr double guessed_heat = 2000;  // [K], of the greatest value then

double greatest(const FloatGrid& grid)
{
    double most = -std::numeric_limits<double>::max();
    for (auto v = grid.cbeginValueOn(); v; ++v) most = std::max(most, double(*v));
    return most;
}

/// What the values of a grid are in kelvin, where nothing says so.
double guessed_scale(App& app, const GridFile& file, const GridBase& grid, double most, const FireOptions& o)
{
    if (!(most > 0 && most < least_kelvin)) return 1;
    if (*o.guess) return **o.guess;
    *o.guess = guessed_heat / most;
    app.say(printable(file.path, 4096) + ": grid '" + printable(grid.getName()) +
            "' has no unit, and its greatest value is " + brief(most) + ": taken as " + brief(guessed_heat) +
            " K; --temperature-scale " + brief(**o.guess) +
            " says so for every frame, and --fire-intensity 0 that nothing glows");
    return **o.guess;
}

/// Sets the scale, and keeps it in the metadata of the file's grid.
void choose_scale(App& app, const GridFile& file, GridBase& grid, const FireOptions& o, Fire& fire)
{
    const bool asked = o.option.scale.given() || o.option.offset.given();
    fire.scale = get_number(grid, schema::kelvin_scale, 1);
    fire.offset = get_number(grid, schema::kelvin_offset, 0);
    fire.intensity = get_number(grid, schema::fire_intensity, 1);
    if (!asked && !says_kelvin(grid)) fire.scale = guessed_scale(app, file, grid, greatest(*fire.heat()), o);
    if (o.option.scale.given()) fire.scale = o.scale;
    if (o.option.offset.given()) fire.offset = o.offset;
    if (o.option.intensity.given()) fire.intensity = o.intensity;
    if (fire.scale != 1 || asked) set_number(grid, schema::kelvin_scale, fire.scale);
    if (fire.offset != 0 || asked) set_number(grid, schema::kelvin_offset, fire.offset);
    if (o.option.intensity.given()) set_number(grid, schema::fire_intensity, fire.intensity);
}

}  // namespace

void declare_fire(App& app, FireOptions& o, const std::string& group)
{
    const auto option = [&](const char* name, double& value, const std::string& help) {
        return app.add_option(name, value, help)->default_str("")->scene("medium")->group(group);
    };
    o.option.scale = option("--temperature-scale", o.scale,
                            "kelvin of a temperature of 1; without it the file's, else 1, or a guess where values are "
                            "below 100 and have no unit")
                         ->check(within(-1e9, 1e9));
    o.option.offset =
        option("--temperature-offset", o.offset, "kelvin of a temperature of 0; without it the file's, else 0")
            ->check(within(-1e9, 1e9));
    o.option.intensity =
        option("--fire-intensity", o.intensity,
               "what the light of hot matter is multiplied with; without it the file's, else 1: that of "
               "a black body")
            ->check(nonnegative);
    o.option.flame =
        option("--flame-absorption", o.flame,
               "absorption of the luminous soot at a flame of 1 [1/world unit], which shines and hides "
               "nothing; without it the file's, else the extinction at density 1, or 0 if flame has a unit")
            ->check(nonnegative);
}

void check_fire(const FireOptions& o, const std::vector<GridFile>& files)
{
    const auto any = [&](const char* role) {
        return std::any_of(files.begin(), files.end(),
                           [&](const GridFile& file) { return bool(aliased_grid(file, role)); });
    };
    const bool flame = any(schema::flame), heat = flame || any(schema::temperature);
    for (const Option& option : {o.option.scale, o.option.offset, o.option.intensity})
        option.check_effect(heat, "an input with a grid temperature or flame");
    o.option.flame.check_effect(flame, "an input with a grid flame");
}

Fire fire_of(App& app, const GridFile& file, const FireOptions& o)
{
    Fire fire;
    fire.temperature = scalar_of(file, schema::temperature, app.warnings());
    fire.flame = scalar_of(file, schema::flame, app.warnings());
    if (!fire.heat()) return fire;
    const GridBasePtr flame = aliased_grid(file, schema::flame);
    const GridBasePtr heat = fire.temperature ? aliased_grid(file, schema::temperature) : flame;
    choose_scale(app, file, *heat, o, fire);
    if (const double most = hottest(fire); most < coldest_light) {
        for (const Option& option : {o.option.scale, o.option.offset, o.option.intensity, o.option.flame})
            if (option.given() && !option.by_scene())
                app.say(printable(file.path, 4096) + ": " + option.name() + " changes nothing: the hottest place has " +
                        brief(most) + " K, and what is colder than " + brief(coldest_light) + " K does not glow");
        return {};
    }
    app.uses(heat->getName());
    if (!fire.flame) return fire;
    app.uses(flame->getName());
    // An amount of soot has no unit; a rate of burning has one, and does not shine by itself.
    const bool rate = has_meta(*flame, schema::unit);
    fire.flame_absorption = get_number(*flame, schema::flame_absorption, rate ? 0 : -1);
    if (o.option.flame.given()) {
        fire.flame_absorption = o.flame;
        set_number(*flame, schema::flame_absorption, o.flame);
    }
    return fire;
}

Vec3SGridPtr emission_of(App& app, const GridFile& file, const Fire& fire, const FloatGrid& density,
                         const Medium& medium, const Vec3SGrid* tint)
{
    const Vec3SGridPtr given = vector_grid(app, file, find_grid(file, schema::emission));
    return fire.heat() ? sum_of_emission(given, thermal_emission(density, medium, tint, fire)) : given;
}

}  // namespace vdbcloud::app
