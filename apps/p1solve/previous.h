#pragma once
// The light of the frame before, from which --start-from starts the sweeps.
#include "inputs.h"
#include "options.h"

namespace vdbcloud {

/// Sets ScatterOptions::previous from the file of --start-from and the velocity of `in`; nothing without the option.
/// Throws InputError for a file without multiple scattering, UsageError for one in another scaling or
/// periodic otherwise, and for --start-seconds without a velocity.
void choose_start(app::App&, P1solveOptions&, const app::MediumInput& in);

/// Of the frame's options: the name of --start-from becomes that of the frame before, `last`, which becomes this
/// frame's; the first frame has none. Names without a place for a number stay.
void place_start(P1solveOptions& frame, const app::App::PlaceFrame&, std::string& last);

}  // namespace vdbcloud
