#pragma once
// Fixed byte positions in a .vdb file.
#include <cstddef>

namespace vdbcloud {

/// The archive's identifier (36 characters) occupies bytes identifier_begin .. identifier_end - 1 of a .vdb file.
inline constexpr size_t identifier_begin = 21, identifier_size = 36, identifier_end = 57;

}  // namespace vdbcloud
