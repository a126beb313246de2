#pragma once
// The order in which a sweep goes through octants and blocks. Private to sweep/.
#include "vdbcloud/voxels/blocks.h"

#include <array>
#include <utility>
#include <vector>

namespace vdbcloud {

class PatchLight;

namespace sweep_order {

using Sign = std::array<int, 3>;

inline Sign signs(int octant) { return {octant & 4 ? -1 : 1, octant & 2 ? -1 : 1, octant & 1 ? -1 : 1}; }

/// Octants whose directions go through the blocks together: two that differ along one axis, or one.
using Pass = std::vector<int>;

inline int bit_of(int axis) { return 4 >> axis; }

/// All octants; over a ground those first whose light it reflects.
std::vector<Pass> passes(int axis, const PatchLight* ground);

/// Blocks in upstream order for the octants of a pass. Columns of blocks run along one axis, upstream or downstream;
/// columns of a tile are in order, and tiles of one level do not depend on one another.
struct Order {
    std::vector<int32_t> block;
    std::vector<size_t> column;  ///< begin of each column in `block`, and the end
    std::vector<size_t> tile;    ///< begin of each tile in `column`, and the end
    std::vector<size_t> level;   ///< begin of each level in `tile`, and the end
    /// By block: where its light is kept, 0 .. places - 1. A place serves another block three levels on, when no block
    /// follows that is beside it.
    std::vector<int32_t> place;
    size_t places = 0;

    bool enough() const { return tile.size() > 6 * level.size(); }  ///< for threads
    size_t bytes() const
    {
        return (block.size() + place.size()) * sizeof(int32_t) +
               (column.size() + tile.size() + level.size()) * sizeof(size_t);
    }
};

/// Tiles of 2^bits x 2^bits columns along `axis`; signs across it.
Order order_of(const Blocks&, const Sign&, int axis, int bits);

/// Large tiles keep a block's upstream faces in the cache. They shrink, and columns run along another axis, where
/// levels would have too few tiles for threads.
std::pair<int, int> axis_and_bits(const Blocks&);

}  // namespace sweep_order
}  // namespace vdbcloud
