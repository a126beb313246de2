#pragma once
// Makes the scene from files and options: media, lights and their grids, and bounds.
#include "options.h"

#include <memory>
#include <string>
#include <vector>

namespace vdbcloud {

struct LoadedScene {
    Scene scene;                ///< of the effects in play; background not yet chosen
    std::vector<Light> lights;  ///< all, in play or not
    Effects effects;
    EffectCosts costs;                      ///< of the effects, while the scene was loaded
    std::optional<double> left_out_before;  ///< the share of multiple scattering that p1solve left out
    std::vector<std::string> paths;         ///< of the input behind each volume
    UpAxis up = UpAxis::Y;
    std::vector<Vec3d> corners;  ///< of boxes around the media [world]; empty for empty media
    std::optional<Sky> sky;      ///< the sky of the first input whose phi has one
    std::string history;         ///< of all inputs
    bool automatic_light = false;
    TransmittancePlan planned;  ///< of a dry run: light that the run would compute
};

/// Reads every input, chooses media and lights, and computes each transmittance grid that no input has.
///
/// Lights: those of --sun and --lamp, else those of the inputs, else one automatic sun. A transmittance grid of an
/// input is used if its light's place, its extinction and its density are the scene's. Otherwise the grid is computed
/// again, with a warning that names the reason. Throws UsageError if two inputs have different lights of one name, or
/// if multiple scattering was computed with other coefficients, another density or other lights.
/// Sets the axes along which the media repeat in `o.light`, too.
LoadedScene load_scene(app::App&, RenderOptions& o);

/// True if there is light beside the scene's lights: multiple scattering, emission, or a sky that light paths see.
bool glows(const Scene&);

/// What bounds the error of the light that the scene's files bring, in one line; empty if they say nothing.
std::string accuracy_of_light(const LoadedScene&);

}  // namespace vdbcloud
