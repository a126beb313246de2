// Checks the declarations of core/fwd.h against OpenVDB's own.
#include "vdbcloud/core/vdb.h"

#include <type_traits>

static_assert(std::is_same_v<vdbcloud::FloatGrid, openvdb::FloatGrid>);
static_assert(std::is_same_v<vdbcloud::FloatGridPtr, openvdb::FloatGrid::Ptr>);
static_assert(std::is_same_v<vdbcloud::Vec3SGrid, openvdb::Vec3SGrid>);
static_assert(std::is_same_v<vdbcloud::Vec3d, openvdb::Vec3d>);
static_assert(std::is_same_v<vdbcloud::Vec3i, openvdb::Vec3i>);
