#pragma once
// Converts the arrays of the solves to grids of phi, flux and moments with metadata. Private to scatter/.
#include "vdbcloud/scatter/multiple_scattering.h"

#include <functional>

namespace vdbcloud {

/// Collided light of one solve, per slot. Components and harmonics are about the world's axes.
struct Solution {
    std::vector<float> phi;
    std::array<std::vector<float>, 3> flux;
    std::vector<std::vector<float>> moments;  ///< by harmonic, from degree 1 on; empty for P1
    std::vector<float> heating;               ///< heating_rate(); empty unless asked for
    std::vector<float> ground;                ///< radiance of the ground's cells (ground.h); empty without a ground
};

/// A channel's collided light as a multiple of one solution: `scale` times the solution of channel `of`.
struct Share {
    int of = 0;
    double scale = 1;
};

/// Makes phi, flux and moments from degree 2 to `degree` of the three channels, named, with their metadata; scaling and
/// flux_limit are given. `stamp` writes what else the grids have in common. `shares[0]` is {0, 1}.
void collided_grids(const VoxelIndex&, const std::array<Solution, 3>&, const std::array<Share, 3>& shares, int degree,
                    const std::function<void(GridBase&)>& stamp, CollidedLight&);

}  // namespace vdbcloud
