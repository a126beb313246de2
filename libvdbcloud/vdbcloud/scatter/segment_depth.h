#pragma once
// Optical depth between two points of a medium. Private to scatter/.
#include "vdbcloud/voxels/brick_map.h"

#include <vector>

namespace vdbcloud {

/// tau = extinction times the integral of the trilinear density from point to point, exact but for rounding. The
/// bricks whose values are all equal are crossed in one step, so that media made of boxes cost little.
class SegmentDepth {
public:
    /// Keeps a reference to `density`, which does not repeat.
    SegmentDepth(const BrickMap& density, double extinction);

    /// From `a` to `b` [world]. Where the depth is above `most` the integral may end before b.
    double operator()(const Vec3d& a, const Vec3d& b, double most) const;

private:
    const BrickMap& density_;
    double extinction_;
    std::vector<bool> uniform_;  // by slot of the map
};

}  // namespace vdbcloud
