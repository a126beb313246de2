#pragma once
// A grid repacked for trilinear sampling along rays: no tree access inside 8^3 cells, and rays skip empty space.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/voxels/period.h"
#include "vdbcloud/voxels/ranked_bits.h"

#include <array>
#include <functional>
#include <vector>

namespace vdbcloud {

/// The trilinear interpolant of a grid of one or three channels, as a sparse set of bricks.
///
/// Cell (i,j,k) is the box between the voxel centres (i,j,k) and (i+1,j+1,k+1). Brick b covers the 8^3 cells 8b ..
/// 8b+7. A brick stores 9^3 corner values, one channel after the other, corner (x,y,z) at (x*9 + y)*9 + z. Without a
/// brick every corner value is outside(). Inactive voxels have the value outside(), whatever value the tree stores. A
/// brick inside a constant tile costs one index, because bricks of one value share storage. The tables about a brick
/// that lies alone take 6 KB, whatever lies between it and others.
///
/// With a period the interpolant repeats without end along the axes of that period: the cell after the last voxel lies
/// between that voxel and the first one. The map then holds the cells first .. first + length - 1.
///
/// Affine transforms only. Immutable after construction, so any number of threads may read.
class BrickMap {
public:
    static constexpr int size = 8;
    static constexpr int sx = 81, sy = 9;  ///< offsets to the next corner along x, y (along z: 1)
    using Map = std::function<float(float)>;

    /// Repacks `grid`. `map`, unless empty, is applied to each active value; `outside` is not mapped.
    /// Throws InputError if the transform is not affine.
    explicit BrickMap(const FloatGrid& grid, float outside = 0, const Map& map = {}, const Period& = {});

    explicit BrickMap(const Vec3SGrid& grid, float outside = 0, const Map& map = {}, const Period& = {});

    /// The corner values of brick b, 729 for each channel; null if there is no brick. Of a map with a period b holds
    /// cells of that period.
    const float* find(const Vec3i& b) const;

    /// The interpolant at a point in index space.
    double sample(const Vec3d& index) const;
    /// All three channels of the interpolant. A grid of one channel gives three equal values.
    Vec3d sample3(const Vec3d& index) const;

    int channels() const { return channels_; }
    bool empty() const { return bricks_.empty(); }
    float outside() const { return outside_; }
    const Period& period() const { return period_; }  ///< lengths 0: the interpolant does not repeat
    bool repeats() const { return repeats_; }
    const Affine& index_from_world() const { return index_from_world_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// First and last cell (inclusive) of the box outside which the interpolant is outside(); of a map with a period,
    /// of one period.
    const Vec3i& first_cell() const { return first_cell_; }
    const Vec3i& last_cell() const { return last_cell_; }
    const std::vector<Vec3i>& bricks() const { return bricks_; }  ///< coordinates, sorted
    size_t bytes() const;

    /// A box of 4096^3 cells, and the part of this box that bricks fill.
    struct Root {
        Vec3i origin;              ///< in units of 4096 cells
        Vec3i first, last;         ///< cells, inclusive
        RankedBits<32768> supers;  ///< of 32^3 places, those that hold bricks
        int32_t first_super = 0;   ///< number of the first of these
        /// Of 8^3 places of 512^3 cells, those that hold bricks: bit z of byte y of word x.
        std::array<uint64_t, 8> groups{};
    };
    const std::vector<Root>& roots() const { return roots_; }
    /// A box about roots: two boxes of root_boxes(), or the root ~child[0].
    struct RootBox {
        Vec3i first, last;  ///< cells, inclusive
        std::array<int32_t, 2> child{};
    };
    /// All roots as a tree of boxes, box 0 about all; rays test the boxes that they meet. Empty without bricks.
    const std::vector<RootBox>& root_boxes() const { return root_boxes_; }
    /// The number of the 16^3 bricks about a cell of a root; -1: no bricks.
    static int32_t super_at(const Root& root, const Vec3i& cell)
    {
        const int place = ((cell[0] >> 7) & 31) << 10 | ((cell[1] >> 7) & 31) << 5 | ((cell[2] >> 7) & 31);
        return root.supers.has(place) ? root.first_super + root.supers.rank(place) : -1;
    }
    /// log2 of the edge of a box without bricks about a cell without a brick, aligned to its edge: 3, 5, 7 or 9.
    /// `super`: super_at() the cell.
    int empty_shift(const Root& root, int32_t super, const Vec3i& cell) const
    {
        if (super >= 0) {
            const int bit = ((cell[0] >> 5) & 3) << 4 | ((cell[1] >> 5) & 3) << 2 | ((cell[2] >> 5) & 3);
            return supers_[size_t(super)].groups >> bit & 1 ? 3 : 5;
        }
        const int bit = ((cell[1] >> 9) & 7) << 3 | ((cell[2] >> 9) & 7);
        return root.groups[size_t((cell[0] >> 9) & 7)] >> bit & 1 ? 7 : 9;
    }
    /// The number of the brick about a cell, from 0 to bricks().size() - 1; -1: no brick.
    int32_t number_at(int32_t super, const Vec3i& cell) const
    {
        const Super& in = supers_[size_t(super)];
        const int place = ((cell[0] >> 3) & 15) << 8 | ((cell[1] >> 3) & 15) << 4 | ((cell[2] >> 3) & 15);
        return in.bricks.has(place) ? in.first + in.bricks.rank(place) : -1;
    }
    /// The number of brick b; -1: no brick.
    int32_t number(const Vec3i& b) const;
    /// The slot of a brick's values, for brick(); bricks of one value share a slot.
    int32_t slot(int32_t number) const { return slots_[size_t(number)]; }
    const float* brick(int32_t slot) const { return values_.data() + size_t(slot) * 729 * size_t(channels_); }
    /// Whether all values of a slot are equal, those of all channels.
    bool constant(int32_t slot) const { return constant_[size_t(slot)] != 0; }

private:
    template<typename GridT>
    void build(const GridT& grid, const Map& map);
    void cut_to_period();
    const float* corners(const Vec3d& place, Vec3d& fraction) const;
    const Root* root(const Vec3i& origin) const;
    void index_bricks(const std::vector<int32_t>& slots);
    int32_t add_root_box(int32_t* begin, int32_t* end);
    struct Super {
        RankedBits<4096> bricks;
        int32_t first = 0;    // in slots_
        uint64_t groups = 0;  // of 4^3 places of 4^3 bricks, those that hold bricks
    };

    float outside_;
    int channels_;
    Period period_;
    bool repeats_;
    Affine index_from_world_, world_from_index_;
    Vec3i first_cell_{0, 0, 0}, last_cell_{-1, -1, -1};
    std::vector<Vec3i> bricks_;
    std::vector<Root> roots_;
    std::vector<RootBox> root_boxes_;
    std::vector<Super> supers_;   // root by root, by place
    std::vector<int32_t> slots_;  // super by super, by place
    std::vector<float> values_;
    std::vector<uint8_t> constant_;  // of each slot
};

/// The affine maps of a transform. Throw InputError naming `grid_name` if the transform is not affine.
Affine world_from_index(const Transform&, const std::string& grid_name);
Affine index_from_world(const Transform&, const std::string& grid_name);

}  // namespace vdbcloud
