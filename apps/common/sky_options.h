#pragma once
// Options for a sky: as a light in p1solve, as a background and a light of light paths in render.
#include "light_options.h"

#include "vdbcloud/scene/sky.h"

namespace vdbcloud::app {

struct SkyOptions {
    std::string sky;  ///< "day", "preetham", a colour, or empty
    Vec3d zenith{0, 0, 0}, horizon{0, 0, 0}, ground{0, 0, 0};
    double haze = GradientSky().haze;
    const EnvironmentOptions* environment = nullptr;  ///< set by declare_sky()
    struct {
        Option sky, zenith, horizon, ground, haze, turbidity;
    } option;
};

/// --sky --sky-zenith --sky-horizon --sky-ground --sky-haze. `otherwise`: what there is without them. Call after
/// declare_lights().
void declare_sky(App&, SkyOptions&, LightOptions&, const std::string& group, const std::string& otherwise);

/// True if one of the three radiances was given.
bool shape_asked(const SkyOptions&);
/// True if --sky, one of the three radiances or --environment was given.
bool sky_asked(const SkyOptions&);

/// The sky that the options describe, over `up`: of --sky or --environment; without it `otherwise`, or a clear day
/// about the suns, with the values that were given. The brightest sun is that of --sky preetham. Throws UsageError.
Sky sky_of(const SkyOptions&, const LightOptions&, const std::vector<Light>& lights, const Vec3d& up,
           const std::optional<Sky>& otherwise = std::nullopt);

/// The sky that lights the medium: sky_of() if one was asked for, else a black one.
Sky lighting_sky(const SkyOptions&, const LightOptions&, const std::vector<Light>& lights, const Vec3d& up);

/// "1" or "r,g,b" as a colour. Throws UsageError: OPTION TEXT: expected EXPECTED.
Vec3d colour_asked(const std::string& option, const std::string& text, const std::string& expected);

}  // namespace vdbcloud::app
