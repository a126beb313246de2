#pragma once
// Arithmetic on eight values at a time, one row of a block of voxels. For loops that are compiled for several
// instruction sets (clones.h): operations are element by element, so all sets give equal values.
#include "vdbcloud/core/clones.h"

#include <cstdint>
#include <cstring>

namespace vdbcloud::eight {

// Every function here is inlined and takes vectors by reference: nobody needs their calling convention.
#pragma GCC diagnostic ignored "-Wpsabi"

using Floats = float __attribute__((vector_size(32)));
using Doubles = double __attribute__((vector_size(64)));
using Ints = int32_t __attribute__((vector_size(32)));

template<typename T>
struct RowOf;
template<>
struct RowOf<float> {
    using Type = Floats;
    using Bits = int32_t;
    using BitRow = Ints;
};
template<>
struct RowOf<double> {
    using Type = Doubles;
    using Bits = int64_t;
    using BitRow = int64_t __attribute__((vector_size(64)));
};
template<typename T>
using Row = typename RowOf<T>::Type;

template<typename T>
VDBCLOUD_INLINE Row<T> load(const T* from)
{
    Row<T> row;
    std::memcpy(&row, from, sizeof row);
    return row;
}
template<typename T>
VDBCLOUD_INLINE void store(T* to, const Row<T>& row)
{
    std::memcpy(to, &row, sizeof row);
}
/// One value in all lanes. Made of integers: GCC joins a row of floats {x, x, ..} from eight insertions, and broadcasts
/// an integer in one.
template<typename T>
VDBCLOUD_INLINE Row<T> all(T x)
{
    typename RowOf<T>::Bits bit;
    std::memcpy(&bit, &x, sizeof bit);
    const typename RowOf<T>::BitRow bits = typename RowOf<T>::BitRow{} + bit;
    Row<T> row;
    std::memcpy(&row, &bits, sizeof row);
    return row;
}
/// A row of either precision as one of T.
template<typename T, typename R>
VDBCLOUD_INLINE Row<T> as(const R& row)
{
    return __builtin_convertvector(row, Row<T>);
}
/// The sum of a row, the first value first.
VDBCLOUD_INLINE double sum(const Doubles& row)
{
    double total = 0;
    for (int k = 0; k < 8; ++k) total += row[k];
    return total;
}

/// All bits of the lanes whose bit is set in `bits`, the first lane by the lowest.
VDBCLOUD_INLINE Ints lanes_of(unsigned bits) { return (Ints{1, 2, 4, 8, 16, 32, 64, 128} & int32_t(bits)) != 0; }

}  // namespace vdbcloud::eight
