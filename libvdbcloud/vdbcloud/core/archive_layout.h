#pragma once
// Fixed places in the bytes of a .vdb.
#include <cstddef>

namespace vdbcloud {

/// Where the archive's identifier (36 characters) stands in a .vdb, from the byte `identifier_begin` on.
inline constexpr size_t identifier_begin = 21, identifier_size = 36, identifier_end = 57;

}  // namespace vdbcloud
