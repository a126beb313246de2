#pragma once
// What the loops over one block share: values with the neighbours' apron, and one row of the seven-point operator.
// Private to solve/. Everything here is inlined into loops that are compiled for several instruction sets. Rows of
// eight voxels are vectors; operations are element by element, so all instruction sets give equal values.
#include "vdbcloud/core/eight.h"
#include "vdbcloud/solve/stencil.h"

namespace vdbcloud::kernels {

using namespace eight;

/// Where value (x, y, z), each -1..8, of a padded block is.
constexpr int pad_x = 160, pad_y = 16, pad_size = 1600;
constexpr int padded(int x, int y, int z) { return (x + 1) * pad_x + (y + 1) * pad_y + z + 8; }

/// Fills a padded block from a field: f.row(slot) of eight values, f.one(slot). Edges and corners of the apron are not
/// filled.
template<typename T, typename F>
VDBCLOUD_INLINE void load_padded(const int32_t* neighbour, size_t block, T* pad, const F& f)
{
    const size_t here = block * 512;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) store(pad + padded(x, y, 0), f.row(here + size_t(x * 64 + y * 8)));
    const size_t xm = size_t(neighbour[0]) * 512 + 7 * 64, xp = size_t(neighbour[1]) * 512;
    const size_t ym = size_t(neighbour[2]) * 512 + 7 * 8, yp = size_t(neighbour[3]) * 512;
    const size_t zm = size_t(neighbour[4]) * 512 + 7, zp = size_t(neighbour[5]) * 512;
    for (int i = 0; i < 8; ++i) {
        store(pad + padded(-1, i, 0), f.row(xm + size_t(i * 8)));
        store(pad + padded(8, i, 0), f.row(xp + size_t(i * 8)));
        store(pad + padded(i, -1, 0), f.row(ym + size_t(i * 64)));
        store(pad + padded(i, 8, 0), f.row(yp + size_t(i * 64)));
    }
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            pad[padded(x, y, -1)] = f.one(zm + size_t(x * 64 + y * 8));
            pad[padded(x, y, 8)] = f.one(zp + size_t(x * 64 + y * 8));
        }
}

/// Bare pointers of a stencil.
struct StencilArrays {
    const float *x, *y, *z, *extra;
    const int32_t (*neighbours)[6];
};

/// out = (A v) of one row of eight voxels along z; v points at the row's first value in a padded block.
template<typename T>
VDBCLOUD_INLINE Row<T> row_apply(const StencilArrays& a, size_t block, int x, int y, const T* v)
{
    const size_t row = block * 512 + size_t(x * 64 + y * 8);
    const int32_t* neighbour = a.neighbours[block];
    const float* xl = x > 0 ? a.x + row - 64 : a.x + size_t(neighbour[0]) * 512 + 7 * 64 + y * 8;
    const float* yl = y > 0 ? a.y + row - 8 : a.y + size_t(neighbour[2]) * 512 + x * 64 + 7 * 8;
    const Floats zu = load(a.z + row);
    Floats zl = __builtin_shufflevector(zu, zu, 0, 0, 1, 2, 3, 4, 5, 6);
    zl[0] = a.z[size_t(neighbour[4]) * 512 + size_t(x * 64 + y * 8 + 7)];
    const Row<T> own = load(v);
    const auto pull = [&](Floats c, int to) __attribute__((always_inline)) { return as<T>(c) * (own - load(v + to)); };
    return as<T>(load(a.extra + row)) * own +
           ((pull(load(xl), -pad_x) + pull(load(a.x + row), pad_x)) +
            (pull(load(yl), -pad_y) + pull(load(a.y + row), pad_y)) + (pull(zl, -1) + pull(zu, 1)));
}

/// Calls row(slot, v, product) for each row of eight voxels of a block, x slowest: `slot` its first, v its values of a
/// field `value` (load_padded()), product = (A v) there. The function must be always_inline.
template<typename T, typename Value, typename Function>
VDBCLOUD_INLINE void over_rows(const StencilArrays& a, size_t block, const Value& value, const Function& row)
{
    alignas(64) T pad[pad_size];
    load_padded(a.neighbours[block], block, pad, value);
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const T* v = pad + padded(x, y, 0);
            row(block * 512 + size_t(x * 64 + y * 8), load(v), row_apply(a, block, x, y, v));
        }
}

/// The values of an array as T, for load_padded().
template<typename T, typename From = T>
struct Values {
    const From* from;
    VDBCLOUD_INLINE Row<T> row(size_t slot) const { return as<T>(load(from + slot)); }
    VDBCLOUD_INLINE T one(size_t slot) const { return T(from[slot]); }
};

StencilArrays arrays_of(const Stencil&);

}  // namespace vdbcloud::kernels
