#pragma once
// What the grid of a table will hold, known before it is made.
#include "vdbcloud/voxels/box_medium.h"

#include <cstddef>
#include <functional>
#include <vector>

namespace vdbcloud {

/// Voxels, and the blocks of a tree that hold them: of 8^3, 128^3 and 4096^3 voxels.
struct Content {
    double voxels = 0, blocks[3] = {0, 0, 0};
};

/// Content of a map of columns that stand on one floor: layers(x, y) voxels each.
Content content_of_columns(size_t nx, size_t ny, const std::function<double(size_t, size_t)>& layers);

/// Content of the boxes, as if no large ones touched another. Blocks that a box fills are tiles, which take no memory.
Content content_of_boxes(const std::vector<MediumBox>& boxes, const Vec3d& cell);

}  // namespace vdbcloud
