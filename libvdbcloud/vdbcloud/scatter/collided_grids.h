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
};

/// A channel's collided light as a multiple of one solution: `scale` times the solution of channel `of`.
struct Share {
    int of = 0;
    double scale = 1;
};

/// Makes the grids of the three channels, moments from degree 2 to `degree`. `stamp` writes the shared metadata.
ScatterFields collided_grids(const VoxelIndex&, const std::array<Solution, 3>&, const std::array<Share, 3>&, int degree,
                             const std::function<void(GridBase&)>& stamp);

}  // namespace vdbcloud
