#include "support/voxel_field.h"

#include "vdbcloud/core/vdb.h"

namespace vdbcloud::test {

namespace {

FloatGridPtr with_axes(const Vec3d& x, const Vec3d& y, const Vec3d& z)
{
    auto grid = FloatGrid::create(0.0f);
    const openvdb::Mat4d m(x[0], x[1], x[2], 0.0, y[0], y[1], y[2], 0.0, z[0], z[1], z[2], 0.0, 0.0, 0.0, 0.0, 1.0);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
    grid->setName("density");
    return grid;
}

FloatGridPtr with_spacing(const Vec3d& h) { return with_axes(Vec3d(h[0], 0, 0), Vec3d(0, h[1], 0), Vec3d(0, 0, h[2])); }

void fill(FloatGrid& grid, const Vec3i& first, const Vec3i& last, const std::function<double(const Vec3i&)>& f)
{
    for (int i = first.x(); i <= last.x(); ++i)
        for (int j = first.y(); j <= last.y(); ++j)
            for (int k = first.z(); k <= last.z(); ++k)
                if (const double value = f(Vec3i(i, j, k)); value > 0)
                    grid.tree().setValueOn(openvdb::Coord(i, j, k), float(value));
}

}  // namespace

FloatGridPtr voxel_field(const Vec3i& n, const Vec3d& h, const std::function<double(const Vec3i&)>& f)
{
    const auto grid = with_spacing(h);
    fill(*grid, Vec3i(0), n - Vec3i(1), f);
    return grid;
}

FloatGridPtr voxel_field(const Vec3i& n, const Vec3d& x, const Vec3d& y, const Vec3d& z,
                         const std::function<double(const Vec3i&)>& f)
{
    const auto grid = with_axes(x, y, z);
    fill(*grid, Vec3i(0), n - Vec3i(1), f);
    return grid;
}

FloatGridPtr voxel_clouds(const std::vector<std::pair<Vec3i, Vec3i>>& boxes, const Vec3d& h, double value)
{
    const auto grid = with_spacing(h);
    for (const auto& [first, last] : boxes) fill(*grid, first, last, [value](const Vec3i&) { return value; });
    return grid;
}

}  // namespace vdbcloud::test
