#pragma once
// Rays through the void between blocks: where light that reaches a block's edge came from. Private to sweep/.
#include "vdbcloud/voxels/emptiness.h"
#include "vdbcloud/voxels/ranked_bits.h"

#include <unordered_map>
#include <vector>

namespace vdbcloud {

/// Finds, for a point in a block that is missing, the first block upstream of it.
///
/// Empty space is crossed in the largest empty cells (voxels/emptiness.h), so the cost of a gap hardly grows with its
/// width. Memory is in proportion to the blocks, wherever they lie. Periodic axes wrap, block by block.
///
/// Threads: immutable; any number of threads may call.
class VoidRays {
public:
    struct Hit {
        int32_t block = -1;  ///< -1: the sky
        int axes = 0;  ///< bits: of the block's faces that the ray meets, those towards +step; two or three on an edge
        double at[3];  ///< where, in voxels from the block's first voxel
    };

    explicit VoidRays(const Blocks&);

    /// From `point` (block coordinates, voxel centres at integers) against `step`, the direction light travels in, in
    /// voxels per unit length. `point` lies in a missing block. A ray through the common edge of blocks passes between
    /// those that it only touches, so that mirrored rays meet mirrored blocks.
    Hit trace(const Vec3d& point, const Vec3d& step) const;

    /// The same for a ray that meets none but these blocks, without a walk through emptiness; in a medium that ends on
    /// all sides. Time in proportion to `count`; ends to rounding of those of the walk.
    Hit trace(const Vec3d& point, const Vec3d& step, const int32_t* blocks, size_t count) const;

    /// As Blocks::find, in constant time.
    int32_t find(const Vec3i& at) const;

    size_t bytes() const;

private:
    /// 16^3 places of blocks, x slowest, of which most may be empty.
    struct Tile {
        RankedBits<4096> places;
        uint32_t first = 0;  ///< in order_

        /// Whether no block lies in the cell of 4^3 places about a place.
        bool empty_about(int place) const
        {
            const uint64_t columns = 0x000f000f000f000fu << (place & 12);
            const size_t word = size_t(place >> 10 << 4 | (place >> 6 & 3));
            return !((places.word(word) | places.word(word + 4) | places.word(word + 8) | places.word(word + 12)) &
                     columns);
        }
    };
    int32_t block(const Tile&, int place) const;

    const Blocks& blocks_;
    bool periodic_;
    Vec3i first_{0, 0, 0}, last_{-1, -1, -1};  // blocks
    std::unordered_map<Vec3i, Tile, CoordHash> tiles_;
    std::vector<int32_t> order_;  // blocks, tile by tile, by place
    Emptiness emptiness_;
    // Dense table of tiles where their box is small: a hash look-up would be most of the cost of a step.
    std::vector<const Tile*> dense_;
    Vec3i dense_first_{0, 0, 0}, dense_size_{0, 0, 0};
    const Tile* tile(const Vec3i& at) const;
};

}  // namespace vdbcloud
