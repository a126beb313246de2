#pragma once
// How the voxels of one grid lie in the lattice of another grid.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/core/fwd.h"

#include <optional>

namespace vdbcloud {

/// The map from index space of `from` to index space of `to`. Throws InputError if a transform is not affine.
Affine index_map(const Transform& from, const Transform& to);

/// s with map(i) = i + s for all i in the box low .. high, to 1e-4 voxels; nothing if the two lattices differ in axes
/// or voxel size. Components within 1e-4 of a whole number are whole, so equal lattices give exactly 0.
std::optional<Vec3d> lattice_shift(const Affine& map, const Vec3d& low, const Vec3d& high);

/// True if every component is a whole number: the voxels of both lattices coincide.
bool is_whole(const Vec3d& shift);

}  // namespace vdbcloud
