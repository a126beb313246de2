#pragma once
// Grids as variables of a netCDF file by the CF conventions.
#include "vdbcloud/grid/grid_file.h"

#include <string>
#include <vector>

namespace vdbcloud {

/// Writes float and vec3s grids that share the transform of the first one on the box of their active voxels, in
/// netCDF's classic format with 64-bit offsets.
///
/// Dimensions are z, y, x, z upwards: of a file whose up axis is Y, x, y, z are world x, -z, y. Coordinates and values
/// with lengths are in metres where the file has meters_per_unit, temperatures in kelvin. Colours have a dimension
/// `channel` (r, g, b), vectors a dimension `component` along x, y, z. A density with extinction gives a variable
/// `extinction`, too. Inactive voxels have the background. Equal inputs give equal bytes.
///
/// Returns a sentence for each grid that is left out. Throws InputError for a transform that is rotated or sheared, no
/// active voxel, and more than 2^28 values; IoError if the file cannot be written.
std::vector<std::string> write_netcdf(const std::string& path, const GridFile&, const std::string& history,
                                      bool no_clobber);

}  // namespace vdbcloud
