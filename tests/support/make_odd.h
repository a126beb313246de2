#pragma once
// The odd files of data/odd.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud::test {

/// Writes all odd files into a folder.
void make_odd_files(const std::string& folder);

/// A grid "points" with three points; not a volume.
GridBasePtr point_grid();

}  // namespace vdbcloud::test
