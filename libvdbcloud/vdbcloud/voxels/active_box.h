#pragma once
// The box about the cells of a medium's active voxels, and the cells of its six planes.
#include "vdbcloud/voxels/blocks.h"

namespace vdbcloud {

/// First and last active voxel along each axis, in the blocks' voxel coordinates. The box reaches from `first` - 0.5 to
/// `last` + 0.5. Along a periodic axis the box is one period, and has no planes.
///
/// A plane is named by its outward side, Blocks::Face. Its cells are the outer faces of the box's outermost voxels.
/// They are numbered row by row: axes()[1] runs fastest.
struct ActiveBox {
    Vec3i first{0, 0, 0}, last{-1, -1, -1};
    std::array<bool, 3> periodic{false, false, false};

    /// Of a medium without voxels: empty.
    explicit ActiveBox(const Blocks&);

    bool empty() const { return last[0] < first[0]; }
    bool contains(const Vec3i& voxel) const;
    int size(int axis) const { return last[axis] - first[axis] + 1; }
    /// The axes within a plane across `axis`, in rising order.
    static std::array<int, 2> axes(int axis) { return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2}; }
    /// Number of cells of a plane; 0 across a periodic axis.
    size_t cells(int face) const;
    /// The cell of the plane `face` at a voxel of the box.
    size_t cell(int face, const Vec3i& voxel) const;
    /// The voxel behind a cell.
    Vec3i voxel(int face, size_t cell) const;
};

}  // namespace vdbcloud
