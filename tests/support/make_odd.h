#pragma once
// The odd files of data/odd.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud::test {

/// Writes all odd files into a folder.
void make_odd_files(const std::string& folder);

/// A grid "points" with three points; not a volume.
GridBasePtr point_grid();

/// A grid "particles" with two points at (1, 2, 3) and (-4, 0.5, 9): pscale 0.5 and 2, mass 3 and 5, v (1, 0, 0) and
/// (0, 0, -2), in voxels of 1 [world unit].
GridBasePtr particle_grid();

}  // namespace vdbcloud::test
