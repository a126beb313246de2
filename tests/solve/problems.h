#pragma once
// Small seven-point problems on sparse blocks, for the solver's tests.
#include "vdbcloud/core/random.h"
#include "vdbcloud/solve/stencil.h"

#include <functional>

namespace vdbcloud::test {

using Field = std::function<double(const Vec3i&)>;

/// The voxels of the box 0 .. n - 1 (n multiples of 8) that are `inside`.
inline Blocks masked(const Vec3i& n, const std::function<bool(const Vec3i&)>& inside)
{
    std::vector<Block> blocks;
    for (int x = 0; x < n.x(); x += 8)
        for (int y = 0; y < n.y(); y += 8)
            for (int z = 0; z < n.z(); z += 8) {
                Block block{Vec3i(x / 8, y / 8, z / 8), {}};
                for (int i = 0; i < 512; ++i)
                    if (inside(Vec3i(x + i / 64, y + i / 8 % 8, z + i % 8)))
                        block.mask[i / 64] |= uint64_t(1) << (i % 64);
                blocks.push_back(block);
            }
    return Blocks(std::move(blocks));
}

/// Between voxels of conductivity `k` the harmonic mean; `outside` on each exposed face, and `absorption`.
struct Problem {
    Problem(const Blocks& blocks, const Field& k, double outside, const Field& absorption) : stencil(blocks)
    {
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            if (!blocks.active(slot)) continue;
            const double own = k(blocks.voxel(slot));
            double boundary = 0;
            for (int face = 0; face < 6; ++face) {
                const size_t to = blocks.neighbour(slot, face);
                if (!blocks.active(to))
                    boundary += outside;
                else if (face % 2)
                    stencil.face[face / 2][slot] = float(2 / (1 / own + 1 / k(blocks.voxel(to))));
            }
            stencil.extra[slot] = float(boundary + absorption(blocks.voxel(slot)));
        }
    }
    Stencil stencil;
};

inline std::vector<double> field(const Blocks& blocks, const Field& f)
{
    std::vector<double> values(blocks.slots(), 0.0);
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) values[slot] = f(blocks.voxel(slot));
    return values;
}

inline Field constant(double value)
{
    return [value](const Vec3i&) { return value; };
}

inline double noise(uint64_t seed, const Vec3i& p)
{
    return uniform(hash_bits(seed, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
}

}  // namespace vdbcloud::test
