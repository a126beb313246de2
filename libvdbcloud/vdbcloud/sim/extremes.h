#pragma once
// Smaller, larger and absolute value for kernels over rows: by value and inlined, so that loops vectorise.
// least() and most() return their second argument if either is NaN. Private to sim/.
#include "vdbcloud/core/clones.h"

namespace vdbcloud::sim {

template<typename T>
VDBCLOUD_INLINE T least(T a, T b)
{
    return a < b ? a : b;
}
template<typename T>
VDBCLOUD_INLINE T most(T a, T b)
{
    return a > b ? a : b;
}
template<typename T>
VDBCLOUD_INLINE T magnitude(T a)
{
    return a < T(0) ? -a : a;
}

}  // namespace vdbcloud::sim
