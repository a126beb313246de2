#include "vdbcloud/render/image_in.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/picture_bytes.h"
#include "vdbcloud/render/picture_module.h"

#include <array>
#include <fstream>

namespace vdbcloud {

namespace {

/// OpenImageIO reads a .vdb with an OpenVDB of its own, which brings this process down.
void require_no_grids(const std::string& path)
{
    constexpr std::array<char, 4> magic{' ', 'B', 'D', 'V'};
    std::array<char, 4> first{};
    std::ifstream(path, std::ios::binary).read(first.data(), first.size());
    if (first == magic) throw IoError(printable(path) + ": cannot read it as a picture: it is a .vdb file of grids");
}

}  // namespace

Pixels read_pixels(const std::string& path)
{
    constexpr int most_pixels = 16384;
    constexpr uint64_t most_values = uint64_t(1) << 28;
    const uint64_t file_bytes = bytes_of_picture(path);
    const auto check = [&](const PictureSize& size) {
        check_claim(path, file_bytes, uint64_t(std::max(size.width, 0)), uint64_t(std::max(size.height, 0)),
                    uint64_t(size.pixel_bytes));
        const uint64_t count = uint64_t(size.width) * uint64_t(size.height) * uint64_t(size.channels);
        if (size.width > most_pixels || size.height > most_pixels || count > most_values)
            throw IoError(printable(path) + ": " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                          " pixels of " + std::to_string(size.channels) +
                          " channels: expected at most 16384 pixels a side and 2^28 values");
    };
    require_no_grids(path);
    Pixels pixels;
    const std::string trouble = picture_module(path).read(path, check, pixels);
    if (!trouble.empty()) throw IoError(printable(path) + ": cannot read it as a picture: " + printable(trouble));
    return pixels;
}

}  // namespace vdbcloud
