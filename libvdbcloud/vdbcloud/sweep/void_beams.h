#pragma once
// What the apron of any block sees through the void next to it, for one direction. Private to sweep/.
#include "vdbcloud/sweep/block_sweep.h"

#include <vector>

namespace vdbcloud {

/// The rays of one region of the apron, followed upstream from block to block. The blocks that they cross lie at the
/// same offsets about every block, so they are found once, and each block looks up which of them exist.
struct VoidBeam {
    /// What a ray gets from where it enters a block: four weighted values of that block's face.
    struct Entry {
        uint8_t ray;   ///< position in the region
        uint8_t face;  ///< traversal order
        uint8_t cell;  ///< the first of the four: it, the next and those 8 on
        float weight[4];
    };
    struct Crossing {
        Vec3i offset;   ///< of the block that is entered [blocks], from the block whose apron it is
        uint64_t rays;  ///< that enter it
        uint32_t first_entry, entries;
    };
    std::vector<Crossing> crossings;  ///< upstream: a ray meets them in this order
    std::vector<Entry> entries;

    /// Follows the rays until they have crossed `walls` walls.
    VoidBeam(const block_sweep::Traversal&, int region, int walls);
};

/// Where light that enters a block's face at `at` (voxels from the block's first voxel, by axis) met its last centres:
/// half a step before. `face` in traversal order; adds `share` of the four weights.
VoidBeam::Entry face_entry(const block_sweep::Traversal&, int face, const double* at, double share);

/// The first voxel of a region of the apron of the block at `block`, in block coordinates.
Vec3d region_corner(const block_sweep::Traversal&, int region, const Vec3i& block);
/// The axes (0..2) that run in a region, -1 where fewer than two do.
std::array<int, 2> region_runs(const block_sweep::Traversal&, int region);

}  // namespace vdbcloud
