#pragma once
// What the report of one channel says of its neighbours. Private to scatter/.
#include "vdbcloud/scatter/multiple_scattering.h"

namespace vdbcloud {

/// The report of a channel whose solution is `scale` times that of `from`.
ChannelReport multiple_of(const ChannelReport& from, double scale);

}  // namespace vdbcloud
