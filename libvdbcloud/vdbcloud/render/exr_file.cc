#include "vdbcloud/render/exr_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/render/image_out.h"
#include "vdbcloud/render/picture_bytes.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cstdint>

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

size_t width_of(const Imf::Header& header)
{
    return size_t(int64_t(header.dataWindow().max.x) - header.dataWindow().min.x + 1);
}

size_t height_of(const Imf::Header& header)
{
    return size_t(int64_t(header.dataWindow().max.y) - header.dataWindow().min.y + 1);
}

}  // namespace

void set_text_attribute(Imf::Header& header, const std::string& key, const std::string& text)
{
    header.insert(key.c_str(), Imf::StringAttribute(text));
}

void set_number_attribute(Imf::Header& header, const std::string& key, double number)
{
    header.insert(key.c_str(), Imf::FloatAttribute(float(number)));
}

std::string text_attribute(const Imf::Header& header, const char* key)
{
    const auto* found = header.findTypedAttribute<Imf::StringAttribute>(key);
    return found ? found->value() : std::string();
}

void set_attributes(Imf::Header& header, const ImageMetadata& metadata)
{
    set_text_attribute(header, "Software", metadata.creator);
    set_text_attribute(header, "creator", metadata.creator);
    set_text_attribute(header, "history", metadata.history);
    for (const auto& [key, text] : metadata.texts) set_text_attribute(header, key, text);
    for (const auto& [key, number] : metadata.numbers) set_number_attribute(header, key, number);
}

Bytes encoded_exr(const std::string& path, Imf::Header header, const std::vector<ExrChannel>& channels)
{
    const size_t width = width_of(header), pixels = width * height_of(header);
    Bytes bytes;
    try {
        header.channels() = Imf::ChannelList();
        Imf::FrameBuffer frame;
        std::vector<std::vector<half>> halves;
        for (const ExrChannel& channel : channels) {
            const char* name = channel.name.c_str();
            if (!channel.half) {
                header.channels().insert(name, Imf::Channel(Imf::FLOAT));
                const size_t pixel = channel.stride * sizeof(float);
                frame.insert(name,
                             Imf::Slice::Make(Imf::FLOAT, channel.values, header.dataWindow(), pixel, pixel * width));
                continue;
            }
            std::vector<half> values(pixels);
            for (size_t k = 0; k < pixels; ++k) values[k] = half(channel.values[k * channel.stride]);
            header.channels().insert(name, Imf::Channel(Imf::HALF));
            frame.insert(name, Imf::Slice::Make(Imf::HALF, values.data(), header.dataWindow(), sizeof(half),
                                                sizeof(half) * width));
            halves.push_back(std::move(values));
        }
        MemoryStream memory(bytes);
        Imf::OutputFile file(memory, header, 0);
        file.setFrameBuffer(frame);
        file.writePixels(int(height_of(header)));
    } catch (const std::exception& e) {
        throw IoError(printable(path) + ": cannot encode exr: " + printable(e.what()));
    }
    return bytes;
}

ExrPicture read_exr(const std::string& path)
{
    const uint64_t file_bytes = bytes_of_picture(path);
    ExrPicture picture;
    try {
        Imf::InputFile file(path.c_str(), 0);
        picture.header = file.header();
        const Imf::Header& header = picture.header;
        size_t channels = 0, pixel_bytes = 0;
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c, ++channels)
            pixel_bytes += c.channel().type == Imf::HALF ? sizeof(half) : sizeof(float);
        check_claim(path, file_bytes, width_of(header), height_of(header), pixel_bytes);
        check_memory(path, 4.0 * double(width_of(header)) * double(height_of(header)) * double(channels));
        picture.values.resize(width_of(header) * height_of(header) * channels);
        Imf::FrameBuffer frame;
        size_t at = 0;
        for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
            const size_t pixel = channels * sizeof(float);
            frame.insert(c.name(), Imf::Slice::Make(Imf::FLOAT, picture.values.data() + at++, header.dataWindow(),
                                                    pixel, pixel * width_of(header)));
        }
        file.setFrameBuffer(frame);
        file.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
    } catch (const IoError&) {
        throw;
    } catch (const std::exception& e) {
        throw IoError(printable(path) + ": cannot read it as an .exr: " + printable(e.what()));
    }
    return picture;
}

}  // namespace vdbcloud
