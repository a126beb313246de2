#include "vdbcloud/voxels/box_medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/voxel_transform.h"

#include <cmath>
#include <string>

namespace vdbcloud {

namespace {

constexpr double most_voxels = 1 << 28;

/// Throws InputError that names the box by its number, from 1.
void require(bool good, size_t number, const std::string& what)
{
    if (!good) throw InputError("box " + std::to_string(number) + ": " + what);
}

/// The voxels whose centre (i + 1/2) cell lies in [low, high).
openvdb::CoordBBox voxels_of(const MediumBox& box, const Vec3d& cell)
{
    openvdb::Coord low, high;
    for (int a = 0; a < 3; ++a) {
        low[a] = int(std::ceil(box.low[a] / cell[a] - 0.5));
        high[a] = int(std::ceil(box.high[a] / cell[a] - 0.5)) - 1;
    }
    return {low, high};
}

/// Returns the number of voxels.
double checked(const MediumBox& box, const Vec3d& cell, size_t number)
{
    double voxels = 1;
    for (int a = 0; a < 3; ++a) {
        const double most = 1e9 * cell[a];
        require(std::abs(box.low[a]) < most && std::abs(box.high[a]) < most, number,
                "expected corners within 1e9 voxels of the origin");
        require(box.low[a] < box.high[a], number, "expected each low coordinate below the high one");
        voxels *= (box.high[a] - box.low[a]) / cell[a];
    }
    for (const double value : {box.extinction, box.emission})
        require(value >= 0 && std::isfinite(value), number, "expected extinction and emission of 0 or above");
    return voxels;
}

template<typename GridT>
std::shared_ptr<GridT> with_cells(const Vec3d& cell)
{
    auto grid = GridT::create(typename GridT::ValueType(0.0f));
    const auto transform = voxel_transform(cell);
    transform->postTranslate(0.5 * cell);
    grid->setTransform(transform);
    return grid;
}

}  // namespace

void check(const std::vector<MediumBox>& boxes, const Vec3d& cell)
{
    double voxels = 0;
    for (size_t k = 0; k < boxes.size(); ++k) {
        voxels += checked(boxes[k], cell, k + 1);
        require(voxels <= most_voxels, k + 1,
                "expected at most 2^28 voxels in the sum of all boxes: make --cell larger");
    }
}

BoxMedium box_medium(const std::vector<MediumBox>& boxes, const Vec3d& cell)
{
    check(boxes, cell);
    bool emits = false;
    for (const MediumBox& box : boxes) emits = emits || box.emission > 0;
    BoxMedium medium{with_cells<FloatGrid>(cell), emits ? with_cells<Vec3SGrid>(cell) : nullptr};
    medium.extinction->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (const MediumBox& box : boxes) {
        const auto where = voxels_of(box, cell);
        medium.extinction->fill(where, float(box.extinction), box.extinction > 0);
        if (emits) medium.emission->fill(where, Vec3f(float(box.emission)), box.emission > 0);
    }
    return medium;
}

}  // namespace vdbcloud
