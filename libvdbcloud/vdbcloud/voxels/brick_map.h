#pragma once
// A grid repacked for trilinear sampling along rays: no tree access inside 8^3 cells, and rays skip empty space.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/voxels/period.h"

#include <functional>
#include <vector>

namespace vdbcloud {

/// The trilinear interpolant of a grid of one or three channels, as a sparse set of bricks.
///
/// Cell (i,j,k) is the box between the voxel centres (i,j,k) and (i+1,j+1,k+1). Brick b covers the 8^3 cells 8b ..
/// 8b+7. A brick stores 9^3 corner values, one channel after the other, corner (x,y,z) at (x*9 + y)*9 + z. Without a
/// brick every corner value is outside(). Inactive voxels have the value outside(), whatever value the tree stores. A
/// brick inside a constant tile costs one index, because bricks of one value share storage.
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

    /// A box of 4096^3 cells, and the part of this box that bricks fill. Rays test the roots and skip space between.
    struct Root {
        Vec3i origin;                 ///< in units of 4096 cells
        Vec3i first, last;            ///< cells, inclusive
        std::vector<int32_t> supers;  ///< 32^3 indices for super(), each of 16^3 bricks; -1: no bricks
    };
    const std::vector<Root>& roots() const { return roots_; }
    const int32_t* super(int32_t index) const { return supers_.data() + size_t(index) * 4096; }
    const float* brick(int32_t slot) const { return values_.data() + size_t(slot) * 729 * size_t(channels_); }

private:
    template<typename GridT>
    void build(const GridT& grid, const Map& map);
    void cut_to_period();
    const float* corners(const Vec3d& place, Vec3d& fraction) const;
    const Root* root(const Vec3i& origin) const;
    void index_bricks(const std::vector<int32_t>& slots);

    float outside_;
    int channels_;
    Period period_;
    bool repeats_;
    Affine index_from_world_, world_from_index_;
    Vec3i first_cell_{0, 0, 0}, last_cell_{-1, -1, -1};
    std::vector<Vec3i> bricks_;
    std::vector<Root> roots_;
    std::vector<int32_t> supers_;
    std::vector<float> values_;
};

/// The affine maps of a transform. Throw InputError naming `grid_name` if the transform is not affine.
Affine world_from_index(const Transform&, const std::string& grid_name);
Affine index_from_world(const Transform&, const std::string& grid_name);

}  // namespace vdbcloud
