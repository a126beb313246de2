#pragma once
// The power of a beam through a voxel's face in a void. Private to scatter/.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/light.h"

namespace vdbcloud {

/// Up an axis through a voxel's lower face (`up` 0) or upper one, for a light of strength 1 [hbar^2 x strength]: by the
/// face's area for a light of one direction, else by LightModel::power_through().
class FreeFlux {
public:
    FreeFlux(const P1Operator&, const Light&);
    double operator()(size_t slot, int axis, int up) const;

private:
    const VoxelIndex& index_;
    const Light& light_;
    bool same_everywhere_;
    double constant_[3], unit_;
};

}  // namespace vdbcloud
