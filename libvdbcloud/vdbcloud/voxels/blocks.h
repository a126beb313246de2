#pragma once
// Sparse sets of voxels as blocks of 8^3 voxels. Hot loops use flat arrays over these blocks instead of trees.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <cstddef>
#include <vector>

namespace vdbcloud {

/// The voxels of one block as bits: word x, bit y * 8 + z.
using BlockMask = std::array<uint64_t, 8>;

struct Block {
    Vec3i at;        ///< block coordinates; the block holds voxels 8 at .. 8 at + 7
    BlockMask mask;  ///< the active voxels of the block
};

/// Blocks sorted by coordinates, x slowest. A field over them is a flat array of slots() values; the value of voxel
/// (x, y, z) of block b, each coordinate 0..7, is at slot b * 512 + x * 64 + y * 8 + z.
///
/// The last block, number count(), is the void block: its voxels are inactive and every field is 0 there. It replaces
/// each missing neighbour, so loops need no test for missing blocks.
///
/// Periodic axes: `period` is the number of blocks after which the domain repeats (0: not periodic). Block coordinates
/// on a periodic axis are 0 .. period - 1.
class Blocks {
public:
    static constexpr int edge = 8, size = 512;
    enum Face { XMinus, XPlus, YMinus, YPlus, ZMinus, ZPlus };

    Blocks() = default;
    /// Sorts the blocks and drops those without active voxels, but for `with_void`. Block coordinates must be distinct.
    explicit Blocks(std::vector<Block> blocks, const Vec3i& period = Vec3i(0, 0, 0), bool with_void = false);

    size_t count() const { return blocks_.size(); }
    size_t slots() const { return (blocks_.size() + 1) * size; }
    size_t active_count() const { return active_count_; }
    const Vec3i& period() const { return period_; }
    const Vec3i& at(size_t block) const { return blocks_[block].at; }
    const BlockMask& mask(size_t block) const { return blocks_[block].mask; }
    /// The six neighbours of a block, indexed by Face; count() for a missing neighbour.
    const std::array<int32_t, 6>& neighbours(size_t block) const { return neighbours_[block]; }
    /// The index of the block with these coordinates (wrapped on periodic axes); count() if there is none.
    int32_t find(Vec3i at) const;

    bool active(size_t slot) const
    {
        const size_t block = slot / size;
        return block < count() && (blocks_[block].mask[slot / 64 % 8] >> (slot % 64) & 1);
    }
    /// The slot next to an active slot across a face; a slot of the void block if the neighbour's block is missing.
    size_t neighbour(size_t slot, int face) const;
    /// Voxel coordinates of a slot.
    Vec3i voxel(size_t slot) const;
    /// The slot of an active or inactive voxel (wrapped on periodic axes); a slot of the void block if the voxel's
    /// block is missing.
    size_t slot(const Vec3i& voxel) const;

private:
    std::vector<Block> blocks_;
    std::vector<std::array<int32_t, 6>> neighbours_;
    Vec3i period_{0, 0, 0};
    size_t active_count_ = 0;
};

/// A box of active voxels 0 .. n - 1. Throws InputError if a periodic extent is not a multiple of 8.
Blocks box_blocks(const Vec3i& n, const std::array<bool, 3>& periodic = {false, false, false});

}  // namespace vdbcloud
