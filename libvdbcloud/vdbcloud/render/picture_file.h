#pragma once
// Bytes of picture files: encoded in memory, so that every write to the disk is checked. Private to render/.
#include "vdbcloud/render/whole_file.h"

#include <OpenImageIO/imageio.h>

namespace vdbcloud {

/// The pixels as a file of `format`, "exr" or "png". Throws IoError, path first.
Bytes encoded(const std::string& path, const char* format, const OIIO::ImageSpec&, OIIO::TypeDesc type,
              const void* pixels);

}  // namespace vdbcloud
