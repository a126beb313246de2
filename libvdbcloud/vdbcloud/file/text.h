#pragma once
// Files as a whole.
#include <cstdint>
#include <string>

namespace vdbcloud {

/// All bytes of a file, or of standard input for "-". Never holds more than `max_bytes` and a block: a device without
/// an end is refused as a file that is too large. `what` is what the file holds, for messages ("table"). Throws
/// IoError.
std::string read_bytes(const std::string& path, uint64_t max_bytes, const std::string& what);

/// The same, without the mark that some programs put before text in UTF-8.
std::string read_text(const std::string& path, uint64_t max_bytes, const std::string& what);

}  // namespace vdbcloud
