#include "vdbcloud/render/picture_file.h"

#include "vdbcloud/core/error.h"

#include <OpenImageIO/filesystem.h>

namespace vdbcloud {

Bytes encoded(const std::string& path, const char* format, const OIIO::ImageSpec& spec, OIIO::TypeDesc type,
              const void* pixels)
{
    const std::string name = std::string("image.") + format;
    auto output = OIIO::ImageOutput::create(name);
    if (!output) throw IoError(printable(path) + ": OpenImageIO has no writer for " + format);
    Bytes bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    // A writer may report success and hold an error, so every step and the remaining error are looked at.
    const bool done = output->set_ioproxy(&memory) && output->open(name, spec) && output->write_image(type, pixels) &&
                      output->close();
    if (!done || output->has_error())
        throw IoError(printable(path) + ": cannot encode " + format + ": " + printable(output->geterror()));
    return bytes;
}

}  // namespace vdbcloud
