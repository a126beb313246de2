// The module of picture_module.h: .png to write, and pictures of any format to read, by OpenImageIO.
#include "vdbcloud/render/picture_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

namespace vdbcloud {

namespace {

std::string encode_png(const PngPicture& picture, Bytes& file)
{
    const auto type = picture.bits == 16 ? OIIO::TypeDesc::UINT16 : OIIO::TypeDesc::UINT8;
    OIIO::ImageSpec spec(picture.width, picture.height, 3, type);
    const ImageMetadata& metadata = picture.metadata;
    spec.attribute("Software", metadata.creator);
    spec.attribute("creator", metadata.creator);
    spec.attribute("history", metadata.history);
    spec.attribute("DateTime", metadata.date_time);
    for (const auto& [key, text] : metadata.texts) spec.attribute(key, text);
    spec.attribute("oiio:ColorSpace", picture.linear ? "Linear" : "sRGB");
    if (picture.pixel_aspect != 1) spec.attribute("PixelAspectRatio", float(picture.pixel_aspect));
    const auto output = OIIO::ImageOutput::create("image.png");
    if (!output) return "OpenImageIO has no writer for png";
    OIIO::Filesystem::IOVecOutput memory(file);
    // A writer may report success and hold an error, so every step and the remaining error are looked at.
    const bool done = output->set_ioproxy(&memory) && output->open("image.png", spec) &&
                      output->write_image(type, picture.values) && output->close();
    if (done && !output->has_error()) return {};
    const std::string trouble = output->geterror();
    return trouble.empty() ? "unknown reason" : trouble;
}

std::string read(const std::string& path, const std::function<void(const PictureSize&)>& check, Pixels& pixels)
{
    const auto input = OIIO::ImageInput::open(path);
    if (!input) return OIIO::geterror();
    const OIIO::ImageSpec& spec = input->spec();
    check({spec.width, spec.height, spec.nchannels, spec.pixel_bytes(/*native=*/true)});
    const size_t count = size_t(spec.width) * size_t(spec.height) * size_t(spec.nchannels);
    pixels = {spec.width, spec.height, spec.nchannels, std::vector<float>(count)};
    if (input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.values.data())) return {};
    const std::string trouble = input->geterror();
    return trouble.empty() ? "unknown reason" : trouble;
}

}  // namespace

}  // namespace vdbcloud

extern "C" const vdbcloud::PictureModule* vdbcloud_picture_module_1()
{
    static const vdbcloud::PictureModule module{vdbcloud::encode_png, vdbcloud::read};
    return &module;
}
