#include "scatter/fields.h"

#include "vdbcloud/core/vdb.h"

namespace vdbcloud::test {

FloatGridPtr field(const Vec3i& n, const Vec3d& x, const Vec3d& y, const Vec3d& z,
                   const std::function<double(const Vec3i&)>& f)
{
    auto grid = FloatGrid::create(0.0f);
    for (int i = 0; i < n.x(); ++i)
        for (int j = 0; j < n.y(); ++j)
            for (int k = 0; k < n.z(); ++k) {
                const double value = f(Vec3i(i, j, k));
                if (value > 0) grid->tree().setValueOn(openvdb::Coord(i, j, k), float(value));
            }
    const openvdb::Mat4d m(x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0, z[0], z[1], z[2], 0.0, 0.0, 0.0, 0.0, 1.0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    grid->setName("density");
    return grid;
}

FloatGridPtr field(const Vec3i& n, const Vec3d& h, const std::function<double(const Vec3i&)>& f)
{
    return field(n, Vec3d(h[0], 0, 0), Vec3d(0, h[1], 0), Vec3d(0, 0, h[2]), f);
}

Vec3SGridPtr constant_like(const FloatGrid& grid, const Vec3f& value)
{
    auto out = Vec3SGrid::create(Vec3f(1.0f));
    out->setTransform(grid.transform().copy());
    for (auto v = grid.cbeginValueOn(); v; ++v) out->tree().setValueOn(v.getCoord(), value);
    return out;
}

}  // namespace vdbcloud::test
