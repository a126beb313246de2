#pragma once
// Text files as a whole.
#include <cstdint>
#include <string>

namespace vdbcloud {

/// All bytes of a file, or of standard input for "-". Never holds more than `max_bytes` and a block: a device without
/// an end is refused as a file that is too large. `what` is what the file holds, for messages ("table"). Throws
/// IoError.
std::string read_text(const std::string& path, uint64_t max_bytes, const std::string& what);

}  // namespace vdbcloud
