#pragma once
// One function for each kind of input. Each ends a dry run, or writes the output.
#include "options.h"
#include "plan.h"

#include "vdbcloud/grid/grid_file.h"

namespace vdbcloud {

void import_table(app::App&, const Options&);
void import_model(app::App&, const Options&);
void import_array(app::App&, const Options&);
void import_properties(app::App&, const Options&);
void import_particles(app::App&, const Options&);
void import_nanovdb(app::App&, const Options&);

/// Memory and work of grids that hold `voxels` of `floats` values each, read from `held` bytes.
app::Plan plan_of_voxels(double voxels, double floats, double held, const std::string& way_out);

/// True in a dry run, whose end is told: "make up to N voxels of WHAT". Else memory is there, or InputError.
bool ended(app::App&, const app::Plan&, const std::string& what);

/// Writes the grids, the density first, with the medium that the user gave, the up axis and metres of a world unit
/// where they are known (above 0). `extinction`: the density is extinction [1/world unit].
void write_import(app::App&, const Options&, const std::string& path, const std::vector<GridBasePtr>& grids, UpAxis up,
                  double meters_per_unit, bool extinction);

}  // namespace vdbcloud
