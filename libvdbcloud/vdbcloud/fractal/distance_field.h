#pragma once
// Distances to the border of a set of voxels. Private to fractal/.
#include "vdbcloud/core/fwd.h"

#include <cstdint>
#include <vector>

namespace vdbcloud {

/// Signed Euclidean distances [world] on a box of size[0] x size[1] x size[2] voxels of edges `step`, third
/// index fastest: for a voxel of the set (inside[v] != 0) to the nearest voxel centre without, less half a
/// step; for the others that distance, negative. Exact, by lower envelopes of parabolas axis by axis (Felzenszwalb
/// and Huttenlocher, Distance transforms of sampled functions, 2012), in time proportional to the voxels.
/// Where the set is empty or all, -+1e15. Half a step is half the shortest edge. Threads: all of TBB's.
/// Memory: one float a voxel.
std::vector<float> signed_distance(const Vec3i& size, const Vec3d& step, const std::vector<uint8_t>& inside);

}  // namespace vdbcloud
