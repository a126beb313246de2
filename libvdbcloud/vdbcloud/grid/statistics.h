#pragma once
// What a grid holds, in figures, for reports.
#include "vdbcloud/grid/grid_file.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

/// Counted and measured, never taken from what a file claims about itself.
struct GridStatistics {
    std::string label;           ///< name, or NAME[k] where several bear it
    std::string value_type;      ///< "float", "vec3s", ...
    std::string grid_class;      ///< "fog volume", "level set", "staggered", "unknown"
    uint64_t active_voxels = 0;  ///< tiles counted by their voxels
    uint64_t active_tiles = 0;
    uint64_t memory_bytes = 0;
    std::array<int, 3> box_min{}, box_max{};  ///< of active voxels, inclusive; all 0 if there are none
    Vec3d voxel_size{0, 0, 0};                ///< [world unit]; at the origin where the transform is not affine
    bool has_values = false;                  ///< of float, double, vec3s: only then the following
    double min = 0, max = 0, mean = 0;        ///< over active voxels; of a vector its length
    uint64_t not_finite = 0;                  ///< active values that are not finite; left out of the above
};

GridStatistics grid_statistics(const GridBase&);

/// Of each grid, in file order.
std::vector<GridStatistics> file_statistics(const GridFile&);

}  // namespace vdbcloud
