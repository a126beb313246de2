#include "support/picture_file.h"

#include "support/run.h"

#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

void read_header(const Imf::Header& header, PictureFile& out)
{
    const auto& window = header.dataWindow();
    out.x = window.min.x;
    out.y = window.min.y;
    out.width = window.max.x - window.min.x + 1;
    out.height = window.max.y - window.min.y + 1;
    out.full_width = header.displayWindow().max.x - header.displayWindow().min.x + 1;
    for (const char* name : {"R", "G", "B", "A"})
        if (header.channels().findChannel(name)) out.channels.push_back(name);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c)
        if (out.channel(c.name()) < 0) out.channels.push_back(c.name());
    for (auto a = header.begin(); a != header.end(); ++a) {
        if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute()))
            out.texts[a.name()] = text->value();
        if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&a.attribute()))
            out.numbers[a.name()] = double(number->value());
        if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&a.attribute()))
            out.numbers[a.name()] = number->value();
        if (const auto* number = dynamic_cast<const Imf::IntAttribute*>(&a.attribute()))
            out.numbers[a.name()] = number->value();
    }
}

}  // namespace

int PictureFile::channel(const std::string& name) const
{
    const auto found = std::find(channels.begin(), channels.end(), name);
    return found == channels.end() ? -1 : int(found - channels.begin());
}

std::vector<float> PictureFile::layer(const std::string& name) const
{
    std::vector<float> all;
    const int c = channel(name);
    for (size_t k = size_t(c); c >= 0 && k < pixels.size(); k += channels.size()) all.push_back(pixels[k]);
    return all;
}

float PictureFile::at(int i, int j, const std::string& name) const
{
    const int c = channel(name);
    if (c < 0) throw std::out_of_range("no channel " + name);
    return pixels.at(size_t((j - y) * width + i - x) * channels.size() + size_t(c));
}

std::string PictureFile::text(const std::string& key) const
{
    const auto found = texts.find(key);
    return found == texts.end() ? "" : found->second;
}

double PictureFile::number(const std::string& key) const
{
    const auto found = numbers.find(key);
    return found == numbers.end() ? 0 : found->second;
}

bool PictureFile::same_values(const PictureFile& other) const
{
    return channels == other.channels && x == other.x && y == other.y && width == other.width &&
           std::equal(pixels.begin(), pixels.end(), other.pixels.begin(), other.pixels.end(),
                      [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); });
}

PictureFile picture(const std::string& path)
{
    if (path.size() < 4 || path.substr(path.size() - 4) != ".exr") {
        const RunResult made = run({"oiiotool", path, "-d", "float", "-o", path + ".exr"});
        if (made.status != 0) throw std::runtime_error(path + " is not a picture: " + made.err + made.out);
        return picture(path + ".exr");
    }
    PictureFile out;
    Imf::InputFile file(path.c_str());
    read_header(file.header(), out);
    const size_t pixel = out.channels.size() * sizeof(float), row = pixel * size_t(out.width);
    out.pixels.resize(out.channels.size() * size_t(out.width) * size_t(out.height));
    Imf::FrameBuffer buffer;
    for (size_t c = 0; c < out.channels.size(); ++c)
        buffer.insert(out.channels[c],
                      Imf::Slice::Make(Imf::FLOAT, out.pixels.data() + c, file.header().dataWindow(), pixel, row));
    file.setFrameBuffer(buffer);
    file.readPixels(out.y, out.y + out.height - 1);
    return out;
}

}  // namespace vdbcloud::test
