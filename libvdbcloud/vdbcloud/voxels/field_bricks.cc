#include "vdbcloud/voxels/field_bricks.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace vdbcloud {

namespace {

using openvdb::Coord;

/// Voxels about a brick: its corners and one layer around them.
constexpr int edge = 11, voxels = edge * edge * edge;
constexpr int place_of(int x, int y, int z) { return ((x + 1) * edge + y + 1) * edge + z + 1; }

float channel(float value, int) { return value; }
float channel(const Vec3f& value, int c) { return value[c]; }

/// The 27 blocks of 8^3 voxels about a brick of one grid, block (x,y,z), -1 <= x,y,z <= 1, at ((x+1)*3 + y+1)*3 + z+1.
template<typename GridT>
struct Around {
    using Leaf = typename GridT::TreeType::LeafNodeType;
    struct Block {
        const Leaf* leaf = nullptr;
        typename GridT::ValueType tile{};
        bool active = false;  // of a tile
    };
    std::array<Block, 27> block;

    Around(const openvdb::tree::ValueAccessor<const typename GridT::TreeType>& from, const Vec3i& b)
    {
        for (int n = 0; n < 27; ++n) {
            const Coord origin(8 * (b[0] + n / 9 - 1), 8 * (b[1] + n / 3 % 3 - 1), 8 * (b[2] + n % 3 - 1));
            Block& to = block[size_t(n)];
            to.leaf = from.probeConstLeaf(origin);
            if (!to.leaf) to.active = from.probeValue(origin, to.tile);
        }
    }

    /// Calls visit(block, offset in it, place) for voxels x0..x1 along each axis of the layer around the brick.
    template<typename Visit>
    void each(int first, int last, const Visit& visit) const
    {
        for (int n = 0; n < 27; ++n) {
            const Block& from = block[size_t(n)];
            if (from.leaf ? from.leaf->isEmpty() : !from.active) continue;
            const int at[3] = {8 * (n / 9 - 1), 8 * (n / 3 % 3 - 1), 8 * (n % 3 - 1)};
            int lo[3], hi[3];
            for (int a = 0; a < 3; ++a) {
                lo[a] = std::max(first, at[a]);
                hi[a] = std::min(last, at[a] + 7);
            }
            for (int x = lo[0]; x <= hi[0]; ++x)
                for (int y = lo[1]; y <= hi[1]; ++y)
                    for (int z = lo[2]; z <= hi[2]; ++z) {
                        const auto offset = openvdb::Index((x - at[0]) << 6 | (y - at[1]) << 3 | (z - at[2]));
                        if (!from.leaf || from.leaf->isValueOn(offset)) visit(from, offset, x, y, z);
                    }
        }
    }
};

/// A corner without a voxel, and its active neighbours.
struct Fringe {
    int corner;                    // (x*9 + y)*9 + z
    std::vector<uint16_t> places;  // place_of()
};

/// The corners of a brick that are in the fringe, by which voxels about it are active.
std::vector<Fringe> fringe_of(const std::array<uint8_t, voxels>& active)
{
    std::vector<Fringe> fringe;
    for (int x = 0; x < 9; ++x)
        for (int y = 0; y < 9; ++y)
            for (int z = 0; z < 9; ++z) {
                const int place = place_of(x, y, z);
                if (active[size_t(place)]) continue;
                Fringe found{(x * 9 + y) * 9 + z, {}};
                for (int d = 0; d < 27; ++d) {
                    const int beside = place_of(x + d / 9 - 1, y + d / 3 % 3 - 1, z + d % 3 - 1);
                    if (active[size_t(beside)]) found.places.push_back(uint16_t(beside));
                }
                if (!found.places.empty()) fringe.push_back(std::move(found));
            }
    return fringe;
}

/// What neighbouring grids of one brick share: grids of one topology have one fringe.
struct Scratch {
    std::array<uint8_t, voxels> active, before;
    std::vector<float> values;
    std::vector<Fringe> fringe;
    bool known = false;
};

template<typename GridT>
void fill(const Around<GridT>& around, int channels, const FieldBricks::Field& field, float* to, int stride, Scratch& s)
{
    if (!field.fringe) {
        around.each(0, 8, [&](const auto& block, openvdb::Index offset, int x, int y, int z) {
            const auto value = block.leaf ? block.leaf->getValue(offset) : block.tile;
            float* corner = to + ((x * 9 + y) * 9 + z) * stride;
            for (int c = 0; c < channels; ++c) {
                const float v = channel(value, c);
                corner[c] = field.map ? field.map(v) : v;
            }
        });
        return;
    }
    s.values.resize(size_t(3 * voxels));
    s.active.fill(0);
    around.each(-1, 9, [&](const auto& block, openvdb::Index offset, int x, int y, int z) {
        const auto value = block.leaf ? block.leaf->getValue(offset) : block.tile;
        const int place = place_of(x, y, z);
        s.active[size_t(place)] = 1;
        float* corner =
            x >= 0 && y >= 0 && z >= 0 && x < 9 && y < 9 && z < 9 ? to + ((x * 9 + y) * 9 + z) * stride : nullptr;
        for (int c = 0; c < channels; ++c) {
            const float v = channel(value, c), mapped = field.map ? field.map(v) : v;
            s.values[size_t(c * voxels + place)] = mapped;
            if (corner) corner[c] = mapped;
        }
    });
    if (!s.known || s.active != s.before) {
        s.fringe = fringe_of(s.active);
        s.before = s.active;
        s.known = true;
    }
    for (const Fringe& f : s.fringe)
        for (int c = 0; c < channels; ++c) {
            double sum = 0;
            for (const uint16_t place : f.places) sum += s.values[size_t(c * voxels + place)];
            to[f.corner * stride + c] = float(sum / double(f.places.size()));
        }
}

}  // namespace

FieldBricks::FieldBricks(const BrickMap& map, const std::vector<Field>& fields)
{
    std::vector<int> first;
    for (const Field& field : fields) {
        first.push_back(count_);
        const bool one = field.grid->isType<FloatGrid>();
        if (!one && !field.grid->isType<Vec3SGrid>())
            throw InputError("grid '" + printable(field.grid->getName()) + "' is " + field.grid->valueType() +
                             ": expected float or vec3s");
        count_ += one ? 1 : 3;
    }
    places_.assign(map.bricks().size(), -1);
    std::vector<Vec3i> stored;
    for (const Vec3i& b : map.bricks()) {
        const int32_t number = map.number(b);
        const float* corner = map.brick(map.slot(number));
        if (std::all_of(corner, corner + 729, [](float v) { return v == 0; })) continue;
        places_[size_t(number)] = int32_t(stored.size());
        stored.push_back(b);
    }
    bricks_ = stored.size();
    const size_t size = 729 * size_t(count_), room = 8;
    values_.reset(new float[stored.size() * size + room]);
    std::fill_n(values_.get() + stored.size() * size, room, 0.0f);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, stored.size(), 64), [&](const tbb::blocked_range<size_t>& range) {
        Scratch scratch;
        std::vector<openvdb::tree::ValueAccessor<const openvdb::FloatTree>> floats;
        std::vector<openvdb::tree::ValueAccessor<const openvdb::Vec3STree>> vectors;
        for (const Field& field : fields)
            if (const auto one = openvdb::gridPtrCast<FloatGrid>(field.grid))
                floats.emplace_back(one->constTree());
            else
                vectors.emplace_back(openvdb::gridPtrCast<Vec3SGrid>(field.grid)->constTree());
        for (size_t n = range.begin(); n < range.end(); ++n) {
            float* const values = values_.get() + n * size;
            std::fill_n(values, size, 0.0f);
            scratch.known = false;
            auto one = floats.begin();
            auto three = vectors.begin();
            for (size_t k = 0; k < fields.size(); ++k)
                if (fields[k].grid->isType<FloatGrid>())
                    fill(Around<FloatGrid>(*one++, stored[n]), 1, fields[k], values + first[k], count_, scratch);
                else
                    fill(Around<Vec3SGrid>(*three++, stored[n]), 3, fields[k], values + first[k], count_, scratch);
        }
    });
}

}  // namespace vdbcloud
