#include "vdbcloud/fractal/mountain.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/refuse.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/grid/schema.h"

#include <openvdb/tools/MeshToVolume.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace vdbcloud {

namespace {

void check(const Vec3i& size, const MountainOptions& o)
{
    if (!(o.relief > 0 && o.relief <= 100)) refuse("relief", o.relief, "above 0, at most 100");
    if (!(o.ridges >= 0 && o.ridges <= 1)) refuse("ridges", o.ridges, "0..1");
    if (!(o.peak >= 0 && o.peak <= 1)) refuse("peak", o.peak, "0..1");
    for (int d = 0; d < 3; ++d)
        if (size[d] < 8) refuse("size of a mountain", size[d], "at least 8 voxels on each axis");
}

void rescale(std::vector<float>& values, double low, double high)
{
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const double from = *least, range = double(*most) - from;
    for (float& v : values) v = float(low + (high - low) * (range > 0 ? (v - from) / range : 1));
}

/// The closed surface of a body under a height field, in world space: a vertex over the centre of each
/// column, and a rim of them over the faces of the domain, where upright walls go down.
struct Surface {
    explicit Surface(const HeightField& f) : field(f), rows(f.rows() + 2), columns(f.columns() + 2)
    {
        for (int i = 0; i < rows; ++i)
            for (int j = 0; j < columns; ++j) points.push_back(point(i, j, false));
        for (int i = 0; i + 1 < rows; ++i)
            for (int j = 0; j + 1 < columns; ++j) {
                triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
            }
        std::vector<std::pair<int, int>> rim;
        for (int i = 0; i < rows; ++i) rim.emplace_back(i, 0);
        for (int j = 1; j < columns; ++j) rim.emplace_back(rows - 1, j);
        for (int i = rows - 2; i >= 0; --i) rim.emplace_back(i, columns - 1);
        for (int j = columns - 2; j > 0; --j) rim.emplace_back(0, j);
        const auto foot = unsigned(points.size()), count = unsigned(rim.size());
        for (const auto& [i, j] : rim) points.push_back(point(i, j, true));
        for (unsigned r = 0; r < count; ++r) {
            const unsigned next = (r + 1) % count;
            const unsigned a = at(rim[r].first, rim[r].second), b = at(rim[next].first, rim[next].second);
            triangles.push_back({a, foot + r, foot + next});
            triangles.push_back({a, foot + next, b});
            if (r > 0 && next != 0) triangles.push_back({foot, foot + next, foot + r});
        }
    }

    unsigned at(int i, int j) const { return unsigned(i) * unsigned(columns) + unsigned(j); }

    Vec3f point(int i, int j, bool foot) const
    {
        const int n[2] = {rows - 2, columns - 2}, axis[2] = {field.up == 0 ? 1 : 0, field.up == 2 ? 1 : 2};
        const double along[2] = {std::clamp(i - 0.5, 0.0, double(n[0])), std::clamp(j - 0.5, 0.0, double(n[1]))};
        Vec3d p;
        for (int d = 0; d < 2; ++d)
            p[axis[d]] = field.domain.low[axis[d]] + along[d] * field.domain.sides()[axis[d]] / n[d];
        const int column = std::clamp(i - 1, 0, n[0] - 1) * n[1] + std::clamp(j - 1, 0, n[1] - 1);
        p[field.up] = foot ? field.domain.low[field.up] : double(field.height[size_t(column)]);
        return Vec3f(p);
    }

    const HeightField& field;
    int rows, columns;
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
};

}  // namespace

HeightField mountain_heights(const Box& domain, const Vec3i& size, const Spectrum& spectrum, const MountainOptions& o)
{
    check(size, o);
    HeightField f{o.up, domain, size, {}};
    const int u = o.up == 0 ? 1 : 0, v = o.up == 2 ? 1 : 2;
    Vec3i flat = size;
    Vec3d sides = domain.sides();
    const double step = sides[o.up] / size[o.up], ground = domain.low[o.up] + 4 * step;
    const double relief = std::min(o.relief * std::max(sides[u], sides[v]), domain.high[o.up] - step - ground);
    flat[o.up] = 1;
    sides[o.up] = std::min(sides[u], sides[v]);
    const auto noise = synthesize(flat, sides, spectrum);
    const int rows = f.rows(), columns = f.columns();
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            Vec3i ijk(0);
            ijk[u] = i;
            ijk[v] = j;
            const double n = noise(ijk[0], ijk[1], ijk[2]);
            f.height.push_back(float((1 - o.ridges) * n - o.ridges * 2 * std::abs(n)));
        }
    rescale(f.height, 0, 1);
    const double a = 0.1 * o.peak;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const double x = (2 * i + 1.0) / rows - 1, y = (2 * j + 1.0) / columns - 1,
                         r2 = std::min(1.0, x * x + y * y);
            const double m = (1 - r2) * std::sqrt(1 - r2);
            float& h = f.height[size_t(i) * columns + j];
            h = float((1 - o.peak * (1 - m)) * (a + (1 - a) * double(h)));
        }
    rescale(f.height, ground, ground + relief);
    return f;
}

FloatGridPtr mountain_grid(const HeightField& field, double half_width)
{
    if (!(half_width >= 1.5 && half_width <= 16))
        throw InputError("half_width = " + std::to_string(half_width) + ": expected 1.5..16 voxels");
    const auto transform = voxel_centre_transform(field.domain, field.size);
    if (!transform->hasUniformScale()) throw InputError("a level set needs voxels that are cubes");
    const Surface surface(field);
    auto grid =
        openvdb::tools::meshToLevelSet<FloatGrid>(*transform, surface.points, surface.triangles, float(half_width));
    grid->setName(schema::solid);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    return grid;
}

}  // namespace vdbcloud
