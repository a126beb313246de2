#include "vdbcloud/core/vdb.h"

#include <type_traits>

// The only place where trees and grids are instantiated.
template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
template class openvdb::Grid<openvdb::FloatTree>;
template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
template class openvdb::Grid<openvdb::Vec3STree>;

static_assert(std::is_same_v<vdbcloud::FloatGrid, openvdb::FloatGrid>);
static_assert(std::is_same_v<vdbcloud::FloatGridPtr, openvdb::FloatGrid::Ptr>);
static_assert(std::is_same_v<vdbcloud::Vec3SGrid, openvdb::Vec3SGrid>);
static_assert(std::is_same_v<vdbcloud::Vec3d, openvdb::Vec3d>);
static_assert(std::is_same_v<vdbcloud::Vec3i, openvdb::Vec3i>);
