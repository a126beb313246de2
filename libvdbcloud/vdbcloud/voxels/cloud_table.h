#pragma once
// Clouds of constant cells, as tables of optical depth describe them, as grids of extinction.
#include "vdbcloud/core/fwd.h"

#include <functional>
#include <vector>

namespace vdbcloud {

/// The cells of a table's cloud, in world units. The table's first axis is x, the vertical axis is y or z, and the
/// other horizontal axis is the remaining one. The lower corner of the first cell is at (0, base, 0) of these three.
struct CloudCells {
    Vec3d size{1, 1, 1};  ///< of a cell: along x, along the other horizontal axis, vertical
    double base = 0;      ///< height of the lowest layer's lower face
    int up = 1;           ///< index of the vertical world axis: 1 or 2
};

/// A vertical section: extinction(column, layer), layer 0 the lowest, the same in `across` cells side by side. Voxels
/// are the cells; active are those above 0. Extinctions must be finite and not below 0 (InputError, with the
/// cell), and the cells at most 2^28.
FloatGridPtr section_cloud(size_t columns, size_t layers, int across, const CloudCells&,
                           const std::function<double(size_t column, size_t layer)>& extinction);

/// A map of columns: each a cloud of constant extinction from the base up to thickness(x, y), of vertical optical depth
/// depth(x, y). Voxels that the top crosses hold their share, so that each column's sum of extinction times cell height
/// is its optical depth. Depth and thickness must be finite and not below 0, and a depth above 0 needs a thickness
/// above 0 (InputError, with the column).
FloatGridPtr column_cloud(size_t nx, size_t ny, const CloudCells&, const std::function<double(size_t, size_t)>& depth,
                          const std::function<double(size_t, size_t)>& thickness);

}  // namespace vdbcloud
