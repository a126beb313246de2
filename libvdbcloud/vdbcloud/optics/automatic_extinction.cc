#include "vdbcloud/optics/automatic_extinction.h"

#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <array>
#include <map>
#include <utility>

namespace vdbcloud {

namespace {

constexpr int block = 8;  // voxels along the edge of a column, and of a leaf

/// Sums of density x voxels along each column, for the three axes; columns are block x block voxels wide.
using Columns = std::array<std::map<std::pair<int, int>, double>, 3>;

/// Adds a body of uniform mean `value` over a box whose edges are multiples of a block (a tile), or one block
/// (a leaf).
void add(Columns& columns, const openvdb::Coord& origin, int edge, double value)
{
    const int blocks = edge / block;
    for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int a = 0; a < blocks; ++a)
            for (int b = 0; b < blocks; ++b)
                columns[size_t(axis)][{(origin[u] >> 3) + a, (origin[v] >> 3) + b}] += value * edge;
    }
}

Columns columns_of(const FloatGrid& density)
{
    Columns columns;
    for_each_active_tile(density, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        if (*tile > 0) add(columns, box.min(), box.dim()[0], *tile);
    });
    for (auto leaf = density.tree().cbeginLeaf(); leaf; ++leaf) {
        double sum = 0;
        for (auto value = leaf->cbeginValueOn(); value; ++value) sum += *value;
        if (sum > 0) add(columns, leaf->origin(), block, sum / (block * block * block));
    }
    return columns;
}

}  // namespace

double typical_depth(const FloatGrid& density)
{
    const Columns columns = columns_of(density);
    const Transform& transform = density.transform();
    const Vec3d origin = transform.indexToWorld(Vec3d(0.0));
    double mean = 0;
    for (int axis = 0; axis < 3; ++axis) {
        double sum = 0, squares = 0;
        for (const auto& [place, column] : columns[size_t(axis)]) {
            sum += column;
            squares += column * column;
        }
        Vec3d step(0.0);
        step[axis] = 1;
        const double voxel = (transform.indexToWorld(step) - origin).length();
        if (sum > 0) mean += voxel * squares / sum / 3;
    }
    return mean;
}

double automatic_extinction(const FloatGrid& density, double target)
{
    const double depth = typical_depth(density);
    return depth > 0 ? target / depth : 1;
}

}  // namespace vdbcloud
