#pragma once
// Flux and moments turned from a grid's index axes, about which the solvers work, to the world's axes.
#include "vdbcloud/voxels/voxel_index.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// World components of a flux that is given per slot by its components along the index axes.
std::array<std::vector<float>, 3> flux_in_world(const VoxelIndex&, std::array<std::vector<float>, 3> flux);

/// Moments in real spherical harmonics (optics/spherical_harmonics.h) about the world's axes, up to `degree` <= 7, from
/// those about the index axes: each an array per slot, by rising l and m. The index axes may be mirrored. Degree 0 is
/// left empty: P1's phi is that.
std::vector<std::vector<float>> moments_in_world(const VoxelIndex&, const std::vector<std::vector<float>>& moments,
                                                 int degree);

/// The flux, from moments of degree 1 about the same axes.
std::array<std::vector<float>, 3> flux_of(const std::vector<std::vector<float>>& moments);

}  // namespace vdbcloud
