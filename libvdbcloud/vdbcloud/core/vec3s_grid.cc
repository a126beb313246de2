#include "vdbcloud/core/vdb.h"

template class openvdb::Grid<openvdb::Vec3STree>;
