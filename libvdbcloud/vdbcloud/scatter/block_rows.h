#pragma once
// Rows of eight voxels of a block and those beside them, as vectors. Private to scatter/: inlined into loops that are
// compiled for several instruction sets.
#include "vdbcloud/core/eight.h"
#include "vdbcloud/voxels/blocks.h"

namespace vdbcloud {

/// One block and its six neighbours. Row (x, y) are the voxels (x, y, 0..7). What is asked for at a distance d along an
/// axis (-2 to 1) may lie in a neighbour. Fields are 0 in missing blocks.
class BlockRows {
public:
    BlockRows(const Blocks& blocks, size_t block) : own_(block)
    {
        for (int face = 0; face < 6; ++face) beside_[face] = size_t(blocks.neighbours(block)[size_t(face)]);
        own_mask_ = &blocks.mask(block);
        for (int face = 0; face < 6; ++face)
            mask_[face] = beside_[face] < blocks.count() ? &blocks.mask(beside_[face]) : nullptr;
    }

    VDBCLOUD_INLINE static size_t slot(size_t block, int x, int y) { return block * 512 + size_t(x * 64 + y * 8); }
    VDBCLOUD_INLINE size_t slot(int x, int y) const { return slot(own_, x, y); }

    /// Values of a field at a distance d along an axis.
    template<int axis, int d, typename T>
    VDBCLOUD_INLINE eight::Row<T> at(const T* f, int x, int y) const
    {
        using namespace eight;
        if constexpr (axis == 2) {
            const Row<T> own = load(f + slot(x, y));
            if constexpr (d == 0) return own;
            const Row<T> other = load(f + slot(beside_[d < 0 ? 4 : 5], x, y));
            if constexpr (d == -2) return __builtin_shufflevector(other, own, 6, 7, 8, 9, 10, 11, 12, 13);
            if constexpr (d == -1) return __builtin_shufflevector(other, own, 7, 8, 9, 10, 11, 12, 13, 14);
            return __builtin_shufflevector(own, other, 1, 2, 3, 4, 5, 6, 7, 8);
        } else {
            const int to = (axis == 0 ? x : y) + d, in = to & 7;
            const size_t block = to < 0 ? beside_[2 * axis] : to > 7 ? beside_[2 * axis + 1] : own_;
            return load(f + (axis == 0 ? slot(block, in, y) : slot(block, x, in)));
        }
    }

    /// Which of these voxels are active, as bits.
    template<int axis, int d>
    VDBCLOUD_INLINE unsigned active(int x, int y) const
    {
        if constexpr (axis == 2) {
            const unsigned own = bits(own_mask_, x, y);
            if constexpr (d == 0) return own;
            if constexpr (d < 0)
                return (own << -d | bits(mask_[4], x, y) >> (8 + d)) & 255;
            else
                return own >> d | (bits(mask_[5], x, y) << (8 - d) & 255);
        } else {
            const int to = (axis == 0 ? x : y) + d, in = to & 7;
            const BlockMask* mask = to < 0 ? mask_[2 * axis] : to > 7 ? mask_[2 * axis + 1] : own_mask_;
            return axis == 0 ? bits(mask, in, y) : bits(mask, x, in);
        }
    }

private:
    VDBCLOUD_INLINE static unsigned bits(const BlockMask* mask, int x, int y)
    {
        return mask ? unsigned((*mask)[size_t(x)] >> (8 * y) & 255) : 0u;
    }
    size_t own_, beside_[6];
    const BlockMask *own_mask_, *mask_[6];
};

}  // namespace vdbcloud
