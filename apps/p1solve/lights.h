#pragma once
// The lights that p1solve scatters, each with its transmittance grid.
#include "inputs.h"
#include "options.h"

#include <vector>

namespace vdbcloud {

/// The lights of the command line, else those of the inputs, else a sun if the scene has neither sky nor emission. Adds
/// to the file a transmittance grid, which render needs, for each light without one or with one for another medium.
std::vector<Light> lights_for(app::App&, const P1solveOptions&, app::MediumInput&);

/// A light without power, or one that a list of effects leaves out: no grid is computed for it.
bool adds_nothing(const EffectsAsked&, const Light&);

/// True if the file has the light's transmittance grid of this medium beside these solids.
bool has_light(const app::MediumInput&, const Light&, const std::vector<Solid>&);

}  // namespace vdbcloud
