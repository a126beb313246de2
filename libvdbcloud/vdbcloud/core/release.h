#pragma once
// Memory that a vector gives back.
#include <vector>

namespace vdbcloud {

/// Empties vectors and frees their memory, which `v = {}` keeps.
template<typename... T>
void release(std::vector<T>&... v)
{
    (std::vector<T>().swap(v), ...);
}

}  // namespace vdbcloud
