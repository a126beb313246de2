#pragma once
// The picture that --flux-map writes, and what the report says of it.
#include "options.h"

namespace vdbcloud {

/// Writes the map to o.flux_map and adds the power of its direct light to the report, channel by channel. `history`:
/// that of the input. Does nothing without --flux-map or without a voxel to map.
void write_flux_map(app::App&, const P1solveOptions&, const ScatterReport&, const std::string& history);

}  // namespace vdbcloud
