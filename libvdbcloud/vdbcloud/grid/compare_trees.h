#pragma once
// Differences of trees whose values can be subtracted. compare.h builds on this header. Private to grid/.
#include <array>
#include <cstdint>

#include <openvdb/version.h>

namespace openvdb {
OPENVDB_USE_VERSION_NAMESPACE
namespace OPENVDB_VERSION_NAME {
namespace tree {
class TreeBase;
}
}  // namespace OPENVDB_VERSION_NAME
}  // namespace openvdb

namespace vdbcloud {

struct TreeDifference {
    double max = 0, background = 0;
    double sum_squares = 0;    ///< of differences, over voxels active in either tree
    double sum_squares_a = 0;  ///< of the first tree's values, over voxels active in either tree
    uint64_t voxels = 0, only_a = 0, only_b = 0;
    std::array<int, 3> where{};
};

/// Compares two trees of the same type. Supported types: float, double, vec3s, vec3d, vec3i, bool, mask, int32, int64.
/// For any other type returns false and leaves the result unchanged.
bool compare_trees(const openvdb::tree::TreeBase& a, const openvdb::tree::TreeBase& b, TreeDifference&);

}  // namespace vdbcloud
