#include "support/make_odd.h"

#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
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

GridBasePtr particle_grid()
{
    using namespace openvdb;
    const std::vector<Vec3R> positions = {{1, 2, 3}, {-4, 0.5, 9}};
    const points::PointAttributeVector<Vec3R> at(positions);
    const auto transform = math::Transform::createLinearTransform(1);
    const auto index = tools::createPointIndexGrid<tools::PointIndexGrid>(at, *transform);
    const auto grid = points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(*index, at, *transform);
    grid->setName("particles");
    const auto append = [&](const char* name, const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        points::appendAttribute<T>(grid->tree(), name);
        points::populateAttribute<points::PointDataTree, tools::PointIndexTree, points::PointAttributeVector<T>>(
            grid->tree(), index->tree(), name, points::PointAttributeVector<T>(values));
    };
    append("pscale", std::vector<float>{0.5f, 2.0f});
    append("mass", std::vector<float>{3.0f, 5.0f});
    append("v", std::vector<Vec3f>{{1, 0, 0}, {0, 0, -2}});
    return grid;
}

}  // namespace vdbcloud::test
