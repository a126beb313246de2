#include "vdbcloud/core/voxel_transform.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <cmath>
#include <sstream>

namespace vdbcloud {

std::shared_ptr<Transform> voxel_transform(const Vec3d& edge)
{
    const bool cubes = std::abs(edge[1] / edge[0] - 1) < 1e-9 && std::abs(edge[2] / edge[0] - 1) < 1e-9;
    auto transform = Transform::createLinearTransform();
    try {
        transform->preScale(cubes ? Vec3d(edge[0]) : edge);
    } catch (const openvdb::ArithmeticError&) {
        std::ostringstream text;
        text << "voxels of " << edge[0] << " x " << edge[1] << " x " << edge[2]
             << ": expected a volume of 3.1e-15 or more; use a smaller unit of length";
        throw InputError(text.str());
    }
    return transform;
}

}  // namespace vdbcloud
