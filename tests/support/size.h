#pragma once
// How big a heavy check is: the environment variable SIZE=full asks for the whole of it, otherwise a CI-sized part
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
