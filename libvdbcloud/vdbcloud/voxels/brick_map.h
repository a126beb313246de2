#pragma once
// A grid repacked for trilinear sampling along rays: no tree walk inside 8^3 cells, empty space skipped.
#include "vdbcloud/core/affine.h"

#include <functional>
#include <vector>

namespace vdbcloud {

/// The trilinear interpolant of a grid of one or three channels, as a sparse set of bricks.
///
/// A cell (i,j,k) is the box between the voxel centres (i,j,k) and (i+1,j+1,k+1). A brick holds the 8^3 cells from
/// 8b on and, for each channel in turn, their 9^3 corner values, corner (x,y,z) at (x*9 + y)*9 + z. Where there is no
/// brick every corner is `outside()`. Inactive voxels count as `outside`, whatever the tree stores there. Constant
/// tiles cost an index each.
///
/// Affine transforms only. Immutable once made, so any number of threads may read it.
class BrickMap {
public:
    static constexpr int size = 8;
    static constexpr int sx = 81, sy = 9;  ///< offsets of the next corner along x, y (z: 1)
    using Map = std::function<float(float)>;

    /// Repacks `grid`; `map`, if any, is applied to each active value (and `outside` is taken as mapped already).
    /// Throws InputError if the transform is not affine.
    explicit BrickMap(const FloatGrid& grid, float outside = 0, const Map& map = {});

    explicit BrickMap(const Vec3SGrid& grid, float outside = 0, const Map& map = {});

    /// The 729 corner values of brick b (for each channel), or null.
    const float* find(const Vec3i& b) const;

    /// The interpolant at a point in index space.
    double sample(const Vec3d& index) const;
    /// All three channels of it; a grid of one channel gives it three times.
    Vec3d sample3(const Vec3d& index) const;

    int channels() const { return channels_; }
    bool empty() const { return bricks_.empty(); }
    float outside() const { return outside_; }
    const Affine& index_from_world() const { return index_from_world_; }
    const Affine& world_from_index() const { return world_from_index_; }
    /// Cells that may differ from outside, first and last (inclusive).
    const Vec3i& first_cell() const { return first_cell_; }
    const Vec3i& last_cell() const { return last_cell_; }
    const std::vector<Vec3i>& bricks() const { return bricks_; }  ///< coordinates, sorted
    size_t bytes() const;

    /// A box of 4096^3 cells and the part of it that bricks fill: rays test these and skip what lies between.
    struct Root {
        Vec3i origin;                 ///< in units of 4096 cells
        Vec3i first, last;            ///< cells, inclusive
        std::vector<int32_t> supers;  ///< 32^3 indices of 16^3 bricks, -1: none
    };
    const std::vector<Root>& roots() const { return roots_; }
    const int32_t* super(int32_t index) const { return supers_.data() + size_t(index) * 4096; }
    const float* brick(int32_t slot) const { return values_.data() + size_t(slot) * 729 * size_t(channels_); }

private:
    template<typename GridT>
    void build(const GridT& grid, const Map& map);
    const float* corners(const Vec3d& index, Vec3d& fraction) const;
    const Root* root(const Vec3i& origin) const;
    void index_bricks(const std::vector<int32_t>& slots);

    float outside_;
    int channels_;
    Affine index_from_world_, world_from_index_;
    Vec3i first_cell_{0, 0, 0}, last_cell_{-1, -1, -1};
    std::vector<Vec3i> bricks_;
    std::vector<Root> roots_;
    std::vector<int32_t> supers_;
    std::vector<float> values_;
};

/// The affine maps of a transform. Throws InputError naming `grid_name` if it is not affine.
Affine world_from_index(const Transform&, const std::string& grid_name);
Affine index_from_world(const Transform&, const std::string& grid_name);

}  // namespace vdbcloud
