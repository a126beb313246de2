#include "vector_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

namespace vdbcloud::app {

Vec3SGridPtr vector_grid(App& app, const GridFile& file, const GridBasePtr& grid)
{
    if (!grid || grid->empty()) return nullptr;
    if (auto found = openvdb::gridPtrCast<Vec3SGrid>(grid)) return found;
    app.warnings()(file.path + ": grid '" + printable(grid->getName()) + "' is " + grid->valueType() +
                   ", expected vec3s; the grid is ignored");
    return nullptr;
}

}  // namespace vdbcloud::app
