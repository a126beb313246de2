#pragma once
// Chooses an extinction for a density grid that comes without one.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// Optical depth of a typical line of sight through a density of unit extinction: with c the integral of
/// density along a column of voxels [density x world unit], the mean of c over columns weighted by c itself,
///
///     sum c^2 / sum c,
///
/// averaged over the grid's three axes. Weighting by c makes thin veils and empty surroundings negligible. For a
/// uniform sphere of radius R the value is 3 R / 2, up to the discretisation in columns of 8 x 8 voxels. 0 for an empty
/// density. The value scales with the grid's voxel size and does not depend on the grid's rotation.
double typical_depth(const FloatGrid& density);

/// The sigma_t per density that makes typical_depth an optical depth of `target`: at 9 a cloud is opaque in its
/// body and translucent at its edges. 1 for an empty density.
double automatic_extinction(const FloatGrid& density, double target = 9);

}  // namespace vdbcloud
