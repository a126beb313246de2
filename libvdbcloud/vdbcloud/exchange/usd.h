#pragma once
// A description in USD of a .vdb, as a Volume whose fields are the file's grids.
#include "vdbcloud/grid/grid_file.h"

#include <string>

namespace vdbcloud {

/// The text of a .usda: a UsdVol Volume named `volume`, an OpenVDBAsset for each float or vec3s grid, upAxis and
/// metersPerUnit of the file (1 where it has none), extent of the active voxels. `asset`: the path of the .vdb as the
/// .usda names it. Throws InputError if there is no such grid.
std::string usda_text(const GridFile&, const std::string& asset);

/// The path of `file` from the folder of `beside`: "./cloud.vdb".
std::string relative_asset(const std::string& file, const std::string& beside);

}  // namespace vdbcloud
