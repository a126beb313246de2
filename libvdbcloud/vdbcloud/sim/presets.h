#pragma once
// Presets and accuracies. Their soundings are the tables in data/soundings, compiled in.
#include "vdbcloud/sim/parameters.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

struct Preset {
    Parameters parameters;
    Sounding sounding;
    double minutes = 20;  ///< how long it is worth watching
    double every = 10;    ///< seconds between frames
};

/// cumulus, congestus, stratocumulus, fog, smoke, paper: the names of scenes, and of soundings.
const std::vector<std::string>& preset_names();

/// Throws InputError with the names that there are.
Preset preset(const std::string& name);
Sounding sounding_named(const std::string& name);

enum class Accuracy {
    Fast,      ///< second-order stages, third-order scalars
    Default,   ///< third-order stages, fifth-order fluxes
    Accurate,  ///< the same in double, smaller steps
};
void apply(Accuracy, Parameters&);

/// Heating of a box of another size: moves and scales bubbles and patches so that they keep their place in the box.
void rescale_forcing(Parameters&, const Lattice& before);

}  // namespace vdbcloud::sim
