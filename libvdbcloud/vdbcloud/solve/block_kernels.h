#pragma once
// What the loops over one block share: the seven-point operator on each row, with the rows beside it.
// Private to solve/. Everything here is inlined into loops that are compiled for several instruction sets. Rows of
// eight voxels are vectors; operations are element by element, so all instruction sets give equal values.
#include "vdbcloud/core/eight.h"
#include "vdbcloud/solve/stencil.h"

namespace vdbcloud::kernels {

using namespace eight;

/// Bare pointers of a stencil.
struct StencilArrays {
    const float *x, *y, *z, *extra;
    const int32_t (*neighbours)[6];
};

/// The links of one row of eight voxels along z, by Blocks::Face.
struct RowLinks {
    Floats xm, xp, ym, yp, zm, zp;
};
VDBCLOUD_INLINE RowLinks row_links(const StencilArrays& a, size_t block, int x, int y)
{
    const size_t row = block * 512 + size_t(x * 64 + y * 8);
    const int32_t* neighbour = a.neighbours[block];
    const Floats zp = load(a.z + row);
    Floats zm = __builtin_shufflevector(zp, zp, 0, 0, 1, 2, 3, 4, 5, 6);
    zm[0] = a.z[size_t(neighbour[4]) * 512 + size_t(x * 64 + y * 8 + 7)];
    return {load(x > 0 ? a.x + row - 64 : a.x + size_t(neighbour[0]) * 512 + 7 * 64 + y * 8),
            load(a.x + row),
            load(y > 0 ? a.y + row - 8 : a.y + size_t(neighbour[2]) * 512 + x * 64 + 7 * 8),
            load(a.y + row),
            zm,
            zp};
}

/// (A v) of one row of eight voxels along z: v there, and at the voxels below (m) and above (p) along each axis.
template<typename T>
VDBCLOUD_INLINE Row<T> row_apply(const StencilArrays& a, size_t block, int x, int y, const Row<T>& own,
                                 const Row<T>& xm, const Row<T>& xp, const Row<T>& ym, const Row<T>& yp,
                                 const Row<T>& zm, const Row<T>& zp)
{
    const RowLinks c = row_links(a, block, x, y);
    const auto pull = [&](const Floats& link, const Row<T>& to) __attribute__((always_inline))
    {
        return as<T>(link) * (own - to);
    };
    return as<T>(load(a.extra + block * 512 + size_t(x * 64 + y * 8))) * own +
           ((pull(c.xm, xm) + pull(c.xp, xp)) + (pull(c.ym, ym) + pull(c.yp, yp)) + (pull(c.zm, zm) + pull(c.zp, zp)));
}

/// Calls row(slot, v, product) for each row of eight voxels of a block, x slowest: `slot` its first, v its values of a
/// field `value` (value.row(slot) of eight values, value.one(slot)), product = (A v) there. The function must be
/// always_inline.
template<typename T, typename Value, typename Function>
VDBCLOUD_INLINE void over_rows(const StencilArrays& a, size_t block, const Value& value, const Function& row)
{
    const int32_t* neighbour = a.neighbours[block];
    const size_t here = block * 512;
    const auto first_of = [&](int face) { return size_t(neighbour[face]) * 512; };
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) {
            const size_t in = size_t(x * 64 + y * 8), slot = here + in;
            const auto own = value.row(slot);
            auto zm = __builtin_shufflevector(own, own, 0, 0, 1, 2, 3, 4, 5, 6);
            auto zp = __builtin_shufflevector(own, own, 1, 2, 3, 4, 5, 6, 7, 7);
            zm[0] = value.one(first_of(4) + in + 7);
            zp[7] = value.one(first_of(5) + in);
            const Row<T> v = as<T>(own);
            row(slot, v,
                row_apply<T>(a, block, x, y, v, as<T>(value.row(x > 0 ? slot - 64 : first_of(0) + in + 7 * 64)),
                             as<T>(value.row(x < 7 ? slot + 64 : first_of(1) + in - 7 * 64)),
                             as<T>(value.row(y > 0 ? slot - 8 : first_of(2) + in + 7 * 8)),
                             as<T>(value.row(y < 7 ? slot + 8 : first_of(3) + in - 7 * 8)), as<T>(zm), as<T>(zp)));
        }
}

/// The values of an array, for over_rows().
template<typename T>
struct Values {
    const T* from;
    VDBCLOUD_INLINE Row<T> row(size_t slot) const { return load(from + slot); }
    VDBCLOUD_INLINE T one(size_t slot) const { return from[slot]; }
};

StencilArrays arrays_of(const Stencil&);

}  // namespace vdbcloud::kernels
