#pragma once
// Two small clouds of Gaussians, the standing cases of comparisons with path-traced references.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud::test {

/// Fourteen Gaussian puffs cut off at a threshold, 48^3 voxels in a cube of edge 1, at random but fixed places.
FloatGridPtr cloud_of_puffs();
/// Six overlapping Gaussian blobs, set to 0 where their sum is below 0.15 of its peak: edges are thin. 48^3 voxels in a
/// cube of edge 1.
FloatGridPtr cloud_of_blobs();

/// The same trilinear medium by voxels of half the edge, but for its kinks.
FloatGridPtr at_half_the_voxel(const FloatGrid& cloud);

/// The extinction per density [1/world unit] at which the thickest column of voxels along y has the optical depth tau.
double extinction_for(const FloatGrid& cloud, double tau);

}  // namespace vdbcloud::test
