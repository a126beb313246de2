#pragma once
// Private to scatter/. Whether rays follow the light of emission up to its first collision, and what they cost.
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud {

/// The part of emission that rays follow: all where at most a twentieth of the medium's voxels emit, nothing from a
/// tenth on, in between linear in their number, so that light does not jump as a fire grows. P1 and sweeps take the
/// other part. Emission of a large part of the medium has no small bright sources, and P1 and sweeps are exact where it
/// is isothermal.
double share_by_rays(double emitting, double voxels);

/// Whether the options let rays follow emission: not in periodic media, not over a ground, not beside solids
/// that sweeps meet, and not with the limiter.
bool allows_rays(const ScatterOptions&);

/// Whether the box about the voxels is small enough: the rays' power through its planes is found cell by cell. Planes
/// of 2^20 cells, or of 16 for each voxel, are; else few voxels lie far apart, and P1 and sweeps take their emission.
bool box_allows_rays(const Blocks&);

/// What the time of the rays is in proportion to, within a factor of about two: the voxels times the logarithm to base
/// 2 of 1 and the emitting voxels; 0 where no rays follow.
double emission_steps(const FloatGrid& density, const Vec3SGrid& emission, const ScatterOptions&);

}  // namespace vdbcloud
