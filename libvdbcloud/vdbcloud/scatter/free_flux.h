#pragma once
// The power of a beam through a voxel's face if nothing is in its way. Private to scatter/.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/light.h"

namespace vdbcloud {

/// Up an axis through a voxel's lower face (`up` 0) or upper one, per irradiance [hbar^2], or by exact solid angle per
/// intensity of a point light.
class FreeFlux {
public:
    FreeFlux(const P1Operator&, const Light&);
    double operator()(size_t slot, int axis, int up) const;

private:
    const VoxelIndex& index_;
    const Light& light_;
    double constant_[3], unit_;
};

}  // namespace vdbcloud
