#include "vdbcloud/core/half_range.h"

#include <openvdb/Types.h>

#include <cmath>

namespace vdbcloud {

void HalfRange::add(float x)
{
    const float size = std::abs(x);
    above_ = above_ || !(size <= largest_half);
    if (!(size > 0)) return;
    ++lit_;
    if (size < smallest_full_half && float(openvdb::math::half(x)) != x) ++faint_;
}

}  // namespace vdbcloud
