#pragma once
// Bytes of picture files: encoded in memory, so that every write to the disk is checked; opened within bounds. Private
// to render/.
#include "vdbcloud/render/whole_file.h"

#include <OpenImageIO/imageio.h>

#include <memory>

namespace vdbcloud {

/// The pixels as a file of `format`, "exr" or "png". Throws IoError, path first.
Bytes encoded(const std::string& path, const char* format, const OIIO::ImageSpec&, OIIO::TypeDesc type,
              const void* pixels);

/// Opens a picture for reading. Throws IoError, path first: it cannot be read, is no regular file, or claims more
/// pixels than its bytes can hold.
std::unique_ptr<OIIO::ImageInput> opened_picture(const std::string& path);

}  // namespace vdbcloud
