#pragma once
// One direction through one block of 8^3 voxels: the inner loops of transport_sweep. Private to sweep/.
#include "vdbcloud/core/fwd.h"

#include <array>
#include <cstddef>

namespace vdbcloud::block_sweep {

/// A block with the aprons of its neighbours: (x, y, z), each -1..8, at (x+1) stride[0] + (y+1) stride[1] + (z+1) stride[2] + first.
/// Rows of eight are contiguous along one axis: z, or y for directions that cross planes of z.
struct Layout {
    std::array<int, 3> stride;      ///< in a padded block
    std::array<int, 3> row_stride;  ///< in 512 values without apron
    int at(int x, int y, int z) const { return (x + 1) * stride[0] + (y + 1) * stride[1] + (z + 1) * stride[2] + first; }
    static constexpr int size = 1600, first = 3;
};
inline constexpr Layout natural{{160, 16, 1}, {64, 8, 1}};
inline constexpr Layout turned{{16, 1, 160}, {8, 1, 64}};

/// A direction, made ready for blocks. Planes are crossed along axis w; u and v are the others, v the contiguous one.
struct Frame {
    explicit Frame(const Vec3d& step);  ///< step: voxels per world unit

    const Layout* layout;
    int w, u, v;
    std::array<int, 3> sign;       ///< of step
    float c00, c01, c10, c11;      ///< bilinear weights: none, v, u, both upstream
    float half_step;               ///< half the length from plane to plane [world unit]
    std::array<float, 3> half_exit;  ///< half the length from one centre to the plane of the next along each axis
};

struct Scratch {
    alignas(64) float sigma[Layout::size], radiance[Layout::size], source[Layout::size];
    alignas(64) float q[512];
    alignas(64) float out[512];  ///< radiance in slot order
};

/// Fills the inside of `padded`, laid out as `to`, from 512 values in slot order.
void load_inside(const Layout& to, const float* values, float* padded);

/// q = sum over terms of basis * source (terms `stride` apart... each a pointer to the block's 512 values), in the layout's order,
/// and source = sigma q inside.
void prepare(const Frame&, int terms, const float* const* source, const float* basis, Scratch&);

/// Sweeps the planes: radiance inside from its aprons and those of sigma and source. Then `out` holds it in slot order.
void sweep_planes(const Frame&, Scratch&);

/// moments[k] += weight[k] out, for `terms` arrays of 512 values.
void accumulate(int terms, float* const* moments, const float* weight, const float* out);

/// n values: radiance e^-tau + q (1 - e^-tau), tau = sigma length. Arrays hold a multiple of eight.
void leave(int n, const float* radiance, const float* sigma, const float* q, const float* length, float* result);

}  // namespace vdbcloud::block_sweep
