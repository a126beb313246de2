#include "vdbcloud/render/picture_bytes.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/memory.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

namespace vdbcloud {

namespace {

/// Throws IoError for an attribute of an .exr that claims more bytes than follow it. OpenEXR allocates what is claimed
/// before it reads. An attribute is name, type, size and value; an empty name ends those of a part, a second one those
/// of all parts.
void check_attributes(const std::string& path, uint64_t file_bytes)
{
    std::ifstream in(path, std::ios::binary);
    char head[8] = {};
    if (!in.read(head, sizeof head) || std::memcmp(head, "\x76\x2f\x31\x01", 4) != 0) return;
    const bool several_parts = (head[5] & 0x10) != 0;
    bool ended = false;
    std::string name, type;
    while (std::getline(in, name, '\0')) {
        if (name.empty() && (ended || !several_parts)) return;
        ended = name.empty();
        if (ended) continue;
        unsigned char size[4] = {};
        if (!std::getline(in, type, '\0') || !in.read(reinterpret_cast<char*>(size), sizeof size)) return;
        const uint64_t claimed = size[0] + (size[1] << 8) + (size[2] << 16) + (uint64_t(size[3]) << 24);
        const uint64_t left = file_bytes - std::min(file_bytes, uint64_t(in.tellg()));
        if (claimed > left)
            throw IoError(printable(path) + ": malformed picture: its attribute '" + printable(name) + "' claims " +
                          std::to_string(claimed) + " bytes, " + std::to_string(left) + " follow");
        in.seekg(std::streamoff(claimed), std::ios::cur);
    }
}

}  // namespace

uint64_t bytes_of_picture(const std::string& path)
{
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) throw IoError(system_message(path, "cannot read", errno));
    if (!S_ISREG(status.st_mode)) throw IoError(printable(path) + ": expected a picture, this is no regular file");
    check_attributes(path, uint64_t(status.st_size));
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

void check_memory(const std::string& path, double bytes)
{
    const auto left = memory_left();
    if (left && bytes > left->bytes)
        throw IoError(printable(path) + ": not enough memory: its pixels take " +
                      std::to_string(uint64_t(bytes / 1e6)) + " MB, and " + left->limit + " leaves " +
                      std::to_string(uint64_t(left->bytes / 1e6)) + " MB: expected a smaller picture, or more memory");
}

}  // namespace vdbcloud
