#pragma once
// How large a number of an option, of a table or of the metadata may be.

namespace vdbcloud {

/// Products of several such numbers stay within a double, and one within a float.
inline constexpr double largest_number = 1e30;

}  // namespace vdbcloud
