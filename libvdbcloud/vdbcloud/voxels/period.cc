#include "vdbcloud/voxels/period.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/lattice.h"

#include <cmath>
#include <utility>
#include <vector>

namespace vdbcloud {

namespace {

constexpr double same_place = 1e-4;  // [voxels], as lattice_shift()
constexpr double same_axis = 1e-6;   // [voxels] across an axis, for each voxel along it

/// Active voxels of one value.
template<typename Value>
struct Filled {
    openvdb::CoordBBox box;
    Value value;
};

/// The active voxels of the layer `at` across an axis, moved by `shift` along it.
template<typename GridT>
void add_layer(const GridT& grid, int axis, int at, int shift, std::vector<Filled<typename GridT::ValueType>>& out)
{
    const auto moved = [&](openvdb::CoordBBox box) {
        box.min()[axis] = box.max()[axis] = at + shift;
        return box;
    };
    const auto meets = [&](const openvdb::CoordBBox& box) { return box.min()[axis] <= at && at <= box.max()[axis]; };
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (!meets(leaf->getNodeBoundingBox())) continue;
        for (auto v = leaf->cbeginValueOn(); v; ++v) {
            const openvdb::Coord p = v.getCoord();
            if (p[axis] == at) out.push_back({moved({p, p}), *v});
        }
    }
    for_each_active_tile(grid, [&](const auto& tile) {
        const openvdb::CoordBBox box = tile.getBoundingBox();
        if (meets(box)) out.push_back({moved(box), *tile});
    });
}

/// The active part of a grid within a box. OpenVDB's clip() would fill the faces of the box with leaves: where the box
/// is without end along an axis, those are 262 144 leaves a face for each 4096 voxels of it.
template<typename GridT>
typename GridT::Ptr part_within(const GridT& grid, const openvdb::CoordBBox& inside)
{
    auto out = grid.copyWithNewTree();
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const openvdb::CoordBBox box = leaf->getNodeBoundingBox();
        if (!inside.hasOverlap(box)) continue;
        if (inside.isInside(box)) {
            out->tree().addLeaf(new typename GridT::TreeType::LeafNodeType(*leaf));
            continue;
        }
        for (auto v = leaf->cbeginValueOn(); v; ++v)
            if (inside.isInside(v.getCoord())) out->tree().setValueOn(v.getCoord(), *v);
    }
    for_each_active_tile(grid, [&](const auto& tile) {
        openvdb::CoordBBox box = tile.getBoundingBox();
        box.intersect(inside);
        if (!box.empty()) out->tree().sparseFill(box, *tile, true);
    });
    return out;
}

template<typename GridT>
typename GridT::Ptr wrapped_copy(const GridT& grid, const Period& period)
{
    openvdb::CoordBBox inside = openvdb::CoordBBox::inf();
    for (int a = 0; a < 3; ++a) {
        if (period.length[a] == 0) continue;
        inside.min()[a] = period.first[a];
        inside.max()[a] = period.first[a] + period.length[a] - 1;
    }
    const auto out = part_within(grid, inside);
    // One axis after the other, so that edges and corners are copied from layers that are already there.
    for (int a = 0; a < 3; ++a) {
        if (period.length[a] == 0) continue;
        std::vector<Filled<typename GridT::ValueType>> layers;
        add_layer(*out, a, inside.min()[a], period.length[a], layers);
        add_layer(*out, a, inside.max()[a], -period.length[a], layers);
        for (const auto& filled : layers) {
            if (filled.box.volume() == 1)
                out->tree().setValueOn(filled.box.min(), filled.value);
            else
                out->tree().sparseFill(filled.box, filled.value, true);
        }
    }
    return out;
}

}  // namespace

Vec3d Period::home(const Vec3d& p) const
{
    Vec3d out = p;
    for (int a = 0; a < 3; ++a) {
        if (length[a] == 0) continue;
        out[a] -= std::floor((p[a] - first[a]) / length[a]) * length[a];
        if (!(out[a] >= first[a] && out[a] < first[a] + length[a])) out[a] = first[a];  // rounding at the seam
    }
    return out;
}

Vec3i Period::home(const Vec3i& voxel) const
{
    Vec3i out = voxel;
    for (int a = 0; a < 3; ++a) {
        if (length[a] == 0) continue;
        const int beyond = (voxel[a] - first[a]) % length[a];
        out[a] = first[a] + (beyond < 0 ? beyond + length[a] : beyond);
    }
    return out;
}

Period period_of(const FloatGrid& density, const std::array<bool, 3>& axes)
{
    Period period;
    if (!axes[0] && !axes[1] && !axes[2]) return period;
    const openvdb::CoordBBox box = density.evalActiveVoxelBoundingBox();
    for (int a = 0; a < 3 && !box.empty(); ++a) {
        if (!axes[size_t(a)]) continue;
        period.first[a] = box.min()[a];
        period.length[a] = box.dim()[a];
    }
    return period;
}

Period period_in(const Period& period, const Transform& of_density, const GridBase& grid)
{
    if (!period.any()) return period;
    const Affine map = index_map(of_density, grid.transform());
    Period out;
    for (int a = 0; a < 3; ++a) {
        if (period.length[a] == 0) continue;
        const auto refuse = [&](const std::string& why) {
            throw InputError("grid '" + printable(grid.getName()) + "': the medium repeats along " + "xyz"[a] +
                             ", and " + why + ": expected the axes of the density and whole voxels in its period");
        };
        const Vec3d step = map.vector(Vec3d(a == 0, a == 1, a == 2)) * period.length[a];
        for (int b = 0; b < 3; ++b)
            if (b != a && (std::abs(step[b]) > same_place || std::abs(map.a[size_t(a)][b]) > same_axis))
                refuse("the axes of the grid point elsewhere");
        const double length = std::round(step[a]);
        if (!(std::abs(step[a] - length) < same_place && length >= 1))
            refuse("a period is " + std::to_string(step[a]) + " voxels of the grid");
        out.length[a] = int(length);
        // The face where the period begins.
        Vec3d face(period.first[0], period.first[1], period.first[2]);
        face[a] -= 0.5;
        out.first[a] = int(std::lround(map.point(face)[a] + 0.5));
    }
    return out;
}

FloatGridPtr wrapped(const FloatGrid& grid, const Period& period) { return wrapped_copy(grid, period); }
Vec3SGridPtr wrapped(const Vec3SGrid& grid, const Period& period) { return wrapped_copy(grid, period); }

}  // namespace vdbcloud
