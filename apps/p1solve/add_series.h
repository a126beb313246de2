#pragma once
// The expansion in 1 - albedo beside the direct solution.
#include "options.h"

#include "vdbcloud/grid/grid_file.h"

#include <vector>

namespace vdbcloud {

/// Adds the series to the file and its figures to the report, and replaces the direct solution in `fields` by what the
/// series gives for the medium's albedo. Throws ConvergenceError where the plain series diverges, InputError where a Cd
/// gives each voxel an albedo of its own.
void add_series(app::App&, P1solveOptions&, GridFile&, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium&, const std::vector<Light>&, ScatterFields& fields);

}  // namespace vdbcloud
