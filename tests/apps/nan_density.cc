#include "apps/tools.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"

#include <limits>

namespace vdbcloud::test {

void write_density_with_nan(const std::string& path, const std::array<int, 3>& voxel)
{
    auto density = FloatGrid::create(0.0f);
    density->setName("density");
    density->fill(openvdb::CoordBBox::createCube({0, 0, 0}, 4), 1.0f);
    density->tree().setValue({voxel[0], voxel[1], voxel[2]}, std::numeric_limits<float>::quiet_NaN());
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids.push_back(density);
    write_grid_file(path, file);
}

}  // namespace vdbcloud::test
