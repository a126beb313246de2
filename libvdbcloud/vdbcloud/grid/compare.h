#pragma once
// How far two grids, or two files of grids, are from each other: by value, whatever nodes hold the values.
#include "vdbcloud/grid/grid_file.h"

#include <array>
#include <string>
#include <vector>

namespace vdbcloud {

/// The difference of two grids, voxel by voxel in index space, over all voxels that are active in either. A tile
/// counts as the voxels it covers. Where only one grid is active the other takes part with what it answers there
/// (background or inactive value). Of vectors the length of the difference is meant, of integers and bool the number.
/// Two values that are both NaN, or the same infinity, are equal; a finite value and one that is not are infinitely
/// far apart.
struct GridDifference {
    std::string label;                  ///< name, or NAME[k] where several bear it
    std::string types;                  ///< "float", or "float, double" where they differ
    bool comparable = true;             ///< false: of different types; then nothing below is measured
    bool by_value = true;               ///< false: a type known only by its bytes: max is 0 or infinite
    double max = 0;                     ///< largest difference, the backgrounds' included
    double rms = 0;                     ///< root mean square of the difference
    double relative = 0;                ///< rms over the rms of the first grid's values; infinite if those are all 0
    std::array<int, 3> where{};         ///< a voxel with the largest difference
    uint64_t voxels = 0;                ///< active in either
    uint64_t only_a = 0, only_b = 0;    ///< active in one alone
    double transform = 0;               ///< largest difference of the matrices' entries over the largest entry
    std::vector<std::string> metadata;  ///< keys that one lacks, or whose values differ; volatile ones left out
};

struct FileDifference {
    std::vector<GridDifference> grids;
    std::vector<std::string> only_a, only_b;  ///< labels of grids that the other file lacks
    std::vector<std::string> metadata;        ///< of the file
};

/// What is still called equal.
struct Tolerances {
    double max = 0, rms = 0, relative = 0;  ///< as GridDifference; infinity: anything
    double topology = 0;                    ///< part of the voxels that may be active in one alone, 0..1
    double transform = 1e-9;
    bool metadata = false;  ///< metadata has to agree as well
};

GridDifference compare_grids(const GridBase& a, const GridBase& b);

/// Grids are matched by label. `which`: labels to look at; empty for all. Throws InputError if neither file has one
/// of them.
FileDifference compare_files(const GridFile& a, const GridFile& b, const std::vector<std::string>& which = {});

/// Why they are not equal within tolerance, a sentence a reason; empty if they are.
std::vector<std::string> beyond(const FileDifference&, const Tolerances&);

/// True of metadata that says how a file was made or stored and not what it holds: creator, history,
/// format, statistics.
bool is_volatile(const std::string& key);

}  // namespace vdbcloud
