#pragma once
// NanoVDB files as OpenVDB grids.
#include "vdbcloud/core/fwd.h"

#include <string>
#include <vector>

namespace vdbcloud {

struct NanoGrids {
    std::vector<GridBasePtr> grids;  ///< float and vec3s, with names and classes of the file
    std::vector<std::string> said;   ///< grids of other types, which are passed over, a sentence each
};

/// Reads the grids of a .nvdb, without compression or with ZIP or Blosc: float, double and quantised floats (Fp4, Fp8,
/// Fp16, FpN) as float, Vec3f and Vec3d as vec3s. The file is read in a guarded process, for NanoVDB follows the
/// offsets in a file as they are. Throws IoError if the file cannot be read, else InputError with the path.
NanoGrids read_nanovdb(const std::string& path);

}  // namespace vdbcloud
