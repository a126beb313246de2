#pragma once
// From one level of a multigrid to the next: which voxels, and which coefficients. Private to solve/.
#include "vdbcloud/solve/stencil.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// How the blocks of one level lie in those of the next coarser one.
struct CoarseMap {
    std::vector<int32_t> parent;                   ///< of each fine block
    std::vector<uint8_t> octant;                   ///< of each fine block in its parent: x * 4 + y * 2 + z
    std::vector<std::array<int32_t, 8>> children;  ///< of each coarse block by octant; the fine void block where none
};

/// Groups of 2x2x2. On a periodic axis with an odd number of blocks the coarse level covers two periods.
Blocks coarse_blocks(const Blocks& fine, CoarseMap& map);

/// Coefficients of the coarse stencil (multigrid.h), and what of its extra is boundary conductance.
void coarse_stencil(const Stencil& fine, const std::vector<float>& fine_boundary, const CoarseMap& map, Stencil& coarse,
                    std::vector<float>& coarse_boundary);

}  // namespace vdbcloud
