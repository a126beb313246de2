#pragma once
// Bytes of picture files: encoded in memory, so that every write to the disk is checked. Private to render/.
#include <OpenImageIO/imageio.h>

#include <functional>
#include <string>
#include <vector>

namespace vdbcloud {

using Bytes = std::vector<unsigned char>;

/// The pixels as a file of `format`, "exr" or "png". Throws IoError, path first.
Bytes encoded(const std::string& path, const char* format, const OIIO::ImageSpec&, OIIO::TypeDesc type,
              const void* pixels);

/// Writes what `make` returns, whole or not at all; "-" is standard output. Throws IoError, path first.
void write_picture_file(const std::string& path, bool no_clobber, const std::function<Bytes()>& make);

}  // namespace vdbcloud
