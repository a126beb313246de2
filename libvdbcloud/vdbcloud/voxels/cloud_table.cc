#include "vdbcloud/voxels/cloud_table.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/voxel_transform.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

FloatGridPtr empty_cloud(const CloudCells& cells)
{
    const int across = 3 - cells.up;
    Vec3d voxel(0, 0, 0), centre(0, 0, 0);
    voxel[0] = cells.size[0];
    voxel[across] = cells.size[1];
    voxel[cells.up] = cells.size[2];
    centre = 0.5 * voxel;
    centre[cells.up] += cells.base;
    auto grid = FloatGrid::create(0.0f);
    auto transform = voxel_transform(voxel);
    transform->postTranslate(centre);
    grid->setTransform(transform);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

openvdb::Coord voxel_at(const CloudCells& cells, size_t x, size_t side, size_t layer)
{
    openvdb::Coord at(int(x), 0, 0);
    at[3 - cells.up] = int(side);
    at[cells.up] = int(layer);
    return at;
}

constexpr double most_voxels = 1 << 28;

void require_room(double voxels)
{
    if (voxels > most_voxels)
        throw InputError("the cloud would have " + std::to_string(std::llround(voxels)) + " voxels: expected at most " +
                         std::to_string(std::llround(most_voxels)));
}

void require_amount(double value, const char* what, size_t x, size_t y)
{
    if (!(value >= 0) || !std::isfinite(value))
        throw InputError(std::string(what) + " " + std::to_string(value) + " in cell " + std::to_string(x) + ", " +
                         std::to_string(y) + ": expected 0 or above");
}

}  // namespace

FloatGridPtr section_cloud(size_t columns, size_t layers, int across, const CloudCells& cells,
                           const std::function<double(size_t, size_t)>& extinction)
{
    require_room(double(columns) * double(layers) * across);
    auto grid = empty_cloud(cells);
    auto set = grid->getAccessor();
    for (size_t x = 0; x < columns; ++x)
        for (size_t layer = 0; layer < layers; ++layer) {
            const double value = extinction(x, layer);
            require_amount(value, "extinction", x, layer);
            for (int side = 0; side < across && value > 0; ++side)
                set.setValueOn(voxel_at(cells, x, size_t(side), layer), float(value));
        }
    return grid;
}

FloatGridPtr column_cloud(size_t nx, size_t ny, const CloudCells& cells,
                          const std::function<double(size_t, size_t)>& depth,
                          const std::function<double(size_t, size_t)>& thickness)
{
    auto grid = empty_cloud(cells);
    auto set = grid->getAccessor();
    const double height = cells.size[2];
    double voxels = 0;
    for (size_t x = 0; x < nx; ++x)
        for (size_t y = 0; y < ny; ++y) {
            const double tau = depth(x, y), top = thickness(x, y);
            require_amount(tau, "optical depth", x, y);
            require_amount(top, "thickness", x, y);
            if (tau == 0) continue;
            if (top == 0)
                throw InputError("thickness 0 in column " + std::to_string(x) + ", " + std::to_string(y) +
                                 " of optical depth " + std::to_string(tau) + ": expected a thickness above 0");
            require_room(voxels += std::ceil(top / height));
            for (size_t layer = 0; double(layer) * height < top; ++layer) {
                const double share = std::min(1.0, top / height - double(layer));
                if (share > 0) set.setValueOn(voxel_at(cells, x, y, layer), float(tau / top * share));
            }
        }
    return grid;
}

}  // namespace vdbcloud
