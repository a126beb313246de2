#pragma once
// Options for lights, shared by the stages that compute their transmittance.
#include "app.h"
#include "environment_options.h"

#include "vdbcloud/scene/light.h"

#include <functional>
#include <vector>

namespace vdbcloud::app {

/// The options of each kind of light, in the order of light_kinds().
struct LightOptions {
    struct OfKind {
        std::vector<Vec3d> places;
        /// Of each parameter: no value, one for all lights, or one for each light.
        std::vector<std::vector<Vec3d>> colours;  // and directions
        /// As `colours`, for parameters that are one number.
        std::vector<std::vector<double>> numbers;
    };
    std::vector<OfKind> kinds;
    EnvironmentOptions environment;
    bool by_atmosphere = false;  ///< suns through a clear atmosphere
    double turbidity = 2.2;
    std::function<bool()> sky_has_turbidity;  ///< set by declare_sky()
};

/// An option for each kind of light and one for each of its parameters, from light_kinds(): --sun --sun-irradiance
/// --sun-diameter --lamp --lamp-intensity --spot --spot-intensity --spot-direction --spot-angle --spot-blend, each any
/// number of times. And --sun-colour --turbidity.
void declare_lights(App&, LightOptions&);

/// The lights of the command line: sun, sun2, ..., then lamp, lamp2, ..., then spot, spot2, ..., then the suns of an
/// environment; none without any place and picture. With --sun-colour atmosphere each sun has its irradiance times what
/// the atmosphere lets through for its height over `up`, relative to the luminance above the atmosphere. Throws
/// UsageError if a parameter is given neither once nor once for each light, or a direction has no length, or if a sun
/// whose colour follows from its height has set.
std::vector<Light> lights_asked(const LightOptions&, const Vec3d& up);

/// A sun for a scene that has no light: from scene/camera's default_sun_direction, of irradiance 4 pi, with
/// which an isotropic thick cloud has radiances around one half.
Light automatic_sun(const Vec3d& up);

/// Warns that nothing lights the medium: each light has strength 0, and there is no other light (`other`: a sky,
/// emission, collided light).
void tell_darkness(App&, const std::vector<Light>&, bool other);

/// "sun towards 0.3,1,0.2" or "lamp at 1,2,3": for messages.
std::string described(const Light&);

}  // namespace vdbcloud::app
