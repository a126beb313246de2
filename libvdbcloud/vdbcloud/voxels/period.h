#pragma once
// One period of a medium that repeats without end along axes of its index space.
#include "vdbcloud/core/affine.h"

#include <array>

namespace vdbcloud {

/// A medium repeats along an axis after the voxels first .. first + length - 1. length 0: it does not repeat.
struct Period {
    Vec3i first{0, 0, 0}, length{0, 0, 0};

    bool any() const { return length[0] > 0 || length[1] > 0 || length[2] > 0; }
    /// The same place of the medium in first <= p < first + length on each repeating axis. Index space.
    Vec3d home(const Vec3d& p) const;
    Vec3i home(const Vec3i& voxel) const;
};

/// The rule of all programs: a density repeats, along each of `axes`, after the extent of its active voxels. Lengths
/// are 0 for a density without active voxels.
Period period_of(const FloatGrid& density, const std::array<bool, 3>& axes);

/// The same period in the voxels of another grid, whose points stand for voxels or parts of voxels of the density.
/// Throws InputError naming the grid if a period is no whole number of its voxels, or its axes are not the density's.
Period period_in(const Period&, const Transform& of_density, const GridBase& grid);

/// A copy of `grid` cut to one period. One more layer of voxels before and behind, along each repeating axis, holds the
/// values and states of the other end. Trilinear samples and neighbours are then complete within the period.
FloatGridPtr wrapped(const FloatGrid& grid, const Period&);
Vec3SGridPtr wrapped(const Vec3SGrid& grid, const Period&);

}  // namespace vdbcloud
