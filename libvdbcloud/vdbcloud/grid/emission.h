#pragma once
// Where a grid of emission shines, whether a grid Cd changes the albedo, and what a grid of temperature says of its
// values.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// True if the emission, which may be null, has an active value other than 0.
bool emits(const Vec3SGrid* emission);

/// True if the grid Cd, which may be null, has an active value other than 1.
bool tints(const Vec3SGrid* tint);

/// True if an active value of emission, one of its channels above 0, lies where density is 0: at a voxel's centre, or
/// at a corner of a tile. The transforms may differ.
bool emits_outside(const Vec3SGrid& emission, const FloatGrid& density);

/// True if the metadata of a temperature say what its values are in kelvin: by the unit K, a scale or an offset.
bool says_kelvin(const MetaMap& temperature);

}  // namespace vdbcloud
