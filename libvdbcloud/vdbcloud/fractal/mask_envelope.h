#pragma once
// Any grid as an envelope.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/fractal/envelope.h"

namespace vdbcloud {

/// The region where `mask` is: for a level set where it is below 0, else where it is above `level` times its
/// greatest value, each sampled trilinearly, in world space, at the voxel centres of a domain of `size`
/// voxels. Depth: the distance to the border between those voxels, so the surface is known to half a voxel.
/// Nothing lies outside the domain.
///
/// Memory: 5 bytes a voxel of the domain while it is made, then 4. Throws InputError if no voxel of the
/// domain is inside.
EnvelopePtr mask_envelope(const FloatGrid& mask, const Box& domain, const Vec3i& size, double level = 0.02);

/// A box around the active voxels of the mask [world]. Throws InputError if nothing is.
Box mask_bounds(const FloatGrid& mask);

}  // namespace vdbcloud
