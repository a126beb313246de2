#include "light_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/scene/camera.h"

namespace vdbcloud::app {

namespace {

constexpr double four_pi = 12.566370614359172;

/// The k-th of the values given for n lights: its own, the only one for all, or `otherwise` if there is none.
template<typename T>
T of(const std::vector<T>& values, size_t k, const T& otherwise)
{
    return values.empty() ? otherwise : values.size() == 1 ? values[0] : values[k];
}

template<typename T>
void check_count(const char* option, const std::vector<T>& values, const char* light_option, size_t lights)
{
    if (values.empty() || values.size() == lights || (values.size() == 1 && lights > 0)) return;
    throw UsageError(std::string(option) + " is given " + std::to_string(values.size()) + " times, " + light_option +
                     " " + std::to_string(lights) + " times: expected one for all or one for each");
}

std::string numbered(const char* name, size_t k) { return k == 0 ? name : name + std::to_string(k + 1); }

}  // namespace

void declare_lights(App& app, LightOptions& o)
{
    const char* group = "Lights";
    const Option sun =
        app.add_vec3s("--sun", o.suns, "direction TOWARDS a distant light, x,y,z; again for another")->group(group);
    app.add_rgbs("--sun-irradiance", o.irradiances,
                 "one number or r,g,b, perpendicular to its beam; one for all suns, or one for each [1,1,1]")
        ->check(nonnegative)
        ->needs(sun)
        ->group(group);
    app.add_option("--sun-diameter", o.diameters, "angular diameter [degrees]; one for all suns, or one for each [0]")
        ->check(within(0, 180))
        ->needs(sun)
        ->group(group);
    const Option lamp =
        app.add_vec3s("--lamp", o.lamps, "position of a point light, x,y,z; again for another")->group(group);
    app.add_rgbs("--lamp-intensity", o.intensities,
                 "one number or r,g,b, power per steradian; one for all lamps, or one for each [1,1,1]")
        ->check(nonnegative)
        ->needs(lamp)
        ->group(group);
}

std::vector<Light> lights_asked(const LightOptions& o)
{
    check_count("--sun-irradiance", o.irradiances, "--sun", o.suns.size());
    check_count("--sun-diameter", o.diameters, "--sun", o.suns.size());
    check_count("--lamp-intensity", o.intensities, "--lamp", o.lamps.size());
    std::vector<Light> lights;
    for (size_t k = 0; k < o.suns.size(); ++k) {
        Light light;
        light.name = numbered("sun", k);
        light.to_light = o.suns[k];
        if (!(light.to_light.length() > 0))
            throw UsageError("--sun " + shortest(o.suns[k]) + ": expected a direction, not 0");
        light.to_light.normalize();
        light.irradiance = of(o.irradiances, k, Vec3d(1.0));
        light.angular_diameter = of(o.diameters, k, 0.0);
        lights.push_back(light);
    }
    for (size_t k = 0; k < o.lamps.size(); ++k) {
        Light light;
        light.name = numbered("lamp", k);
        light.kind = LightKind::Point;
        light.position = o.lamps[k];
        light.irradiance = of(o.intensities, k, Vec3d(1.0));
        lights.push_back(light);
    }
    return lights;
}

Light automatic_sun(const Vec3d& up)
{
    Light light;
    light.to_light = default_sun_direction(up);
    light.irradiance = Vec3d(four_pi);
    return light;
}

bool same_place(const Light& a, const Light& b)
{
    if (a.kind != b.kind) return false;
    if (a.kind == LightKind::Point) return (a.position - b.position).length() <= 1e-9 * a.position.length();
    return (a.to_light - b.to_light).length() <= 1e-9 && std::abs(a.angular_diameter - b.angular_diameter) <= 1e-9;
}

std::string described(const Light& light)
{
    return light.name +
           (light.kind == LightKind::Point ? " at " + brief(light.position) : " towards " + brief(light.to_light));
}

}  // namespace vdbcloud::app
