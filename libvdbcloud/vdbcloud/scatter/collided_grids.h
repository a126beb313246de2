#pragma once
// Collided light as grids: from the arrays of the solves to phi, flux and moments with their metadata.
#include "vdbcloud/scatter/multiple_scattering.h"

#include <functional>

namespace vdbcloud {

/// Collided light of one solve, per slot, about the world's axes.
struct Solution {
    std::vector<float> phi;
    std::array<std::vector<float>, 3> flux;
    std::vector<std::vector<float>> moments;  ///< by harmonic, from degree 1 on; empty for P1
};

/// Whose solution a channel has, and times what.
struct Share {
    int of = 0;
    double scale = 1;
};

/// Grids of the three channels; moments from degree 2 to `degree`. `stamp` writes the metadata that all of them bear.
ScatterFields collided_grids(const VoxelIndex&, const std::array<Solution, 3>&, const std::array<Share, 3>&, int degree,
                             const std::function<void(GridBase&)>& stamp);

}  // namespace vdbcloud
