#pragma once
// Loops over what a tree holds above its leaves: constant regions of 8^3 voxels and more.

namespace vdbcloud {

/// Calls visit(tile) for each active tile of a grid, in the tree's order; leaves are not visited. `tile` is OpenVDB's
/// iterator: *tile is the value, tile.getBoundingBox(box) the voxels it stands for. A grid that is not const may be
/// changed through tile.setValue().
template<typename GridT, typename Visit>
void for_each_active_tile(GridT& grid, const Visit& visit)
{
    auto tile = grid.tree().beginValueOn();
    tile.setMaxDepth(GridT::TreeType::DEPTH - 2);
    for (; tile; ++tile) visit(tile);
}

/// As for_each_active_tile(), for inactive tiles as well.
template<typename GridT, typename Visit>
void for_each_tile(GridT& grid, const Visit& visit)
{
    auto tile = grid.tree().beginValueAll();
    tile.setMaxDepth(GridT::TreeType::DEPTH - 2);
    for (; tile; ++tile) visit(tile);
}

}  // namespace vdbcloud
