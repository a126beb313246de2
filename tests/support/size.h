#pragma once
// Size of expensive tests: the environment variable SIZE=full selects the full test, otherwise a part sized for CI
// runs.
#include <cstdlib>
#include <string_view>

namespace vdbcloud::test {

inline bool full_size()
{
    const char* size = std::getenv("SIZE");
    return size && std::string_view(size) == "full";
}

/// `full` under SIZE=full, else `ci`.
template<typename T>
T sized(T ci, T full)
{
    return full_size() ? full : ci;
}

}  // namespace vdbcloud::test
