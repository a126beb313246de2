#pragma once
// Bounds of pictures that come from elsewhere. Private to render/.
#include <cstdint>
#include <string>

namespace vdbcloud {

/// The size of a file to be read. Throws IoError, path first: it cannot be read, is no regular file, or is an .exr with
/// an attribute that claims more bytes than the file has.
uint64_t bytes_of_picture(const std::string& path);

/// Throws IoError, path first, for a picture without pixels, or one that claims more than its bytes can hold. Deflate
/// packs 1032 bytes into one at most; other methods of pictures come to less than four times that.
void check_claim(const std::string& path, uint64_t file_bytes, uint64_t width, uint64_t height, uint64_t pixel_bytes);

/// Throws IoError, path first, for pixels of more bytes than the system has memory left: what is not there would be
/// found missing only page by page, by the end of some process.
void check_memory(const std::string& path, double bytes);

}  // namespace vdbcloud
