#pragma once
// Options for lights, shared by the stages that compute their transmittance.
#include "app.h"

#include "vdbcloud/scene/light.h"

#include <vector>

namespace vdbcloud::app {

struct LightOptions {
    std::vector<Vec3d> suns;         ///< directions TOWARDS them
    std::vector<Vec3d> irradiances;  ///< of each, or one for all
    std::vector<double> diameters;   ///< of each, or one for all [degrees]
    std::vector<Vec3d> lamps;        ///< positions
    std::vector<Vec3d> intensities;  ///< of each, or one for all
};

/// --sun --sun-irradiance --sun-diameter --lamp --lamp-intensity, each as often as wanted.
void declare_lights(App&, LightOptions&);

/// The lights that were asked for: sun, sun2, ..., then lamp, lamp2, ...; none without --sun and --lamp.
/// Throws UsageError if a value is given more often than its lights, or without any.
std::vector<Light> lights_asked(const LightOptions&);

/// A sun for a scene that has no light: from scene/camera's default_sun_direction, of irradiance 4 pi, with
/// which an isotropic thick cloud has radiances around one half.
Light automatic_sun(const Vec3d& up);

/// True if two lights send the same light from the same place (to rounding): a transmittance grid of one
/// serves the other where also `irradiance` may differ.
bool same_place(const Light&, const Light&);

/// "sun towards 0.3,1,0.2" or "lamp at 1,2,3": for messages.
std::string described(const Light&);

}  // namespace vdbcloud::app
