#pragma once
// Where blocks are missing, so that a ray crosses emptiness in cells as large as the emptiness.
#include "vdbcloud/voxels/blocks.h"

#include <array>
#include <unordered_set>

namespace vdbcloud {

/// Hash of whole coordinates. No two coordinates share a key, however far apart they are.
struct CoordHash {
    size_t operator()(const Vec3i& at) const
    {
        uint64_t h = uint64_t(uint32_t(at.x())) * 0x9e3779b97f4a7c15u;
        h = (h ^ h >> 29 ^ uint32_t(at.y())) * 0xbf58476d1ce4e5b9u;
        h = (h ^ h >> 32 ^ uint32_t(at.z())) * 0x94d049bb133111ebu;
        return size_t(h ^ h >> 31);
    }
};

/// The cells of 16, 16^2 ... 16^7 blocks along an edge that hold blocks. Seven sizes reach across all coordinates below
/// 2^30 voxels, so a ray crosses any gap in some dozens of steps. Memory: at most seven entries for a block.
///
/// Threads: immutable; any number of threads may call.
class Emptiness {
public:
    static constexpr int step = 4;    ///< log2 of the ratio of two sizes
    static constexpr int levels = 7;  ///< sizes

    Emptiness() = default;
    explicit Emptiness(const Blocks& blocks)
    {
        for (size_t b = 0; b < blocks.count(); ++b)
            for (int level = 1; level <= levels; ++level)
                if (!cells_[size_t(level - 1)].insert(shifted(blocks.at(b), step * level)).second) break;
    }

    /// log2 of the edge [blocks] of the largest empty cell about a block that is missing: 0, 4, 8 .. 28. `known`: sizes
    /// of which the caller knows that the cell is empty.
    int bits(const Vec3i& block, int known = 0) const
    {
        int level = known;
        while (level < levels && !cells_[size_t(level)].count(shifted(block, step * (level + 1)))) ++level;
        return step * level;
    }

    static Vec3i shifted(const Vec3i& v, int bits) { return Vec3i(v.x() >> bits, v.y() >> bits, v.z() >> bits); }

    size_t bytes() const
    {
        size_t entries = 0;
        for (const auto& of : cells_) entries += of.size();
        return entries * (sizeof(Vec3i) + 3 * sizeof(void*));
    }

private:
    std::array<std::unordered_set<Vec3i, CoordHash>, levels> cells_;
};

}  // namespace vdbcloud
