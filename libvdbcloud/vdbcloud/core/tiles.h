#pragma once
// Loops over the tiles of a tree: constant regions of 8^3 voxels or more, stored above the leaves.

namespace vdbcloud {

/// Calls visit(tile) for each active tile of a grid, in the tree's order. Leaves are not visited. `tile` is OpenVDB's
/// iterator: *tile is the value, tile.getBoundingBox(box) gives the voxels of the tile, tile.setValue() changes the
/// value if the grid is not const.
template<typename GridT, typename Visit>
void for_each_active_tile(GridT& grid, const Visit& visit)
{
    auto tile = grid.tree().beginValueOn();
    tile.setMaxDepth(GridT::TreeType::DEPTH - 2);
    for (; tile; ++tile) visit(tile);
}

/// As for_each_active_tile(), for active and inactive tiles.
template<typename GridT, typename Visit>
void for_each_tile(GridT& grid, const Visit& visit)
{
    auto tile = grid.tree().beginValueAll();
    tile.setMaxDepth(GridT::TreeType::DEPTH - 2);
    for (; tile; ++tile) visit(tile);
}

}  // namespace vdbcloud
