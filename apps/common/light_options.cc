#include "light_options.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/scene/atmosphere.h"
#include "vdbcloud/scene/camera.h"
#include "vdbcloud/scene/colour.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

/// The k-th of the values given for some lights: its own, the only one for all, or `otherwise` if there is none.
template<typename T>
T of(const std::vector<T>& values, size_t k, const T& otherwise)
{
    return values.empty() ? otherwise : values.size() == 1 ? values[0] : values[k];
}

void check_count(const std::string& option, size_t values, const std::string& light_option, size_t lights)
{
    if (values == 0 || values == lights || (values == 1 && lights > 0)) return;
    throw UsageError(option + " is given " + std::to_string(values) + " times, " + light_option + " " +
                     std::to_string(lights) + " times: expected one for all or one for each");
}

std::string option_of(const LightKind& kind) { return "--" + std::string(kind.name); }

std::string option_of(const LightKind& kind, const LightParameter& parameter)
{
    return option_of(kind) + "-" + parameter.name;
}

std::string numbered(const char* name, size_t k) { return k == 0 ? name : name + std::to_string(k + 1); }

/// A sun's irradiance under a clear atmosphere.
Vec3d through_atmosphere(const Vec3d& irradiance, const Vec3d& to_sun, const Vec3d& up, double turbidity)
{
    const double sine = to_sun.unit().dot(up.unit());
    if (sine < 0)
        throw UsageError("--sun " + shortest(to_sun) +
                         " is below the horizon: --sun-colour atmosphere expects a sun above it");
    const double height = std::asin(std::min(sine, 1.0)) * 180 / pi;
    return irradiance * sunlight(height, turbidity) / unit_of_light();
}

}  // namespace

void declare_lights(App& app, LightOptions& o)
{
    const char* group = "Lights";
    const auto& kinds = light_kinds();
    o.kinds.resize(kinds.size());
    for (size_t k = 0; k < kinds.size(); ++k) {
        const LightKind& kind = *kinds[k];
        LightOptions::OfKind& of = o.kinds[k];
        of.colours.resize(kind.parameters.size());
        of.numbers.resize(kind.parameters.size());
        const Option place =
            app.add_vec3s(option_of(kind), of.places, kind.place_help + std::string("; repeat for another"))
                ->scene("lights")
                ->group(group);
        for (size_t p = 0; p < kind.parameters.size(); ++p) {
            const LightParameter& parameter = kind.parameters[p];
            const bool direction = parameter.type == LightValue::Direction;
            const std::string otherwise = direction ? shortest(parameter.otherwise) : shortest(parameter.otherwise[0]);
            const std::string option = option_of(kind, parameter),
                              help = parameter.help + std::string("; one for all ") + option_of(kind) +
                                     ", or one for each [" + otherwise + "]";
            const auto limits = std::isfinite(parameter.most) ? within(parameter.least, parameter.most) : nonnegative;
            const Option declared = direction ? app.add_vec3s(option, of.colours[p], help)
                                    : parameter.type == LightValue::Colour
                                        ? app.add_rgbs(option, of.colours[p], help)->check(limits)
                                        : app.add_option(option, of.numbers[p], help)->check(limits);
            declared->needs(place)->scene_light(place, otherwise)->group(group);
        }
        if (kind.at_infinity)
            app.add_choice<bool>(
                   "--sun-colour", o.by_atmosphere, {{"given", false}, {"atmosphere", true}},
                   "atmosphere: a clear atmosphere of --turbidity dims and reddens each sun by its height; "
                   "--sun-irradiance is then that above the atmosphere. given: --sun-irradiance is that at "
                   "the medium")
                ->needs(place)
                ->scene("sky", "sun-colour")
                ->group(group);
    }
    app.add_option("--turbidity", o.turbidity,
                   "haze of the atmosphere of --sun-colour atmosphere and of --sky preetham: optical depth of air with "
                   "haze over that of air alone; 2 a very clear day, 3 clear, 6 hazy, 10 thick haze")
        ->check(within(least_turbidity, most_turbidity))
        ->only_with([&o] { return o.by_atmosphere || (o.sky_has_turbidity && o.sky_has_turbidity()); },
                    "--sun-colour atmosphere or --sky preetham")
        ->scene("sky", "turbidity")
        ->group(group);
    declare_environment(app, o.environment);
}

std::vector<Light> lights_asked(const LightOptions& o, const Vec3d& up)
{
    std::vector<Light> lights;
    for (size_t k = 0; k < o.kinds.size(); ++k) {
        const LightKind& kind = *light_kinds()[k];
        const LightOptions::OfKind& given = o.kinds[k];
        for (size_t p = 0; p < kind.parameters.size(); ++p)
            check_count(option_of(kind, kind.parameters[p]), given.colours[p].size() + given.numbers[p].size(),
                        option_of(kind), given.places.size());
        for (size_t n = 0; n < given.places.size(); ++n) {
            if (kind.at_infinity && !(given.places[n].length() > 0))
                throw UsageError(option_of(kind) + " " + shortest(given.places[n]) + ": expected a direction, not 0");
            std::vector<Vec3d> values;
            for (size_t p = 0; p < kind.parameters.size(); ++p) {
                const LightParameter& parameter = kind.parameters[p];
                values.push_back(parameter.type == LightValue::Number
                                     ? Vec3d(of(given.numbers[p], n, parameter.otherwise[0]))
                                     : of(given.colours[p], n, parameter.otherwise));
            }
            if (kind.at_infinity && o.by_atmosphere)
                values[0] = through_atmosphere(values[0], given.places[n], up, o.turbidity);
            lights.emplace_back(kind, numbered(kind.name, n), given.places[n], std::move(values));
        }
    }
    for (Light& sun : o.environment.suns(up)) lights.push_back(std::move(sun));
    return lights;
}

Light automatic_sun(const Vec3d& up) { return make_sun(default_sun_direction(up), Vec3d(4 * pi)); }

void tell_darkness(App& app, const std::vector<Light>& lights, bool other)
{
    const auto dark = [](const Light& light) { return light.strength() == Vec3d(0.0); };
    if (other || !std::all_of(lights.begin(), lights.end(), dark)) return;
    std::string names;
    for (const Light& light : lights) names += (names.empty() ? "" : ", ") + light.name;
    app.warnings()("nothing lights the medium" + (names.empty() ? "" : ", since the strength of " + names + " is 0") +
                   ": expected a sun, a lamp, a sky or emission brighter than 0");
}

std::string described(const Light& light)
{
    std::string text = light.name + " " + light.kind().preposition + " " + brief(light.place());
    for (size_t p = 1; p < light.parameters().size(); ++p)
        if (light.kind().parameters[p].type == LightValue::Direction)
            text += std::string(" of ") + light.kind().parameters[p].name + " " + brief(light.parameters()[p]);
        else if (const double value = light.parameters()[p][0]; value != 0)
            text += std::string(" of ") + light.kind().parameters[p].name + " " + brief(value);
    return text;
}

}  // namespace vdbcloud::app
