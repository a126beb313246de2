#include "support/make_odd.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointConversion.h>

namespace vdbcloud::test {

GridBasePtr point_grid()
{
    using namespace openvdb;
    const std::vector<Vec3R> positions = {{1, 2, 3}, {1.25, 2, 3}, {9, 9, 9}};
    const auto transform = math::Transform::createLinearTransform(0.5);
    const auto grid = points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(positions, *transform);
    grid->setName("points");
    return grid;
}

}  // namespace vdbcloud::test
