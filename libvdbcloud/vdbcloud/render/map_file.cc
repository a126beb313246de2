// Maps are written with OpenEXR itself: OpenImageIO brings 240 shared libraries, whose loading takes a program 0.2 s.
#include "vdbcloud/core/error.h"
#include "vdbcloud/render/image_out.h"
#include "vdbcloud/render/whole_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>

namespace vdbcloud {

namespace {

/// A file in memory.
class MemoryStream : public Imf::OStream {
public:
    explicit MemoryStream(Bytes& to) : Imf::OStream("memory"), bytes_(to) {}
    void write(const char c[], int n) override
    {
        const size_t end = at_ + size_t(n);
        if (bytes_.size() < end) bytes_.resize(end);
        std::copy(c, c + n, bytes_.begin() + std::ptrdiff_t(at_));
        at_ = end;
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t position) override { at_ = size_t(position); }

private:
    Bytes& bytes_;
    size_t at_ = 0;
};

Imf::Header header_of(const Map& map, const ImageMetadata& metadata)
{
    Imf::Header header(map.width, map.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    const auto set_text = [&](const std::string& key, const std::string& text) {
        header.insert(key.c_str(), Imf::StringAttribute(text));
    };
    set_text("Software", metadata.creator);
    set_text("creator", metadata.creator);
    set_text("history", metadata.history);
    for (const auto& [key, text] : metadata.texts) set_text(key, text);
    for (const auto& [key, number] : metadata.numbers) header.insert(key.c_str(), Imf::FloatAttribute(float(number)));
    for (const auto& channel : map.channels) header.channels().insert(channel.first.c_str(), Imf::Channel(Imf::FLOAT));
    return header;
}

Bytes encoded_map(const std::string& path, const Map& map, const ImageMetadata& metadata)
{
    Bytes bytes;
    try {
        MemoryStream memory(bytes);
        Imf::OutputFile file(memory, header_of(map, metadata), 0);
        Imf::FrameBuffer pixels;
        for (const auto& [name, values] : map.channels) {
            // OpenEXR takes no const: it only reads from the slices of an output file.
            char* first = reinterpret_cast<char*>(const_cast<float*>(values.data()));
            pixels.insert(name.c_str(),
                          Imf::Slice(Imf::FLOAT, first, sizeof(float), sizeof(float) * size_t(map.width)));
        }
        file.setFrameBuffer(pixels);
        file.writePixels(map.height);
    } catch (const std::exception& e) {
        throw IoError(printable(path) + ": cannot encode exr: " + printable(e.what()));
    }
    return bytes;
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
