#include "vdbcloud/render/picture_bytes.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"

#include <sys/stat.h>

#include <cerrno>

namespace vdbcloud {

uint64_t bytes_of_picture(const std::string& path)
{
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) throw IoError(system_message(path, "cannot read", errno));
    if (!S_ISREG(status.st_mode)) throw IoError(printable(path) + ": expected a picture, this is no regular file");
    return uint64_t(status.st_size);
}

void check_claim(const std::string& path, uint64_t file_bytes, uint64_t width, uint64_t height, uint64_t pixel_bytes)
{
    constexpr uint64_t most_expansion = 4096, small = uint64_t(1) << 20, most_side = uint64_t(1) << 31;
    const uint64_t most = most_expansion * file_bytes + small;
    const bool sides = width > 0 && height > 0 && pixel_bytes > 0 && width <= most_side && height <= most_side;
    if (!sides || width * height > most / pixel_bytes)
        throw IoError(printable(path) + ": malformed picture: it claims " + std::to_string(width) + " x " +
                      std::to_string(height) + " pixels in " + std::to_string(file_bytes) + " bytes");
}

}  // namespace vdbcloud
