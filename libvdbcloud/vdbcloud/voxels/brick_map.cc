#include "vdbcloud/voxels/brick_map.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace vdbcloud {

namespace {

Vec3i brick_of(const openvdb::Coord& ijk) { return {ijk[0] >> 3, ijk[1] >> 3, ijk[2] >> 3}; }

/// Source of the values of an 8^3 block of voxels: a leaf or a constant tile.
template<typename GridT>
struct Block {
    using Value = typename GridT::ValueType;
    using Leaf = typename GridT::TreeType::LeafNodeType;
    Vec3i b;
    const Leaf* leaf;
    Value tile;
    int low;  ///< bit a: the first layer along axis a has a voxel other than `outside`
};

bool before(const Vec3i& p, const Vec3i& q)
{
    return p[0] != q[0] ? p[0] < q[0] : p[1] != q[1] ? p[1] < q[1] : p[2] < q[2];
}

/// Leaves and tiles of the active part of a tree, sorted by position.
template<typename GridT>
std::vector<Block<GridT>> blocks_of(const GridT& grid)
{
    std::vector<Block<GridT>> blocks;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        if (leaf->isEmpty()) continue;
        int low = 0;
        for (auto v = leaf->cbeginValueOn(); v && low != 7; ++v) {
            const auto n = v.pos();
            low |= (n < 64 ? 1 : 0) | ((n & 56) == 0 ? 2 : 0) | ((n & 7) == 0 ? 4 : 0);
        }
        blocks.push_back({brick_of(leaf->origin()), leaf.getLeaf(), {}, low});
    }
    for_each_active_tile(grid, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        const Vec3i lo = brick_of(box.min()), hi = brick_of(box.max());
        for (int x = lo[0]; x <= hi[0]; ++x)
            for (int y = lo[1]; y <= hi[1]; ++y)
                for (int z = lo[2]; z <= hi[2]; ++z) blocks.push_back({{x, y, z}, nullptr, *tile, 7});
    });
    std::sort(blocks.begin(), blocks.end(), [](auto& p, auto& q) { return before(p.b, q.b); });
    return blocks;
}

template<typename B>
const B* find(const std::vector<B>& blocks, const Vec3i& b)
{
    const auto it = std::lower_bound(blocks.begin(), blocks.end(), b, [](auto& p, auto& q) { return before(p.b, q); });
    return it != blocks.end() && it->b == b ? &*it : nullptr;
}

/// A cell needs the voxels at its upper corners. So a block also feeds the brick below each face whose layer has a
/// voxel other than `outside`.
template<typename B>
std::vector<Vec3i> bricks_fed_by(const std::vector<B>& blocks)
{
    std::vector<Vec3i> bricks;
    bricks.reserve(blocks.size() * 2);
    for (const auto& block : blocks)
        for (int n = 0; n < 8; ++n)
            if ((n & block.low) == n)
                bricks.push_back({block.b[0] - (n & 1), block.b[1] - ((n >> 1) & 1), block.b[2] - ((n >> 2) & 1)});
    std::sort(bricks.begin(), bricks.end(), before);
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    return bricks;
}

float channel(float value, int) { return value; }
float channel(const Vec3f& value, int c) { return value[c]; }

/// Copies the corner values of brick b from the eight blocks it touches.
template<typename B>
void fill(const std::vector<B>& blocks, const Vec3i& b, float outside, int channels, const BrickMap::Map& map,
          float* corner)
{
    std::fill(corner, corner + 729 * channels, outside);
    for (int n = 0; n < 8; ++n) {
        const Vec3i d(n & 1, (n >> 1) & 1, (n >> 2) & 1);
        const B* block = find(blocks, b + d);
        if (!block) continue;
        for (int x = 0; x < (d[0] ? 1 : 8); ++x)
            for (int y = 0; y < (d[1] ? 1 : 8); ++y)
                for (int z = 0; z < (d[2] ? 1 : 8); ++z) {
                    const auto offset = openvdb::Index((x << 6) | (y << 3) | z);
                    if (block->leaf && !block->leaf->isValueOn(offset)) continue;
                    const auto value = block->leaf ? block->leaf->getValue(offset) : block->tile;
                    float* to = corner + (x + 8 * d[0]) * BrickMap::sx + (y + 8 * d[1]) * BrickMap::sy + z + 8 * d[2];
                    for (int c = 0; c < channels; ++c) {
                        const float v = channel(value, c);
                        to[729 * c] = map ? map(v) : v;
                    }
                }
    }
}

}  // namespace

Affine world_from_index(const Transform& transform, const std::string& grid_name)
{
    if (!transform.isLinear())
        throw InputError("grid '" + printable(grid_name) +
                         "': its transform is not affine: expected scale, rotation, "
                         "shear and translation only");
    const auto m = transform.baseMap()->getAffineMap()->getMat4();  // row vectors: p m
    Affine f;
    for (int r = 0; r < 3; ++r) f.a[r] = {m(0, r), m(1, r), m(2, r)};
    f.b = {m(3, 0), m(3, 1), m(3, 2)};
    return f;
}

Affine index_from_world(const Transform& transform, const std::string& grid_name)
{
    world_from_index(transform, grid_name);  // throws if not affine
    const auto m = transform.baseMap()->getAffineMap()->getMat4().inverse();
    Affine f;
    for (int r = 0; r < 3; ++r) f.a[r] = {m(0, r), m(1, r), m(2, r)};
    f.b = {m(3, 0), m(3, 1), m(3, 2)};
    return f;
}

BrickMap::BrickMap(const FloatGrid& grid, float outside, const Map& map, const Period& period)
    : outside_(outside), channels_(1), period_(period), repeats_(period.any()),
      index_from_world_(vdbcloud::index_from_world(grid.transform(), grid.getName())),
      world_from_index_(vdbcloud::world_from_index(grid.transform(), grid.getName()))
{
    repeats_ ? build(*wrapped(grid, period_), map) : build(grid, map);
}

BrickMap::BrickMap(const Vec3SGrid& grid, float outside, const Map& map, const Period& period)
    : outside_(outside), channels_(3), period_(period), repeats_(period.any()),
      index_from_world_(vdbcloud::index_from_world(grid.transform(), grid.getName())),
      world_from_index_(vdbcloud::world_from_index(grid.transform(), grid.getName()))
{
    repeats_ ? build(*wrapped(grid, period_), map) : build(grid, map);
}

/// Removes bricks without a cell of the period.
void BrickMap::cut_to_period()
{
    const auto outside = [&](const Vec3i& b) {
        for (int a = 0; a < 3; ++a) {
            const int last = period_.first[a] + period_.length[a] - 1;
            if (period_.length[a] > 0 && (b[a] < period_.first[a] >> 3 || b[a] > last >> 3)) return true;
        }
        return false;
    };
    bricks_.erase(std::remove_if(bricks_.begin(), bricks_.end(), outside), bricks_.end());
}

template<typename GridT>
void BrickMap::build(const GridT& grid, const Map& map)
{
    const auto blocks = blocks_of(grid);
    bricks_ = bricks_fed_by(blocks);
    if (repeats_) cut_to_period();

    // Bricks of one value (inside tiles) share storage. All other bricks are filled in parallel, in chunks. The chunks
    // are joined in order, so slots do not depend on threads.
    constexpr size_t chunk = 1024;
    const size_t size_of_brick = 729 * size_t(channels_);
    std::map<float, int32_t> constants;
    std::vector<int32_t> slots;
    std::vector<float> scratch(std::min(chunk, bricks_.size()) * size_of_brick);
    for (size_t begin = 0; begin < bricks_.size(); begin += chunk) {
        const size_t count = std::min(chunk, bricks_.size() - begin);
        tbb::parallel_for(size_t(0), count, [&](size_t n) {
            fill(blocks, bricks_[begin + n], outside_, channels_, map, scratch.data() + n * size_of_brick);
        });
        for (size_t n = 0; n < count; ++n) {
            const float* corner = scratch.data() + n * size_of_brick;
            const bool same = std::all_of(corner, corner + size_of_brick, [&](float v) { return v == corner[0]; });
            auto slot = int32_t(values_.size() / size_of_brick);
            if (same) slot = constants.emplace(corner[0], slot).first->second;
            if (size_t(slot) * size_of_brick == values_.size()) {
                values_.insert(values_.end(), corner, corner + size_of_brick);
                constant_.push_back(same);
            }
            slots.push_back(slot);
        }
    }
    index_bricks(slots);
}

void BrickMap::index_bricks(const std::vector<int32_t>& slots)
{
    const auto origin_of = [](const Vec3i& b) { return Vec3i(b[0] >> 9, b[1] >> 9, b[2] >> 9); };
    const auto super_place = [](const Vec3i& b) {
        return ((b[0] >> 4) & 31) << 10 | ((b[1] >> 4) & 31) << 5 | ((b[2] >> 4) & 31);
    };
    const auto place = [](const Vec3i& b) { return (b[0] & 15) << 8 | (b[1] & 15) << 4 | (b[2] & 15); };
    std::map<std::array<int, 3>, Root> found;
    for (const Vec3i& b : bricks_) {
        const Vec3i origin = origin_of(b), first = b * size, last = first + Vec3i(size - 1);
        Root& r =
            found.try_emplace({origin[0], origin[1], origin[2]}, Root{origin, first, last, {}, 0, {}}).first->second;
        r.supers.set(super_place(b));
        r.groups[size_t(b[0] >> 6 & 7)] |= uint64_t(1) << ((b[1] >> 6 & 7) << 3 | (b[2] >> 6 & 7));
        for (int a = 0; a < 3; ++a) {
            r.first[a] = std::min(r.first[a], first[a]);
            r.last[a] = std::max(r.last[a], last[a]);
        }
    }
    int32_t supers = 0;
    for (auto& [origin, r] : found) {
        r.first_super = supers;
        supers += r.supers.count();
        roots_.push_back(r);
    }
    found.clear();
    supers_.resize(size_t(supers));
    const auto super_of = [&](const Vec3i& b) -> Super& {
        return supers_[size_t(super_at(*root(origin_of(b)), b * size))];
    };
    for (const Vec3i& b : bricks_) {
        Super& super = super_of(b);
        super.bricks.set(place(b));
        super.groups |= uint64_t(1) << ((b[0] >> 2 & 3) << 4 | (b[1] >> 2 & 3) << 2 | (b[2] >> 2 & 3));
    }
    int32_t first = 0;
    for (Super& super : supers_) {
        super.first = first;
        first += super.bricks.count();
    }
    slots_.resize(bricks_.size());
    for (size_t n = 0; n < bricks_.size(); ++n) {
        const Super& super = super_of(bricks_[n]);
        slots_[size_t(super.first + super.bricks.rank(place(bricks_[n])))] = slots[n];
    }
    for (auto& r : roots_)
        for (int a = 0; a < 3; ++a) {
            if (period_.length[a] > 0) {
                r.first[a] = std::max(r.first[a], period_.first[a]);
                r.last[a] = std::min(r.last[a], period_.first[a] + period_.length[a] - 1);
            }
            const bool only = &r == &roots_.front();
            first_cell_[a] = only ? r.first[a] : std::min(first_cell_[a], r.first[a]);
            last_cell_[a] = only ? r.last[a] : std::max(last_cell_[a], r.last[a]);
        }
    std::vector<int32_t> order(roots_.size());
    for (size_t n = 0; n < order.size(); ++n) order[n] = int32_t(n);
    if (!order.empty()) add_root_box(order.data(), order.data() + order.size());
}

/// Adds the box about some roots, halved across its longest edge down to single roots. Returns its number.
int32_t BrickMap::add_root_box(int32_t* begin, int32_t* end)
{
    RootBox box{roots_[size_t(*begin)].first, roots_[size_t(*begin)].last, {~*begin, ~*begin}};
    for (const int32_t* n = begin; n < end; ++n)
        for (int a = 0; a < 3; ++a) {
            box.first[a] = std::min(box.first[a], roots_[size_t(*n)].first[a]);
            box.last[a] = std::max(box.last[a], roots_[size_t(*n)].last[a]);
        }
    const auto number = int32_t(root_boxes_.size());
    root_boxes_.push_back(box);
    if (end - begin == 1) return number;
    int longest = 0;
    for (int a = 1; a < 3; ++a)
        if (double(box.last[a]) - box.first[a] > double(box.last[longest]) - box.first[longest]) longest = a;
    int32_t* middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](int32_t p, int32_t q) {
        const Vec3i &a = roots_[size_t(p)].origin, &b = roots_[size_t(q)].origin;
        return a[longest] != b[longest] ? a[longest] < b[longest] : p < q;
    });
    const int32_t low = add_root_box(begin, middle), high = add_root_box(middle, end);
    root_boxes_[size_t(number)].child = {low, high};
    return number;
}

const BrickMap::Root* BrickMap::root(const Vec3i& origin) const
{
    if (roots_.size() <= 8) {
        for (const auto& r : roots_)
            if (r.origin == origin) return &r;
        return nullptr;
    }
    const auto r =
        std::lower_bound(roots_.begin(), roots_.end(), origin, [](auto& p, auto& q) { return before(p.origin, q); });
    return r != roots_.end() && r->origin == origin ? &*r : nullptr;
}

int32_t BrickMap::number(const Vec3i& b) const
{
    const Root* r = root({b[0] >> 9, b[1] >> 9, b[2] >> 9});
    if (!r) return -1;
    const int32_t s = super_at(*r, b * size);
    return s < 0 ? -1 : number_at(s, b * size);
}

const float* BrickMap::find(const Vec3i& b) const
{
    const int32_t n = number(b);
    return n < 0 ? nullptr : brick(slot(n));
}

const float* BrickMap::corners(const Vec3d& place, Vec3d& fraction) const
{
    const Vec3d index = repeats_ ? period_.home(place) : place;
    // Beyond the first and last cell every value is `outside`. The test also keeps the integer conversion in range.
    for (int a = 0; a < 3; ++a)
        if (!(index[a] >= first_cell_[a] && index[a] < double(last_cell_[a]) + 1)) return nullptr;
    const Vec3d low(std::floor(index[0]), std::floor(index[1]), std::floor(index[2]));
    const Vec3i cell{int(low[0]), int(low[1]), int(low[2])};
    fraction = index - low;
    const float* c = find({cell[0] >> 3, cell[1] >> 3, cell[2] >> 3});
    return c ? c + (cell[0] & 7) * sx + (cell[1] & 7) * sy + (cell[2] & 7) : nullptr;
}

namespace {
double interpolate(const float* c, const Vec3d& f)
{
    constexpr int sx = BrickMap::sx, sy = BrickMap::sy;
    const auto lerp = [](double p, double q, double t) { return p + (q - p) * t; };
    const auto edge = [&](const float* v) { return lerp(v[0], v[1], f[2]); };
    return lerp(lerp(edge(c), edge(c + sy), f[1]), lerp(edge(c + sx), edge(c + sx + sy), f[1]), f[0]);
}
}  // namespace

double BrickMap::sample(const Vec3d& index) const
{
    Vec3d fraction;
    const float* c = corners(index, fraction);
    return c ? interpolate(c, fraction) : outside_;
}

Vec3d BrickMap::sample3(const Vec3d& index) const
{
    Vec3d fraction;
    const float* c = corners(index, fraction);
    if (!c) return Vec3d(outside_);
    if (channels_ == 1) return Vec3d(interpolate(c, fraction));
    return {interpolate(c, fraction), interpolate(c + 729, fraction), interpolate(c + 2 * 729, fraction)};
}

size_t BrickMap::bytes() const
{
    return values_.size() * sizeof(float) + constant_.size() + roots_.size() * (sizeof(Root) + 2 * sizeof(RootBox)) +
           supers_.size() * sizeof(Super) + bricks_.size() * (sizeof(Vec3i) + sizeof(int32_t));
}

}  // namespace vdbcloud
