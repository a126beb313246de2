#pragma once
// The odd files of data/odd.
#include "vdbcloud/core/fwd.h"

#include <string>

namespace vdbcloud::test {

/// Writes all of them into a folder.
void make_odd_files(const std::string& folder);

/// A grid "points" of three points, which is no volume.
GridBasePtr point_grid();

}  // namespace vdbcloud::test
