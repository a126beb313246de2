#pragma once
// Several grids on one lattice, repacked together for rays that have to read all of them at each point.
#include "vdbcloud/voxels/brick_map.h"

#include <memory>
#include <vector>

namespace vdbcloud {

/// Values of several grids at the corners of the bricks of a map. A corner holds all values side by side: count()
/// floats, a vector grid has three. Corner (x,y,z) of a brick is at ((x*9 + y)*9 + z) * count().
///
/// Bricks of the map whose corners are all 0 have no values: rays never visit their cells. Filled from the leaves'
/// buffers, over all threads; the values do not depend on threads. Immutable.
class FieldBricks {
public:
    struct Field {
        GridBasePtr grid;   ///< float or vec3s, on the lattice of the map
        BrickMap::Map map;  ///< applied to active values, unless empty; inactive voxels are 0 and not mapped
        /// Corners without an active voxel have the mean of the active ones among their 26 neighbours, as
        /// with_fringe() has it.
        bool fringe;
    };

    /// The map has no period. Throws InputError for a grid of another type.
    FieldBricks(const BrickMap& map, const std::vector<Field>& fields);

    int count() const { return count_; }
    /// Of the values of one of count() [bytes].
    double bytes_of_value() const { return 729.0 * sizeof(float) * double(bricks_); }
    /// The corners of a brick by BrickMap's number; null for a brick of zeros. Seven floats after the last corner can
    /// be read and mean nothing.
    const float* brick(int32_t number) const
    {
        const int32_t place = places_[size_t(number)];
        return place < 0 ? nullptr : values_.get() + size_t(place) * 729 * size_t(count_);
    }

private:
    int count_ = 0;
    size_t bricks_ = 0;  // with values
    std::vector<int32_t> places_;
    std::unique_ptr<float[]> values_;
};

}  // namespace vdbcloud
