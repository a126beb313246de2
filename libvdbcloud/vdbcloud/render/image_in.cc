#include "vdbcloud/render/image_in.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/render/picture_file.h"

#include <sys/stat.h>

#include <cerrno>
#include <cstdint>

namespace vdbcloud {

namespace {

/// Deflate packs 1032 bytes into one at most; other methods of pictures come to less than four times that.
constexpr uint64_t most_expansion = 4096, small = uint64_t(1) << 20;
constexpr int most_pixels = 16384;
constexpr uint64_t most_values = uint64_t(1) << 28;

}  // namespace

std::unique_ptr<OIIO::ImageInput> opened_picture(const std::string& path)
{
    struct stat status = {};
    if (::stat(path.c_str(), &status) != 0) throw IoError(system_message(path, "cannot read", errno));
    if (!S_ISREG(status.st_mode)) throw IoError(printable(path) + ": expected a picture, this is no regular file");
    auto input = OIIO::ImageInput::open(path);
    if (!input) throw IoError(printable(path) + ": cannot read it as a picture: " + printable(OIIO::geterror()));
    const OIIO::ImageSpec& spec = input->spec();
    const uint64_t bytes = uint64_t(status.st_size), claimed = spec.image_bytes(/*native=*/true);
    if (spec.width < 1 || spec.height < 1 || spec.nchannels < 1 || claimed > most_expansion * bytes + small)
        throw IoError(printable(path) + ": malformed picture: it claims " + std::to_string(spec.width) + " x " +
                      std::to_string(spec.height) + " pixels in " + std::to_string(bytes) + " bytes");
    return input;
}

Pixels read_pixels(const std::string& path)
{
    const auto input = opened_picture(path);
    const OIIO::ImageSpec& spec = input->spec();
    const uint64_t count = uint64_t(spec.width) * uint64_t(spec.height) * uint64_t(spec.nchannels);
    if (spec.width > most_pixels || spec.height > most_pixels || count > most_values)
        throw IoError(printable(path) + ": " + std::to_string(spec.width) + " x " + std::to_string(spec.height) +
                      " pixels of " + std::to_string(spec.nchannels) +
                      " channels: expected at most 16384 pixels a side and 2^28 values");
    Pixels pixels{spec.width, spec.height, spec.nchannels, std::vector<float>(count)};
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.values.data()))
        throw IoError(printable(path) + ": cannot read its pixels: " + printable(input->geterror()));
    return pixels;
}

}  // namespace vdbcloud
