#include "vdbcloud/core/vdb.h"

template class openvdb::tree::Tree<openvdb::Vec3STree::RootNodeType>;
