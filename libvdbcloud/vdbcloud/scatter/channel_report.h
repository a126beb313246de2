#pragma once
// What the report of one channel says of its neighbours and of its sides. Private to scatter/.
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud {

/// The report of a channel whose solution is `scale` times that of `from`.
ChannelReport multiple_of(const ChannelReport& from, double scale);

/// Sums reflected and transmitted from the planes. `to_sun`: towards the first sun, nothing without one. `top`: the
/// plane that faces up.
void set_sides(const VoxelIndex&, const std::optional<Vec3d>& to_sun, int top, ChannelReport&);

}  // namespace vdbcloud
