#pragma once
// The cloud of puffs: a small cloud with true voids, the standing case of comparisons with path-traced references.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud::test {

/// Fourteen Gaussian puffs cut off at a threshold, 48^3 voxels in a cube of edge 1, at random but fixed places.
FloatGridPtr cloud_of_puffs();

/// The extinction per density [1/world unit] at which the thickest column of voxels along y has the optical depth tau.
double extinction_of_puffs(const FloatGrid& puffs, double tau);

}  // namespace vdbcloud::test
