#pragma once
// Differences between two grids, or between two files of grids. Values count; the layout of tree nodes does not.
#include "vdbcloud/grid/grid_file.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

/// The difference of two grids, voxel by voxel in index space, over all voxels that are active in either grid. A tile
/// counts as the voxels that the tile covers. Where only one grid is active, the other grid contributes its background
/// or inactive value at that voxel. The difference of two vectors is the length of their difference vector; integers
/// and bools are subtracted as numbers. Two NaN values are equal, and so are two infinities of one sign. A finite and a
/// non-finite value differ by infinity.
struct GridDifference {
    std::string label;                  ///< name, or NAME[k] where several grids have that name
    std::string types;                  ///< "float", or "float, double" where the types differ
    bool comparable = true;             ///< false: the types differ, and only label, types and metadata are set
    bool by_value = true;               ///< false: a type compared by its stored bytes; max is 0 or infinite
    double max = 0;                     ///< largest difference, including that of the backgrounds
    double rms = 0;                     ///< root mean square of the difference
    double relative = 0;                ///< rms / rms of the first grid's values; infinite if only those are all 0
    std::array<int, 3> where{};         ///< a voxel with the largest difference
    uint64_t voxels = 0;                ///< number of voxels active in either grid
    uint64_t only_a = 0, only_b = 0;    ///< number of voxels active in only the first, only the second grid
    double transform = 0;               ///< largest difference of the matrices' entries over the largest entry
    std::vector<std::string> metadata;  ///< keys missing in one grid or with differing values, without volatile keys
};

struct FileDifference {
    std::vector<GridDifference> grids;
    std::vector<std::string> only_a, only_b;  ///< labels of grids that the other file lacks
    std::vector<std::string> metadata;        ///< keys of file metadata that differ, as GridDifference::metadata
};

/// Largest differences at which two files count as equal.
struct Tolerances {
    double max = 0, rms = 0, relative = 0;  ///< limits of those members of GridDifference; infinity: no limit
    double topology = 0;                    ///< limit of (only_a + only_b) / voxels, 0..1
    double transform = 1e-9;                ///< limit of GridDifference::transform
    bool metadata = false;                  ///< true: metadata must agree too
};

/// Compares two grids of any type. The label is the first grid's name.
GridDifference compare_grids(const GridBase& a, const GridBase& b);

/// Matches grids by label. `which`: labels to compare; empty: all grids, and the files' metadata. Throws InputError for
/// a label that neither file has.
FileDifference compare_files(const GridFile& a, const GridFile& b, const std::vector<std::string>& which = {});

/// One sentence for each tolerance that is exceeded; empty if the files are equal within tolerance.
std::vector<std::string> beyond(const FileDifference&, const Tolerances&);

/// True for metadata that describes how a file was made or stored, not its contents: creator, history, format,
/// statistics, is_local_space, is_saved_as_half_float.
bool is_volatile(const std::string& key);

}  // namespace vdbcloud
