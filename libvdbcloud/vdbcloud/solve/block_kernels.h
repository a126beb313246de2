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

/// Calls row(slot, v, product, diagonal) for each row of eight voxels of a block, x slowest: `slot` its first, v its
/// values of a field `value` (value.row(slot) of eight values, value.one(slot)), product = (A v) there, and A's
/// diagonal. The function must be always_inline. A row and the links above it are loaded once for itself and the next
/// row along y.
template<typename T, typename Value, typename Function>
VDBCLOUD_INLINE void over_rows(const StencilArrays& arrays, size_t block, const Value& value, const Function& row)
{
    const StencilArrays a = arrays;  // a copy, which the rows that are stored cannot change
    const size_t here = block * 512;
    size_t first[6];  // slots of the neighbours
    for (int face = 0; face < 6; ++face) first[face] = size_t(a.neighbours[block][face]) * 512;
    const auto pull = [](const Floats& link, const Row<T>& own, const Row<T>& to) __attribute__((always_inline))
    {
        return as<T>(link) * (own - to);
    };
    for (size_t x = 0; x < 512; x += 64) {
        const size_t xm = x > 0 ? here + x - 64 : first[0] + 7 * 64, xp = x < 7 * 64 ? here + x + 64 : first[1];
        const size_t ym = first[2] + x + 7 * 8, yp = first[3] + x, zm = first[4] + x + 7, zp = first[5] + x;
        auto centre = value.row(here + x);
        Row<T> before = as<T>(value.row(ym)), own = as<T>(centre);
        Floats link_before = load(a.y + ym);
#pragma GCC unroll 8
        for (size_t y = 0; y < 64; y += 8) {
            const size_t slot = here + x + y;
            const auto next = value.row(y < 7 * 8 ? slot + 8 : yp);
            auto below = __builtin_shufflevector(centre, centre, 0, 0, 1, 2, 3, 4, 5, 6);
            auto above = __builtin_shufflevector(centre, centre, 1, 2, 3, 4, 5, 6, 7, 7);
            below[0] = value.one(zm + y);
            above[7] = value.one(zp + y);
            const Floats link = load(a.y + slot), link_above = load(a.z + slot);
            Floats link_below = __builtin_shufflevector(link_above, link_above, 0, 0, 1, 2, 3, 4, 5, 6);
            link_below[0] = a.z[zm + y];
            const Row<T> after = as<T>(next);
            const Floats extra = load(a.extra + slot), link_xm = load(a.x + xm + y), link_xp = load(a.x + slot);
            row(slot, own,
                as<T>(extra) * own +
                    ((pull(link_xm, own, as<T>(value.row(xm + y))) + pull(link_xp, own, as<T>(value.row(xp + y)))) +
                     (pull(link_before, own, before) + pull(link, own, after)) +
                     (pull(link_below, own, as<T>(below)) + pull(link_above, own, as<T>(above)))),
                extra + (((link_xm + link_xp) + (link_before + link)) + (link_below + link_above)));
            before = own;
            own = after;
            centre = next;
            link_before = link;
        }
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
