#pragma once
// Presets and accuracies. Their soundings are the tables in data/soundings, compiled in.
#include "vdbcloud/sim/parameters.h"

#include <string>
#include <vector>

namespace vdbcloud::sim {

struct Preset {
    Parameters parameters;
    Sounding sounding;
    double minutes = 20;             ///< simulated time
    double every = 10;               ///< seconds between frames
    double smoke_extinction = 0.05;  ///< sigma_t of dye 1 [1/m]
};

/// cumulus, congestus, stratocumulus, fog, smoke, fire, bomex, rico, paper: the names of presets and of soundings.
const std::vector<std::string>& preset_names();

/// Throws InputError that lists the names.
Preset preset(const std::string& name);
Sounding sounding_named(const std::string& name);

enum class Accuracy {
    Small,     ///< second-order stages and third-order scalars: half of the memory, no time saved
    Default,   ///< third-order stages, fifth-order fluxes
    Accurate,  ///< the same in double, smaller steps
};
/// Sets precision, schemes in time and space, Courant number and dt, whatever they were: those of a preset too.
void apply(Accuracy, Parameters&);

/// Moves and scales bubbles and patches in proportion when the box changes its size from that of `before`.
void rescale_forcing(Parameters&, const Lattice& before);

}  // namespace vdbcloud::sim
