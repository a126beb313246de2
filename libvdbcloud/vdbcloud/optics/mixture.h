#pragma once
// Media that overlap and keep their phase functions: what they have in common, for solutions, light grids and files.
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/optics/joined_medium.h"

namespace vdbcloud {

/// The delta scaling of each part: delta_scaling() at `degree`, or no_scaling().
std::vector<DeltaScaling> scalings_of(const std::vector<MediumPart>&, int degree, bool delta);

/// The coefficients and scalings of all parts in words, for metadata; equal texts mean equal media:
/// "SIGMA_T ALBEDO PHASE, delta_f F; ...".
std::string mixture_text(const std::vector<MediumPart>&, const std::vector<DeltaScaling>&);

/// The fingerprints of all parts together: those of densities and of Cd, in the order of the parts, and that of the
/// emission, which may be null.
Sources sources_of(const std::vector<MediumPart>&, const Vec3SGrid* emission);

/// Whether two channels have one extinction in the scaled medium, at any place.
bool same_extinction(const std::vector<MediumPart>&, const std::vector<DeltaScaling>&, int channel, int other);

/// The scaled extinction of one channel, sum over parts of (1 - delta_f albedo) sigma_t [1/world unit], on the lattice
/// that the parts share; active where any part is.
FloatGridPtr extinction_of(const std::vector<MediumPart>&, const std::vector<DeltaScaling>&, int channel);

}  // namespace vdbcloud
