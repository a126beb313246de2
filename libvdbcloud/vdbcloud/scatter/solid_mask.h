#pragma once
// The medium beside solids. Private to scatter/.
#include "vdbcloud/optics/solid_rays.h"

#include <array>

namespace vdbcloud {

/// The density without the voxels whose centre lies within a solid. Throws InputError for a medium that repeats, whose
/// solids would have to repeat with it.
FloatGridPtr without_solids(const FloatGrid&, const SolidRays&, const std::array<bool, 3>& periodic);

}  // namespace vdbcloud
