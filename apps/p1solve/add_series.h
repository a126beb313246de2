#pragma once
// Adds the expansion in 1 - albedo to the direct solution.
#include "options.h"

#include "vdbcloud/grid/grid_file.h"

#include <vector>

namespace vdbcloud {

/// Adds the grids of the series to the file and its figures to the report: among them the error of the picture that the
/// series gives at the medium's albedo, against `fields`, the direct solution, which stays the file's. Throws
/// ConvergenceError if the plain series diverges, InputError if a Cd grid gives each voxel its own albedo.
void add_series(app::App&, P1solveOptions&, GridFile&, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium&, const std::vector<Light>&, const CollidedLight& fields);

}  // namespace vdbcloud
