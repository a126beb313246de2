#pragma once
// Adds the expansion in 1 - albedo to the direct solution.
#include "options.h"

#include "vdbcloud/grid/grid_file.h"

#include <vector>

namespace vdbcloud {

/// Adds the grids of the series to the file and its figures to the report. Replaces the direct solution in `fields` by
/// the series at the medium's albedo. Throws ConvergenceError if the plain series diverges, InputError if a Cd grid
/// gives each voxel its own albedo.
void add_series(app::App&, P1solveOptions&, GridFile&, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium&, const std::vector<Light>&, ScatterFields& fields);

}  // namespace vdbcloud
