#include "vdbcloud/core/error.h"
#include "vdbcloud/render/exr_file.h"
#include "vdbcloud/render/image_out.h"

#include <OpenEXR/ImfHeader.h>

namespace vdbcloud {

namespace {

Bytes encoded_map(const std::string& path, const Map& map, const ImageMetadata& metadata)
{
    Imf::Header header(map.width, map.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    set_attributes(header, metadata);
    std::vector<ExrChannel> channels;
    for (const auto& [name, values] : map.channels) channels.push_back({name, false, values.data(), 1});
    return encoded_exr(path, header, channels);
}

}  // namespace

void write_map(const std::string& path, const Map& map, const ImageMetadata& metadata, bool no_clobber)
{
    const size_t pixels = size_t(map.width) * size_t(map.height);
    for (const auto& [name, values] : map.channels)
        if (values.size() != pixels)
            throw InputError("map: channel " + name + " has " + std::to_string(values.size()) + " values: expected " +
                             std::to_string(pixels));
    write_picture_file(path, no_clobber, [&] { return encoded_map(path, map, metadata); });
}

}  // namespace vdbcloud
