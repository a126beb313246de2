#pragma once
// Power of an unattenuated beam through a voxel's face. Private to scatter/.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/light.h"

namespace vdbcloud {

/// Power up an axis through a voxel's lower face (`up` 0) or upper face (`up` 1), for a light of strength 1
/// [hbar^2 x strength]. Computed from the face's area for a light of one direction, else by
/// LightModel::power_through().
class FreeFlux {
public:
    FreeFlux(const P1Operator&, const Light&);
    double operator()(size_t slot, int axis, int up) const;
    /// The flux through every face across an axis, of a light of one direction; 0 for another light.
    double common(int axis) const { return same_everywhere_ ? constant_[axis] : 0; }

private:
    const VoxelIndex& index_;
    const Light& light_;
    bool same_everywhere_;
    double constant_[3], unit_;
};

}  // namespace vdbcloud
