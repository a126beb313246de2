#include "vdbcloud/voxels/voxel_index.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/extend.h"
#include "vdbcloud/voxels/voxel_mean.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <tuple>

namespace vdbcloud {

namespace {

constexpr double right_angle = 1e-5;  // largest cosine between axes that counts as a right angle

/// Masks of active voxels, by block coordinates.
struct Builder {
    std::map<std::tuple<int, int, int>, BlockMask> masks;

    BlockMask& at(int x, int y, int z) { return masks.try_emplace({x, y, z}, BlockMask{}).first->second; }
    void add(const openvdb::Coord& p)
    {
        at(p.x() >> 3, p.y() >> 3, p.z() >> 3)[p.x() & 7] |= uint64_t(1) << ((p.y() & 7) * 8 + (p.z() & 7));
    }
};

/// Masks of all active voxels with values above 0, at coordinates relative to `origin`.
Builder masks_of(const FloatGrid& grid, const openvdb::Coord& origin)
{
    Builder builder;
    const bool aligned = (origin.x() | origin.y() | origin.z()) % 8 == 0;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        BlockMask mask{};
        for (auto v = leaf->cbeginValueOn(); v; ++v) {
            if (!(*v > 0)) continue;
            if (aligned)
                mask[v.pos() / 64] |= uint64_t(1) << (v.pos() % 64);
            else
                builder.add(v.getCoord() - origin);
        }
        if (!aligned) continue;
        const openvdb::Coord at = leaf->origin() - origin;
        BlockMask& into = builder.at(at.x() >> 3, at.y() >> 3, at.z() >> 3);
        for (int w = 0; w < 8; ++w) into[w] |= mask[w];
    }
    for_each_active_tile(grid, [&](const auto& tile) {
        if (!(*tile > 0)) return;
        const openvdb::CoordBBox box = tile.getBoundingBox();
        for (auto p = box.begin(); p; ++p)
            if (!aligned)
                builder.add(*p - origin);
            else if (((*p).x() | (*p).y() | (*p).z()) % 8 == 0)
                builder.at(((*p).x() - origin.x()) >> 3, ((*p).y() - origin.y()) >> 3, ((*p).z() - origin.z()) >> 3)
                    .fill(~uint64_t(0));
    });
    return builder;
}

void check_axes(const std::array<Vec3d, 3>& axis, const std::string& name)
{
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        const double cosine = axis[a].dot(axis[b]);
        if (std::abs(cosine) > right_angle)
            throw InputError("grid '" + printable(name) + "': its transform shears voxels (axes " + "xyz"[a] + " and " +
                             "xyz"[b] + " at " + std::to_string(std::acos(cosine) * 180 / pi) +
                             " degrees): expected axes at right angles");
    }
}

struct Edges {
    std::array<Vec3d, 3> direction;  // unit vectors [world space]
    Vec3d length;
};

/// The edges of a voxel; throws where they are not at right angles.
Edges edges_of(const FloatGrid& grid)
{
    const Affine world_from_index = vdbcloud::world_from_index(grid.transform(), grid.getName());
    Edges edges;
    for (int a = 0; a < 3; ++a) {
        Vec3d unit(0, 0, 0);
        unit[a] = 1;
        edges.direction[a] = world_from_index.vector(unit);
        edges.length[a] = edges.direction[a].length();
        edges.direction[a] /= edges.length[a];
    }
    check_axes(edges.direction, grid.getName());
    return edges;
}

void check_count(const FloatGrid& grid)
{
    if (grid.tree().activeVoxelCount() > (uint64_t(1) << 31))
        throw InputError("grid '" + printable(grid.getName()) + "': more than 2^31 active voxels");
}

Period blocks_period(const FloatGrid& grid, const VoxelIndexOptions& options)
{
    const Period period = period_of(grid, options.periodic);
    for (int a = 0; a < 3; ++a) {
        const int length = period.length[a], rest = length % Blocks::edge;
        if (rest)
            throw InputError("grid '" + printable(grid.getName()) + "': it is to repeat along " + "xyz"[a] + " after " +
                             std::to_string(length) + " voxels: expected a multiple of 8, such as " +
                             std::to_string(length - rest + Blocks::edge));
    }
    return period;
}

}  // namespace

void check_voxels(const FloatGrid& grid, const VoxelIndexOptions& options)
{
    edges_of(grid);
    check_count(grid);
    blocks_period(grid, options);
}

VoxelIndex::VoxelIndex(const FloatGrid& grid, const VoxelIndexOptions& options)
    : world_from_index_(vdbcloud::world_from_index(grid.transform(), grid.getName())),
      transform_(grid.transform().copy())
{
    const Edges edges = edges_of(grid);
    check_count(grid);
    axis_ = edges.direction, spacing_ = edges.length;
    period_ = blocks_period(grid, options);
    Vec3i period(0, 0, 0);
    for (int a = 0; a < 3; ++a) {
        if (period_.length[a] == 0) continue;
        period[a] = period_.length[a] / Blocks::edge;
        origin_[a] = period_.first[a];
    }
    const auto is_void = [](const BlockMask& mask) {
        return std::all_of(mask.begin(), mask.end(), [](uint64_t word) { return word == 0; });
    };
    Builder builder = masks_of(grid, openvdb::Coord(origin_.x(), origin_.y(), origin_.z()));
    for (auto at = builder.masks.begin(); at != builder.masks.end();)
        at = is_void(at->second) ? builder.masks.erase(at) : std::next(at);
    for (const Vec3i& at : options.besides) builder.at(at.x(), at.y(), at.z());
    std::vector<Block> list;
    for (const auto& [at, mask] : builder.masks)
        list.push_back({Vec3i(std::get<0>(at), std::get<1>(at), std::get<2>(at)), mask});
    blocks_ = Blocks(std::move(list), period, /*with_void=*/true);
}

Vec3d VoxelIndex::world(const Vec3d& voxel) const
{
    return world_from_index_.point(voxel + Vec3d(origin_.x(), origin_.y(), origin_.z()));
}

namespace {

/// read() makes, once for each block, a function of a voxel's coordinates.
template<typename F>
std::vector<float> gathered(const VoxelIndex& index, const F& read)
{
    const Blocks& blocks = index.blocks();
    std::vector<float> values(blocks.slots(), 0.0f);
    tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
        const auto value = read();
        for (size_t slot = b * 512; slot < b * 512 + 512; ++slot)
            if (blocks.active(slot)) values[slot] = value(blocks.voxel(slot) + index.origin());
    });
    return values;
}

}  // namespace

std::vector<float> VoxelIndex::gather(const FloatGrid& grid) const
{
    return gathered(*this, [&] {
        return [tree = grid.getConstAccessor()](const Vec3i& p) {
            return tree.getValue(openvdb::Coord(p.x(), p.y(), p.z()));
        };
    });
}

std::vector<float> VoxelIndex::gather(const Vec3SGrid& grid, int component) const
{
    return gathered(*this, [&] {
        const auto mean = std::make_shared<const VoxelMean>(grid, *transform_);
        return [mean, component](const Vec3i& p) { return (*mean)(p)[component]; };
    });
}

namespace {

/// A grid with value(slot) at the active voxels, and a fringe.
template<typename GridT, typename F>
typename GridT::Ptr grid_of(const VoxelIndex& index, const F& value)
{
    const Blocks& blocks = index.blocks();
    const auto inside = GridT::create(typename GridT::ValueType(0.0f));
    auto& tree = inside->tree();
    const Vec3i origin = index.origin();
    if ((origin[0] | origin[1] | origin[2]) % Blocks::edge == 0) {  // each block is a leaf
        std::vector<typename GridT::TreeType::LeafNodeType*> leaves;
        for (size_t b = 0; b < blocks.count(); ++b) {
            const Vec3i p = Blocks::edge * blocks.at(b) + origin;
            leaves.push_back(tree.touchLeaf(openvdb::Coord(p.x(), p.y(), p.z())));
        }
        tbb::parallel_for(size_t(0), blocks.count(), [&](size_t b) {
            for (openvdb::Index i = 0; i < Blocks::size; ++i)
                if (blocks.active(b * Blocks::size + i)) leaves[b]->setValueOn(i, value(b * Blocks::size + i));
        });
    } else {
        for (size_t slot = 0; slot < blocks.count() * Blocks::size; ++slot) {
            if (!blocks.active(slot)) continue;
            const Vec3i p = blocks.voxel(slot) + origin;
            const openvdb::Coord at(p.x(), p.y(), p.z());
            tree.touchLeaf(at)->setValueOn(at, value(slot));
        }
    }
    return with_fringe(*inside, index.period());
}

}  // namespace

Vec3SGridPtr VoxelIndex::to_grid(const std::array<const float*, 3>& field, const std::string& name,
                                 const Vec3d& scale) const
{
    auto grid = grid_of<Vec3SGrid>(*this, [&](size_t slot) {
        return Vec3f(float(scale[0] * field[0][slot]), float(scale[1] * field[1][slot]),
                     float(scale[2] * field[2][slot]));
    });
    grid->setName(name);
    grid->setTransform(transform_->copy());
    return grid;
}

FloatGridPtr VoxelIndex::to_grid(const float* field, const std::string& name) const
{
    auto grid = grid_of<FloatGrid>(*this, [&](size_t slot) { return field[slot]; });
    grid->setName(name);
    grid->setTransform(transform_->copy());
    return grid;
}

}  // namespace vdbcloud
