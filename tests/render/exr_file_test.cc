// .exr files as numbers: what is written is read, wherever the window lies, and files that lie are refused.
#include "vdbcloud/render/exr_file.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/memory.h"

#include <OpenEXR/ImfChannelList.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace vdbcloud {
namespace {

namespace fs = std::filesystem;

class ExrFile : public testing::Test {
protected:
    ExrFile()
    {
        std::string name = (fs::temp_directory_path() / "vdbcloud_exr_XXXXXX").string();
        folder = mkdtemp(name.data());
    }
    ~ExrFile() override { fs::remove_all(folder); }

    std::string write(const std::string& name, const Bytes& bytes) const
    {
        const std::string path = (folder / name).string();
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
        return path;
    }

    /// What read_exr says of a file that it refuses.
    static std::string refusal(const std::string& path)
    {
        try {
            read_exr(path);
        } catch (const IoError& e) {
            return e.what();
        }
        return "read";
    }

    fs::path folder;
};

constexpr int width = 7, height = 5;

/// Two channels of a pixel together: A, that halves hold, and B, that they do not.
std::vector<float> two_channels()
{
    std::vector<float> values;
    for (int k = 0; k < width * height; ++k) values.insert(values.end(), {float(k) / 8, 1 + float(k) * 1e-5f});
    return values;
}

Bytes encoded(const std::vector<float>& values, int x, int y)
{
    Imf::Header header(40, 30, Imath::Box2i({x, y}, {x + width - 1, y + height - 1}));
    header.compression() = Imf::ZIP_COMPRESSION;
    set_text_attribute(header, "what", "a test");
    return encoded_exr("t.exr", header, {{"A", true, values.data(), 2}, {"B", false, values.data() + 1, 2}});
}

TEST_F(ExrFile, IsReadAsItWasWrittenWhereverItsWindowLies)
{
    const auto values = two_channels();
    for (const auto& [x, y] : {std::pair{0, 0}, {3, 11}, {-9, 2}, {100000, -70000}}) {
        const ExrPicture picture = read_exr(write("a.exr", encoded(values, x, y)));
        EXPECT_EQ(picture.values, values) << x << " " << y;
        EXPECT_EQ(picture.header.dataWindow().min, Imath::V2i(x, y));
        EXPECT_EQ(picture.header.channels().findChannel("A")->type, Imf::HALF);
        EXPECT_EQ(picture.header.channels().findChannel("B")->type, Imf::FLOAT);
        EXPECT_EQ(text_attribute(picture.header, "what"), "a test");
        EXPECT_EQ(text_attribute(picture.header, "compression"), "") << "no text";
    }
}

TEST_F(ExrFile, HalvesAreRoundedToTheNearest)
{
    // Halves near 1 are 2^-10 apart; 1 + 1.5 x 2^-10 is in the middle of two, and goes to the even one.
    const std::vector<float> values{1 + 0x0.9p-10f, 1 + 0x0.7p-10f, 1 + 0x1.8p-10f, -3e-8f};
    const Bytes file = encoded_exr("t.exr", Imf::Header(2, 2), {{"Y", true, values.data(), 1}});
    const std::vector<float> expected{1 + 0x1p-10f, 1, 1 + 0x2p-10f, -0x1p-24f};
    EXPECT_EQ(read_exr(write("a.exr", file)).values, expected);
}

TEST_F(ExrFile, RefusesFilesThatLieWithTheirName)
{
    const auto values = two_channels();
    const Bytes whole = encoded(values, 0, 0);
    EXPECT_NE(refusal(write("cut.exr", Bytes(whole.begin(), whole.end() - 40))).find("cut.exr"), std::string::npos);
    EXPECT_NE(refusal(write("text.exr", {'t', 'e', 'x', 't'})).find("cannot read it as an .exr"), std::string::npos);
    EXPECT_NE(refusal(folder.string()).find("no regular file"), std::string::npos);
    EXPECT_NE(refusal((folder / "none.exr").string()).find("cannot read"), std::string::npos);

    // Rows of 3e6 pixels in some hundred bytes: the largest x is a whole number of four bytes behind the attribute's
    // name, type and size and the least x and y.
    Bytes claims = whole;
    const std::string key("dataWindow\0box2i\0", 17);
    const auto at = std::search(claims.begin(), claims.end(), key.begin(), key.end());
    ASSERT_NE(at, claims.end());
    const int32_t last = 2999999;
    std::copy_n(reinterpret_cast<const unsigned char*>(&last), 4, at + int(key.size()) + 4 + 8);
    const std::string claim = refusal(write("claims.exr", claims));
    EXPECT_NE(claim.find("3000000 x 5 pixels in"), std::string::npos) << claim;
}

// OpenEXR allocates what an attribute claims, up to 2 GiB, before it reads.
TEST_F(ExrFile, RefusesAttributesThatClaimMoreThanTheFile)
{
    const Bytes whole = encoded(two_channels(), 0, 0);
    const std::string key("what\0string\0", 12);
    const auto at = std::search(whole.begin(), whole.end(), key.begin(), key.end()) - whole.begin();
    const size_t behind = whole.size() - size_t(at) - key.size() - 4;
    const auto claiming = [&](uint32_t size) {
        Bytes bytes = whole;
        for (size_t k = 0; k < 4; ++k) bytes[size_t(at) + key.size() + k] = (unsigned char)(size >> (8 * k));
        return refusal(write("claim.exr", bytes));
    };
    EXPECT_EQ(claiming(6), "read");
    EXPECT_EQ(claiming(uint32_t(behind)).find("attribute 'what' claims"), std::string::npos) << "OpenEXR's to refuse";
    for (const uint32_t size : {uint32_t(behind) + 1, 0x3fffffffu, 0x7fffffffu, 0xffffffffu})
        EXPECT_NE(claiming(size).find("attribute 'what' claims " + std::to_string(size) + " bytes, " +
                                      std::to_string(behind) + " follow"),
                  std::string::npos)
            << claiming(size);
    // Of a second part, too.
    Bytes parts = whole;
    parts[5] |= 0x10;
    const std::string second(std::string("more\0string\0", 12) + "\xff\xff\xff\x7f");
    const std::string empty(1, '\0');
    parts.resize(size_t(at) + key.size() + 4 + 6);  // "what" is the last attribute, with "a test"
    for (const char c : empty + second) parts.push_back((unsigned char)c);
    EXPECT_NE(refusal(write("parts.exr", parts)).find("attribute 'more' claims 2147483647"), std::string::npos)
        << refusal(write("parts.exr", parts));
}

// Twice the memory that is left, in a file of the size that could hold it.
TEST_F(ExrFile, RefusesPixelsThatMemoryCannotHold)
{
    const auto left = memory_left();
    if (!left) GTEST_SKIP() << "the system does not say how much memory is left";
    const int side = int(std::sqrt(2 * left->bytes / 4));
    Imf::Header header(side, 16);
    header.compression() = Imf::ZIP_COMPRESSION;
    const std::vector<float> values(size_t(side) * 16);
    Bytes bytes = encoded_exr("t.exr", header, {{"Y", false, values.data(), 1}});
    const std::string key("dataWindow\0box2i\0", 17);
    const auto at = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
    ASSERT_NE(at, bytes.end());
    const int32_t last = side - 1;
    std::copy_n(reinterpret_cast<const unsigned char*>(&last), 4, at + int(key.size()) + 4 + 12);
    const std::string file = write("large.exr", bytes);
    fs::resize_file(file, uintmax_t(left->bytes / 1000));
    const std::string said = refusal(file);
    EXPECT_NE(said.find("not enough memory: its pixels take"), std::string::npos) << said;
}

}  // namespace
}  // namespace vdbcloud
