#pragma once
// The lights that p1solve scatters, each with its transmittance grid.
#include "options.h"

#include "vdbcloud/grid/grid_file.h"

#include <vector>

namespace vdbcloud {

/// The lights asked for, else the file's, else a sun if neither a sky nor an emission shines. A light whose
/// transmittance grid the file lacks, or holds for another medium, gets a new one: render needs it.
std::vector<Light> lights_for(app::App&, const P1solveOptions&, GridFile&, const FloatGrid& density, const Medium&);

}  // namespace vdbcloud
