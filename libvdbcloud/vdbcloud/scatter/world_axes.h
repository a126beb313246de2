#pragma once
// Rotates flux and moments between a grid's index axes, used by the solvers, and the world's axes. Private to scatter/.
#include "vdbcloud/voxels/voxel_index.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// World components of a flux given per slot by its components along the index axes.
std::array<std::vector<float>, 3> flux_in_world(const VoxelIndex&, std::array<std::vector<float>, 3> flux);

/// Moments in real spherical harmonics (optics/spherical_harmonics.h) about the world's axes, up to `degree` <= 7, from
/// moments about the index axes. One array per moment with a value per slot, by rising l and m. The index axes may be
/// mirrored. The array of degree 0 stays empty, as P1's phi gives that moment.
std::vector<std::vector<float>> moments_in_world(const VoxelIndex&, const std::vector<std::vector<float>>& moments,
                                                 int degree);

/// The same from moments about the world's axes to those about the index axes.
std::vector<std::vector<float>> moments_in_index(const VoxelIndex&, const std::vector<std::vector<float>>& moments,
                                                 int degree);

/// Flux from moments of degree 1, components along the axes of the moments.
std::array<std::vector<float>, 3> flux_of(const std::vector<std::vector<float>>& moments);

}  // namespace vdbcloud
