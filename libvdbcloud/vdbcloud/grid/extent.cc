#include "vdbcloud/grid/extent.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>

namespace vdbcloud {

namespace {

float amount(float value) { return value; }
float amount(const Vec3f& value) { return std::max({value[0], value[1], value[2]}); }

template<typename GridT>
float greatest(const GridT& grid)
{
    float most = 0;
    for_each_active_tile(grid, [&](const auto& tile) { most = std::max(most, amount(*tile)); });
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
        for (auto value = leaf->cbeginValueOn(); value; ++value) most = std::max(most, amount(*value));
    return most;
}

void add_corners(const openvdb::CoordBBox& box, double reach, const Transform& transform, std::vector<Vec3d>& out)
{
    const Vec3d low = box.min().asVec3d() - Vec3d(reach), high = box.max().asVec3d() + Vec3d(reach);
    for (int corner = 0; corner < 8; ++corner)
        out.push_back(transform.indexToWorld(
            Vec3d(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2])));
}

/// Voxels of one plane x = const that may be corners of the convex hull: all others lie between two of the same row, or
/// within the hull of others.
class PlaneHull {
public:
    void add(int y, int z)
    {
        points_.push_back({y, z});
        if (points_.size() > limit_) {
            reduce();
            limit_ = std::max(least_limit, 2 * points_.size());
        }
    }
    /// The corners of the hull (y, z).
    const std::vector<std::array<int64_t, 2>>& corners()
    {
        reduce();
        return points_;
    }

private:
    using Point = std::array<int64_t, 2>;
    static constexpr size_t least_limit = 256;

    static int64_t turn(const Point& a, const Point& b, const Point& c)
    {
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    }
    /// Andrew's monotone chain.
    void reduce()
    {
        std::sort(points_.begin(), points_.end());
        points_.erase(std::unique(points_.begin(), points_.end()), points_.end());
        if (points_.size() < 3) return;
        std::vector<Point> hull;
        const auto chain = [&hull](auto from, auto to) {
            const size_t begin = hull.size();
            for (; from != to; ++from) {
                while (hull.size() >= begin + 2 && turn(hull[hull.size() - 2], hull.back(), *from) <= 0)
                    hull.pop_back();
                hull.push_back(*from);
            }
            hull.pop_back();  // the other chain begins with it
        };
        chain(points_.begin(), points_.end());
        chain(points_.rbegin(), points_.rend());
        points_ = std::move(hull);
    }

    std::vector<Point> points_;
    size_t limit_ = least_limit;
};

/// Corners of boxes that reach `reach` voxels beyond the centres of voxels above `least`. Their convex hull is that of
/// the boxes about each such voxel.
template<typename GridT>
std::vector<Vec3d> corners_above(const GridT& grid, float least, double reach)
{
    std::vector<Vec3d> out;
    for_each_active_tile(grid, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        if (amount(*tile) > least) add_corners(box, reach, grid.transform(), out);
    });
    std::map<int, PlaneHull> planes;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        int row = -1, last = 0;  // the row of eight voxels along z, and its last voxel
        PlaneHull* plane = nullptr;
        const auto end_row = [&] {
            if (plane) plane->add(leaf->origin()[1] + (row & 7), leaf->origin()[2] + last);
        };
        for (auto value = leaf->cbeginValueOn(); value; ++value) {
            if (!(amount(*value) > least)) continue;
            const int n = int(value.pos());
            if (n >> 3 != row) {
                end_row();
                row = n >> 3;
                plane = &planes[leaf->origin()[0] + (row >> 3)];
                plane->add(leaf->origin()[1] + (row & 7), leaf->origin()[2] + (n & 7));
            }
            last = n & 7;
        }
        end_row();
    }
    for (auto& [x, plane] : planes)
        for (const auto& at : plane.corners()) {
            const openvdb::Coord voxel(x, int(at[0]), int(at[1]));
            add_corners({voxel, voxel}, reach, grid.transform(), out);
        }
    return out;
}

template<typename GridT>
std::vector<Vec3d> corners_above_fraction(const GridT& grid, double fraction)
{
    return corners_above(grid, std::max(0.0f, float(fraction * greatest(grid))), 0.5);
}

}  // namespace

std::vector<Vec3d> occupied_corners(const FloatGrid& grid, double fraction)
{
    return corners_above_fraction(grid, fraction);
}

std::vector<Vec3d> occupied_corners(const Vec3SGrid& grid, double fraction)
{
    return corners_above_fraction(grid, fraction);
}

std::vector<Vec3d> interpolant_corners(const FloatGrid& grid) { return corners_above(grid, 0, 1); }

std::vector<Vec3d> interpolant_corners(const Vec3SGrid& grid) { return corners_above(grid, 0, 1); }

}  // namespace vdbcloud
