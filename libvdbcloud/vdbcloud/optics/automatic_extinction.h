#pragma once
// An extinction for a density whose maker did not say what it means.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// Optical depth of a typical line of sight through a density of unit extinction: with c the integral of
/// density along a column of voxels [density x world unit], the mean of c over columns weighted by c itself,
///
///     sum c^2 / sum c,
///
/// averaged over the grid's three axes. Weighting by mass makes thin veils and empty surroundings count for
/// nothing; for a uniform sphere of radius R it is 3 R / 2 (here in columns of 8 x 8 voxels, so up to that
/// discretisation). 0 for an empty density. Scales with the grid and turns with it.
double typical_depth(const FloatGrid& density);

/// The sigma_t per density that makes typical_depth an optical depth of `target`: 9 lets a cloud be opaque in
/// its body and translucent at its edges. 1 for an empty density.
double automatic_extinction(const FloatGrid& density, double target = 9);

}  // namespace vdbcloud
