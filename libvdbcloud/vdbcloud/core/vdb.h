#pragma once
// OpenVDB itself, for sources. Trees and grids of float and vec3s are instantiated once, in core/*_tree.cc, *_grid.cc:
// creating a grid then costs a source 7 s of compiling and not 19.
#include "vdbcloud/core/fwd.h"

#include <openvdb/openvdb.h>

extern template class openvdb::tree::Tree<openvdb::FloatTree::RootNodeType>;
extern template class openvdb::Grid<openvdb::FloatTree>;
extern template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
extern template class openvdb::Grid<openvdb::Vec3STree>;
