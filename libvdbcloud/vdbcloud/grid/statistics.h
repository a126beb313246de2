#pragma once
// Statistics of grids, for reports.
#include "vdbcloud/grid/grid_file.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

/// Computed from the tree, never read from the file's metadata.
struct GridStatistics {
    std::string label;           ///< name, or NAME[k] where several grids have that name
    std::string value_type;      ///< "float", "vec3s", ...
    std::string grid_class;      ///< "fog volume", "level set", "staggered", "unknown"
    uint64_t active_voxels = 0;  ///< a tile counts as the voxels that it covers
    uint64_t active_tiles = 0;
    uint64_t memory_bytes = 0;
    /// Bounding box of active voxels [index], inclusive; all 0 if there are none.
    std::array<int, 3> box_min{}, box_max{};
    Vec3d voxel_size{0, 0, 0};          ///< [world unit]; for a non-affine transform: at the origin
    bool has_values = false;            ///< true for float, double, vec3s; else the members below stay 0
    double min = 0, max = 0, mean = 0;  ///< over finite active values; for vectors: of the length
    uint64_t not_finite = 0;            ///< number of active voxels whose value is not finite
};

/// Statistics of one grid. The label is the grid's name.
GridStatistics grid_statistics(const GridBase&);

/// Statistics of each grid, in file order.
std::vector<GridStatistics> file_statistics(const GridFile&);

}  // namespace vdbcloud
