#pragma once
// Small density grids from functions, without OpenVDB's headers.
#include "vdbcloud/optics/phase_function.h"

#include <functional>

namespace vdbcloud::test {

inline PhaseFunction hg(double g) { return PhaseFunction::henyey_greenstein(g); }

/// Voxels 0 .. n - 1 of edges h [world unit] (lengths along x, y, z), active where f > 0. Voxel 0's centre is the
/// world's origin.
FloatGridPtr field(const Vec3i& n, const Vec3d& h, const std::function<double(const Vec3i&)>& f);

/// As above, with a given transform: x, y, z are the world vectors of one voxel step along each index axis.
FloatGridPtr field(const Vec3i& n, const Vec3d& x, const Vec3d& y, const Vec3d& z,
                   const std::function<double(const Vec3i&)>& f);

/// A vector grid of one value, active where `grid` is active.
Vec3SGridPtr constant_like(const FloatGrid& grid, const Vec3f& value);

}  // namespace vdbcloud::test
