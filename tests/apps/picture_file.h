#pragma once
// Pictures that a program wrote.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace vdbcloud::test {

struct PictureFile {
    OIIO::ImageSpec spec;
    std::vector<float> pixels;

    std::string text(const char* key) const { return spec.get_string_attribute(key); }
    float at(int i, int j, const std::string& channel) const
    {
        const int c = spec.channelindex(channel);
        EXPECT_GE(c, 0) << "no channel " << channel;
        return c < 0 ? 0 : pixels[size_t(((j - spec.y) * spec.width + i - spec.x) * spec.nchannels + c)];
    }
};

/// All channels of the file as floats; a failure of the test if it cannot be read.
inline PictureFile picture(const std::string& path)
{
    PictureFile out;
    auto input = OIIO::ImageInput::open(path);
    EXPECT_TRUE(input) << path << ": " << OIIO::geterror();
    if (!input) return out;
    out.spec = input->spec();
    out.pixels.resize(size_t(out.spec.width) * size_t(out.spec.height) * size_t(out.spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, out.pixels.data()));
    return out;
}

}  // namespace vdbcloud::test
