#pragma once
// Grids of vectors in the files that programs read.
#include "app.h"

namespace vdbcloud::app {

/// `grid` as a vec3s grid; null for null, for an empty grid, and, with a warning, for a grid of another type.
Vec3SGridPtr vector_grid(App&, const GridFile& file, const GridBasePtr& grid);

}  // namespace vdbcloud::app
