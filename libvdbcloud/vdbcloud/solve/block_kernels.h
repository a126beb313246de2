#pragma once
// What the loops over one block share: values with the neighbours' apron, and one row of the seven-point operator.
// Private to solve/. Everything here is inlined into loops that are compiled for several instruction sets.
#include "vdbcloud/core/clones.h"
#include "vdbcloud/solve/stencil.h"

namespace vdbcloud::kernels {

/// Where value (x, y, z), each -1..8, of a padded block is.
constexpr int pad_x = 100, pad_y = 10, pad_size = 1000;
constexpr int padded(int x, int y, int z) { return (x + 1) * pad_x + (y + 1) * pad_y + z + 1; }

/// Fills a padded block from a field f(slot); edges and corners of the apron are not filled.
template<typename T, typename F>
VDBCLOUD_INLINE void load_padded(const int32_t* neighbour, size_t block, T* pad, const F& f)
{
    const size_t here = block * 512;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) pad[padded(x, y, z)] = f(here + x * 64 + y * 8 + z);
    const size_t xm = size_t(neighbour[0]) * 512 + 7 * 64, xp = size_t(neighbour[1]) * 512;
    const size_t ym = size_t(neighbour[2]) * 512 + 7 * 8, yp = size_t(neighbour[3]) * 512;
    const size_t zm = size_t(neighbour[4]) * 512 + 7, zp = size_t(neighbour[5]) * 512;
    for (int i = 0; i < 8; ++i)
        for (int z = 0; z < 8; ++z) {
            pad[padded(-1, i, z)] = f(xm + i * 8 + z);
            pad[padded(8, i, z)] = f(xp + i * 8 + z);
            pad[padded(i, -1, z)] = f(ym + i * 64 + z);
            pad[padded(i, 8, z)] = f(yp + i * 64 + z);
        }
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            pad[padded(x, y, -1)] = f(zm + x * 64 + y * 8);
            pad[padded(x, y, 8)] = f(zp + x * 64 + y * 8);
        }
}

/// The coefficients of one row of eight voxels along z: lower and upper faces of each axis.
struct RowFaces {
    const float *xl, *xu, *yl, *yu, *zl, *zu, *extra;
};

/// Bare pointers of a stencil.
struct StencilArrays {
    const float *x, *y, *z, *extra;
    const int32_t (*neighbours)[6];
};

/// The lower z faces of one block: its upper ones moved by one voxel.
VDBCLOUD_INLINE void load_lower_z(const StencilArrays& a, size_t block, float* lower)
{
    const float *own = a.z + block * 512, *below = a.z + size_t(a.neighbours[block][4]) * 512;
    for (int row = 0; row < 64; ++row) {
        lower[row * 8] = below[row * 8 + 7];
        for (int z = 1; z < 8; ++z) lower[row * 8 + z] = own[row * 8 + z - 1];
    }
}

VDBCLOUD_INLINE RowFaces row_faces(const StencilArrays& a, size_t block, const float* lower_z, int x, int y)
{
    const size_t here = block * 512, row = here + x * 64 + y * 8;
    const int32_t* neighbour = a.neighbours[block];
    return {x > 0 ? a.x + row - 64 : a.x + size_t(neighbour[0]) * 512 + 7 * 64 + y * 8,
            a.x + row,
            y > 0 ? a.y + row - 8 : a.y + size_t(neighbour[2]) * 512 + x * 64 + 7 * 8,
            a.y + row,
            lower_z + (x * 8 + y) * 8,
            a.z + row,
            a.extra + row};
}

/// out[0..7] = (A v) of one row; v points at the row's first value in a padded block.
template<typename T>
VDBCLOUD_INLINE void row_apply(const RowFaces& c, const T* v, T* out)
{
    for (int z = 0; z < 8; ++z)
        out[z] = T(c.extra[z]) * v[z] + ((T(c.xl[z]) * (v[z] - v[z - pad_x]) + T(c.xu[z]) * (v[z] - v[z + pad_x])) +
                                         (T(c.yl[z]) * (v[z] - v[z - pad_y]) + T(c.yu[z]) * (v[z] - v[z + pad_y])) +
                                         (T(c.zl[z]) * (v[z] - v[z - 1]) + T(c.zu[z]) * (v[z] - v[z + 1])));
}

/// Calls row(slot, v, product) for each row of eight voxels of a block, x slowest: `slot` its first, v its values
/// value(slot) within a padded block, product[0..7] = (A v) there. Both functions must be always_inline.
template<typename T, typename Value, typename Row>
VDBCLOUD_INLINE void over_rows(const StencilArrays& a, size_t block, const Value& value, const Row& row)
{
    alignas(64) T pad[pad_size];
    alignas(64) float lower_z[512];
    load_padded(a.neighbours[block], block, pad, value);
    load_lower_z(a, block, lower_z);
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const T* v = pad + padded(x, y, 0);
            T product[8];
            row_apply(row_faces(a, block, lower_z, x, y), v, product);
            row(block * 512 + size_t(x * 64 + y * 8), v, product);
        }
}

StencilArrays arrays_of(const Stencil&);

}  // namespace vdbcloud::kernels
