#pragma once
// What tests of scatter/ share without OpenVDB's headers: small density grids, and the problem of P1 on one.
#include "support/voxel_field.h"
#include "vdbcloud/optics/phase_function.h"
#include "vdbcloud/scatter/p1_problem.h"

#include <array>
#include <vector>

namespace vdbcloud::test {

inline PhaseFunction hg(double g) { return PhaseFunction::henyey_greenstein(g); }

/// A vector grid of one value, active where `grid` is active.
Vec3SGridPtr constant_like(const FloatGrid& grid, const Vec3f& value);

/// A density with the voxel index, slot values and exposed voxels that P1 needs.
struct P1Case {
    explicit P1Case(const FloatGridPtr& of, std::array<bool, 3> periodic = {false, false, false})
        : grid(of), index(*of, {periodic}), density(index.gather(*of)), exposed(exposed_voxels(index, density))
    {
    }
    FloatGridPtr grid;
    VoxelIndex index;
    std::vector<float> density;
    std::vector<ExposedVoxel> exposed;
};

}  // namespace vdbcloud::test
