#pragma once
// From files and options to a scene: media, lights with their grids, and where it all is.
#include "options.h"

#include <memory>
#include <string>
#include <vector>

namespace vdbcloud {

struct LoadedScene {
    Scene scene;  ///< background not yet chosen
    UpAxis up = UpAxis::Y;
    std::vector<Vec3d> corners;  ///< of boxes around what is to be seen; empty if there is nothing
    std::optional<Sky> sky;      ///< that lit the first input that a sky lit
    std::string history;         ///< of all inputs
    bool automatic_light = false;
};

/// Reads every input, settles coefficients and lights, and computes the light grids that are missing or do not fit.
///
/// Lights: those of --sun and --lamp if there are any, else those of the inputs, else one automatic sun. An input's
/// light grid is taken if its place, extinction and density are the scene's; else it is computed again, and a warning
/// says why. Throws UsageError where two inputs hold different lights of one name, or multiple scattering of other
/// coefficients.
LoadedScene load_scene(app::App&, const RenderOptions&);

}  // namespace vdbcloud
