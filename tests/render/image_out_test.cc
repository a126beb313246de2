// Pictures on disk, read back by OpenImageIO: types, windows, metadata, pixels, and disks that are full.
#include "vdbcloud/render/image_out.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"

#include <OpenImageIO/imageio.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace vdbcloud {
namespace {

namespace fs = std::filesystem;

class ImageOut : public testing::Test {
protected:
    ImageOut()
    {
        std::string name = (fs::temp_directory_path() / "vdbcloud_image_XXXXXX").string();
        folder = mkdtemp(name.data());
    }
    ~ImageOut() override { fs::remove_all(folder); }
    std::string path(const std::string& name) const { return (folder / name).string(); }
    fs::path folder;
};

std::string bytes_of(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Premultiplied foreground of alpha i/width over a blue background.
Film film_of(const ImageSize& size)
{
    Film film(size, {{"", {"R", "G", "B", "A"}},
                     {"background", {"R", "G", "B"}},
                     {"Z", {"Z"}, false, Combine::Nearest},
                     {"transmittance", {"R", "G", "B"}, false},
                     {"direct_sun", {"R", "G", "B"}}});
    const PixelWindow w = film.window();
    for (int j = w.y0; j < w.y1; ++j)
        for (int i = w.x0; i < w.x1; ++i) {
            float* p = film.pixel(i, j);
            const float alpha = float(i) / float(size.width);
            for (int c = 0; c < 3; ++c) {
                p[c] = p[11 + c] = alpha * 0.25f * float(c + 1);
                p[8 + c] = 1 - alpha;
            }
            p[3] = alpha;
            p[6] = (1 - alpha) * 0.5f;
            p[7] = i == 0 ? 1e30f : 3.0f + float(j);
        }
    return film;
}

const ImageSize size{32, 16, 1, {}};

CameraView a_view(const ImageSize& image = size)
{
    Camera camera;
    camera.position = Vec3d(1, 2, 5);
    return {camera, image};
}

ImageMetadata metadata()
{
    ImageMetadata out;
    out.creator = "render 0.1.0";
    out.history = "fractalgen 0.1.0 seed=7\nrender 0.1.0";
    out.texts = {{"vdbcloud:integrator", "cells"}};
    out.numbers = {{"vdbcloud:exposure", 1.5}};
    return out;
}

struct Read {
    OIIO::ImageSpec spec;
    std::vector<float> pixels;
    float at(int i, int j, const std::string& channel) const
    {
        const int c = spec.channelindex(channel);
        EXPECT_GE(c, 0) << channel;
        return pixels[size_t(((j - spec.y) * spec.width + (i - spec.x)) * spec.nchannels + c)];
    }
};

Read read(const std::string& path)
{
    Read out;
    auto input = OIIO::ImageInput::open(path);
    EXPECT_TRUE(input) << OIIO::geterror();
    if (!input) return out;
    out.spec = input->spec();
    out.pixels.resize(size_t(out.spec.width) * size_t(out.spec.height) * size_t(out.spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, out.pixels.data()));
    return out;
}

TEST_F(ImageOut, ExrHasItsChannelsWithTheirTypes)
{
    write_image(path("a.exr"), film_of(size), a_view(), metadata());
    const Read image = read(path("a.exr"));
    const auto type = [&](const char* name) { return image.spec.channelformat(image.spec.channelindex(name)); };
    for (const char* name : {"R", "G", "B", "A", "direct_sun.R", "direct_sun.B"})
        EXPECT_EQ(type(name), OIIO::TypeDesc::HALF);
    for (const char* name : {"Z", "transmittance.R", "transmittance.B"}) EXPECT_EQ(type(name), OIIO::TypeDesc::FLOAT);
    EXPECT_EQ(image.spec.nchannels, 11);  // no background layer by default
    EXPECT_EQ(image.spec.channelindex("background.R"), -1);
    EXPECT_EQ(image.spec.alpha_channel, image.spec.channelindex("A"));
    EXPECT_EQ(image.spec.z_channel, image.spec.channelindex("Z"));
}

TEST_F(ImageOut, ExrKeepsPremultipliedValuesAndLeavesTheBackgroundOut)
{
    write_image(path("a.exr"), film_of(size), a_view(), metadata());
    const Read image = read(path("a.exr"));
    for (const int i : {0, 8, 16, 31}) {
        const float alpha = float(i) / 32;
        EXPECT_EQ(image.at(i, 3, "A"), alpha);  // 1/32 steps are exact in half
        EXPECT_EQ(image.at(i, 3, "R"), alpha * 0.25f);
        EXPECT_EQ(image.at(i, 3, "B"), alpha * 0.75f);
        EXPECT_EQ(image.at(i, 3, "transmittance.G"), 1 - alpha);
        EXPECT_EQ(image.at(i, 3, "direct_sun.G"), alpha * 0.5f);
        EXPECT_EQ(image.at(i, 9, "Z"), i == 0 ? 1e30f : 12.0f);
    }
}

TEST_F(ImageOut, ExrDrawsTheBackgroundWhenAsked)
{
    ImageOptions options;
    options.draw_background = options.background_layer = true;
    write_image(path("a.exr"), film_of(size), a_view(), metadata(), options);
    const Read image = read(path("a.exr"));
    EXPECT_EQ(image.at(8, 0, "A"), 1);
    EXPECT_EQ(image.at(8, 0, "R"), 0.0625f);
    EXPECT_EQ(image.at(8, 0, "B"), 0.1875f + 0.375f);
    EXPECT_EQ(image.at(8, 0, "background.B"), 0.375f);
}

TEST_F(ImageOut, ExrHoldsItsMetadataAndMatrices)
{
    const CameraView view = a_view();
    write_image(path("a.exr"), film_of(size), view, metadata());
    const OIIO::ImageSpec spec = read(path("a.exr")).spec;
    EXPECT_EQ(spec.get_string_attribute("Software"), "render 0.1.0");
    EXPECT_EQ(spec.get_string_attribute("history"), metadata().history);
    EXPECT_EQ(spec.get_string_attribute("creator"), "render 0.1.0");
    EXPECT_EQ(spec.get_string_attribute("vdbcloud:integrator"), "cells");
    EXPECT_FLOAT_EQ(spec.get_float_attribute("vdbcloud:exposure"), 1.5f);
    EXPECT_EQ(spec.get_string_attribute("DateTime"), metadata().date_time);
    EXPECT_NEAR(spec.get_float_attribute("screenWindowWidth"), 2 * std::tan(20 * pi / 180), 1e-6);

    const auto matrix = [&](const char* key, const Matrix44& expected) {
        const auto* found = spec.find_attribute(key, OIIO::TypeDesc::TypeMatrix44);
        ASSERT_TRUE(found) << key;
        for (size_t k = 0; k < 16; ++k)
            EXPECT_FLOAT_EQ(static_cast<const float*>(found->data())[k], float(expected[k]));
    };
    matrix("worldtocamera", view.world_to_camera());  // OpenImageIO's name for OpenEXR's worldToCamera
    matrix("worldToNDC", view.world_to_ndc());
    const auto* colours = spec.find_attribute("chromaticities");
    ASSERT_TRUE(colours);
    EXPECT_FLOAT_EQ(static_cast<const float*>(colours->data())[0], 0.64f);
    // The standard's own name stands in the file itself.
    EXPECT_NE(bytes_of(path("a.exr")).find("worldToCamera"), std::string::npos);
}

TEST_F(ImageOut, ACropIsADataWindowWithinTheDisplayWindow)
{
    ImageSize part = size;
    part.crop = {5, 3, 21, 12};
    write_image(path("part.exr"), film_of(part), a_view(part), metadata());
    write_image(path("whole.exr"), film_of(size), a_view(), metadata());
    const Read crop = read(path("part.exr")), whole = read(path("whole.exr"));
    EXPECT_EQ(crop.spec.x, 5);
    EXPECT_EQ(crop.spec.y, 3);
    EXPECT_EQ(crop.spec.width, 16);
    EXPECT_EQ(crop.spec.height, 9);
    EXPECT_EQ(crop.spec.full_width, 32);
    EXPECT_EQ(crop.spec.full_height, 16);
    for (const auto& name : {"R", "A", "Z"}) EXPECT_EQ(crop.at(7, 4, name), whole.at(7, 4, name));
}

TEST_F(ImageOut, EqualPicturesAreEqualBytes)
{
    for (const std::string name : {"x.exr", "x.png"}) {
        write_image(path("1" + name), film_of(size), a_view(), metadata());
        write_image(path("2" + name), film_of(size), a_view(), metadata());
        const std::string first = bytes_of(path("1" + name));
        EXPECT_GT(first.size(), 100u);
        EXPECT_EQ(first, bytes_of(path("2" + name)));
    }
}

TEST_F(ImageOut, PngShowsTheCompositeThroughTheView)
{
    for (const auto kind : {ViewKind::Srgb, ViewKind::Filmic, ViewKind::None})
        for (const int bits : {8, 16}) {
            ImageOptions options;
            options.view = {kind, 1.0};
            options.png_bits = bits;
            write_image(path("a.png"), film_of(size), a_view(), metadata(), options);
            const Read image = read(path("a.png"));
            EXPECT_EQ(image.spec.nchannels, 3);
            EXPECT_EQ(image.spec.get_string_attribute("oiio:ColorSpace") == "sRGB", kind != ViewKind::None);
            EXPECT_EQ(image.spec.format, bits == 8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::UINT16);
            const double alpha = 24 / 32.0, half_step = 0.5001 / (std::exp2(bits) - 1);
            const Vec3d radiance(alpha * 0.25, alpha * 0.5, alpha * 0.75 + (1 - alpha) * 0.5);
            const Vec3d expected = displayed(radiance, options.view);
            EXPECT_NEAR(image.at(24, 2, "R"), expected[0], half_step);
            EXPECT_NEAR(image.at(24, 2, "G"), expected[1], half_step);
            EXPECT_NEAR(image.at(24, 2, "B"), expected[2], half_step);
            EXPECT_NEAR(image.at(0, 2, "B"), displayed(Vec3d(0, 0, 0.5), options.view)[2], half_step);
        }
}

TEST_F(ImageOut, PngOfMiddleGreyIs118)
{
    Film film(size, {{"", {"R", "G", "B", "A"}}});
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 32; ++i) std::fill_n(film.pixel(i, j), 4, i < 16 ? 0.18f : 9.0f);
    ImageOptions options;
    options.view = {ViewKind::Srgb, 0};
    write_image(path("grey.png"), film, a_view(), metadata(), options);
    const Read image = read(path("grey.png"));
    EXPECT_EQ(std::lround(image.at(1, 1, "G") * 255), 118);
    EXPECT_EQ(std::lround(image.at(30, 1, "G") * 255), 255);
}

TEST_F(ImageOut, StoresALayerAsFloatFrom65505OnAndWarnsOnce)
{
    for (const auto& [value, fits] :
         {std::pair(65504.0f, true), {65505.0f, false}, {-65505.0f, false}, {1e6f, false}}) {
        Film film = film_of(size);
        film.pixel(3, 3)[0] = value;
        film.pixel(4, 3)[1] = value;
        std::vector<std::string> warnings;
        write_image(path("a.exr"), film, a_view(), metadata(), {},
                    [&](const std::string& s) { warnings.push_back(s); });
        const Read image = read(path("a.exr"));
        EXPECT_EQ(image.at(3, 3, "R"), value);
        const auto type = [&](const char* name) { return image.spec.channelformat(image.spec.channelindex(name)); };
        for (const char* name : {"R", "G", "B", "A"})
            EXPECT_EQ(type(name), fits ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT) << value;
        EXPECT_EQ(type("direct_sun.R"), OIIO::TypeDesc::HALF);
        ASSERT_EQ(warnings.size(), fits ? 0u : 1u) << value;
        if (!fits) {
            EXPECT_NE(warnings[0].find("beauty"), std::string::npos);
        }
    }
}

TEST_F(ImageOut, StoresAFaintPictureAsFloat)
{
    // Halves keep 11 bits from 2^-14 = 6.1e-5 upwards and lie 2^-24 apart below: at 1e-7 they err by up to 30 %, below
    // 3e-8 they are 0. Floats are exact. `share`: part of the pixels that is lit at `value`; the others are 0.25.
    const struct {
        float value;
        int share;  // [1/32]
        bool half;
    } table[] = {{0.25f, 32, true},   {6.2e-5f, 32, true}, {6.0e-5f, 32, false}, {1e-7f, 32, false}, {1e-9f, 32, false},
                 {-1e-9f, 32, false}, {1e-7f, 3, true},    {1e-7f, 5, false},    {0.0f, 32, true}};
    for (const auto& [value, share, half] : table) {
        Film film(size, {{"", {"R", "G", "B", "A"}}, {"direct_sun", {"R", "G", "B"}}});
        for (int j = 0; j < 16; ++j)
            for (int i = 0; i < 32; ++i) {
                std::fill_n(film.pixel(i, j), 7, 0.25f);
                film.pixel(i, j)[1] = i < share ? value : 0.25f;
            }
        std::vector<std::string> warnings;
        write_image(path("a.exr"), film, a_view(), metadata(), {},
                    [&](const std::string& s) { warnings.push_back(s); });
        const Read image = read(path("a.exr"));
        const auto type = [&](const char* name) { return image.spec.channelformat(image.spec.channelindex(name)); };
        for (const char* name : {"R", "G", "B", "A"})
            EXPECT_EQ(type(name), half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT) << value << " " << share;
        EXPECT_EQ(type("direct_sun.R"), OIIO::TypeDesc::HALF) << "another layer stays as it is";
        if (!half) {
            EXPECT_EQ(image.at(0, 0, "G"), value);
        }
        if (half) {
            EXPECT_NEAR(image.at(0, 0, "G"), value, 0x1p-25f + 0x1p-12f * value) << "half the spacing of halves";
        }
        EXPECT_TRUE(warnings.empty()) << "nothing is lost";
    }
}

TEST_F(ImageOut, JudgesTheValuesThatAreWritten)
{
    // The foreground alone fits; over its background the drawn pixels do not, and the other way round.
    for (const float behind : {0.5f, 1e5f}) {
        Film film(size, {{"", {"R", "G", "B", "A"}}, {"background", {"R", "G", "B"}}});
        for (int j = 0; j < 16; ++j)
            for (int i = 0; i < 32; ++i) {
                std::fill_n(film.pixel(i, j), 3, behind > 1 ? 0.25f : 1e-8f);
                std::fill_n(film.pixel(i, j) + 4, 3, behind);
            }
        ImageOptions options;
        options.draw_background = true;
        write_image(path("a.exr"), film, a_view(), metadata(), options);
        const Read image = read(path("a.exr"));
        EXPECT_EQ(image.spec.channelformat(0), behind > 1 ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::HALF);
        EXPECT_NEAR(image.at(2, 2, "R"), behind, 1e-3 * behind);
    }
}

TEST_F(ImageOut, KeepsPixelAspectAndTheOrthographicWidth)
{
    Camera camera;
    camera.projection = Projection::Orthographic;
    camera.width = 3.5;
    ImageSize wide = size;
    wide.pixel_aspect = 2;
    const CameraView view(camera, wide);
    write_image(path("a.exr"), film_of(wide), view, metadata());
    write_image(path("a.png"), film_of(wide), view, metadata());
    EXPECT_FLOAT_EQ(read(path("a.exr")).spec.get_float_attribute("PixelAspectRatio"), 2);
    EXPECT_FLOAT_EQ(read(path("a.exr")).spec.get_float_attribute("screenWindowWidth"), 3.5f);
    EXPECT_NEAR(read(path("a.png")).spec.get_float_attribute("PixelAspectRatio"), 2, 1e-3);
}

TEST_F(ImageOut, ThrowsIoErrorOnAFullDiskForBothFormats)
{
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    for (const std::string name : {"full.exr", "full.png"}) {
        fs::create_symlink("/dev/full", path(name));
        try {
            write_image(path(name), film_of(size), a_view(), metadata());
            ADD_FAILURE() << name << ": wrote to a full disk";
        } catch (const IoError& error) {
            EXPECT_EQ(std::string(error.what()).find(path(name)), 0u) << error.what();
        }
    }
    EXPECT_THROW(write_image("/dev/full", film_of(size), a_view(), metadata()), IoError);
}

TEST_F(ImageOut, LeavesNoPartialOrTemporaryFile)
{
    EXPECT_THROW(write_image(path("no/such/folder.exr"), film_of(size), a_view(), metadata()), IoError);
    EXPECT_THROW(write_image(folder.string() + "/.", film_of(size), a_view(), metadata()), std::runtime_error);
    write_image(path("a.exr"), film_of(size), a_view(), metadata());
    ImageOptions keep;
    keep.no_clobber = true;
    EXPECT_THROW(write_image(path("a.exr"), film_of(size), a_view(), metadata(), keep), IoError);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

TEST(ImageFormatOf, GoesByExtensionAndRefusesOthers)
{
    EXPECT_EQ(image_format("a/b.exr"), ImageFormat::Exr);
    EXPECT_EQ(image_format("B.PNG"), ImageFormat::Png);
    EXPECT_EQ(image_format("-"), ImageFormat::Exr);
    EXPECT_EQ(image_format("/dev/null"), ImageFormat::Exr);
    for (const std::string name : {"a.jpg", "exr", "a.exr.gz", ""})
        EXPECT_THROW(image_format(name), UsageError) << name;
}

}  // namespace
}  // namespace vdbcloud
