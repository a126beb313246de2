#include "vdbcloud/voxels/blocks.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <tuple>

namespace vdbcloud {

namespace {

bool before(const Vec3i& a, const Vec3i& b)
{
    return std::make_tuple(a.x(), a.y(), a.z()) < std::make_tuple(b.x(), b.y(), b.z());
}

int wrapped(int i, int period) { return period > 0 ? (i % period + period) % period : i; }

}  // namespace

Blocks::Blocks(std::vector<Block> blocks, const Vec3i& period, bool with_void)
    : blocks_(std::move(blocks)), period_(period)
{
    const auto is_void = [](const Block& block) {
        return std::all_of(block.mask.begin(), block.mask.end(), [](uint64_t word) { return word == 0; });
    };
    if (!with_void) blocks_.erase(std::remove_if(blocks_.begin(), blocks_.end(), is_void), blocks_.end());
    std::sort(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) { return before(a.at, b.at); });
    neighbours_.resize(blocks_.size());
    for (size_t b = 0; b < blocks_.size(); ++b) {
        for (uint64_t word : blocks_[b].mask) active_count_ += size_t(__builtin_popcountll(word));
        for (int face = 0; face < 6; ++face) {
            Vec3i at = blocks_[b].at;
            at[face / 2] += face % 2 ? 1 : -1;
            neighbours_[b][face] = find(at);
        }
    }
}

int32_t Blocks::find(Vec3i at) const
{
    for (int axis = 0; axis < 3; ++axis) at[axis] = wrapped(at[axis], period_[axis]);
    const auto found = std::lower_bound(blocks_.begin(), blocks_.end(), at,
                                        [](const Block& block, const Vec3i& key) { return before(block.at, key); });
    return int32_t(found != blocks_.end() && found->at == at ? found - blocks_.begin()
                                                             : blocks_.end() - blocks_.begin());
}

size_t Blocks::neighbour(size_t slot, int face) const
{
    static constexpr int stride[3] = {64, 8, 1};
    const int axis = face / 2, here = int(slot) / stride[axis] & 7, step = face % 2 ? 1 : -1;
    if (here + step >= 0 && here + step < edge) return slot + step * stride[axis];
    const size_t block = slot / size;
    if (block >= count()) return slot;
    return size_t(neighbours_[block][face]) * size + slot % size - step * 7 * stride[axis];
}

Vec3i Blocks::voxel(size_t slot) const
{
    const size_t block = slot / size, in = slot % size;
    return Vec3i(edge * at(block).x() + int(in / 64), edge * at(block).y() + int(in / 8 % 8),
                 edge * at(block).z() + int(in % 8));
}

size_t Blocks::slot(const Vec3i& voxel) const
{
    const Vec3i at(voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3);  // rounds down, for negative coordinates too
    return size_t(find(at)) * size + size_t((voxel.x() & 7) * 64 + (voxel.y() & 7) * 8 + (voxel.z() & 7));
}

Blocks box_blocks(const Vec3i& n, const std::array<bool, 3>& periodic)
{
    Vec3i period(0, 0, 0);
    for (int axis = 0; axis < 3; ++axis) {
        if (!periodic[axis]) continue;
        if (n[axis] % Blocks::edge)
            throw InputError("periodic extent of " + std::to_string(n[axis]) + " voxels: expected a multiple of 8");
        period[axis] = n[axis] / Blocks::edge;
    }
    std::vector<Block> blocks;
    for (int x = 0; x < n.x(); x += 8)
        for (int y = 0; y < n.y(); y += 8)
            for (int z = 0; z < n.z(); z += 8) {
                Block block{Vec3i(x / 8, y / 8, z / 8), {}};
                uint64_t word = 0;
                for (int j = 0; j < std::min(8, n.y() - y); ++j)
                    for (int k = 0; k < std::min(8, n.z() - z); ++k) word |= uint64_t(1) << (j * 8 + k);
                for (int i = 0; i < std::min(8, n.x() - x); ++i) block.mask[i] = word;
                blocks.push_back(block);
            }
    return Blocks(std::move(blocks), period);
}

}  // namespace vdbcloud
