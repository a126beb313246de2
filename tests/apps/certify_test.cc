// render --certify, --correct and --error-png as a user runs them.
#include "in_folder.h"
#include "support/picture_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbcloud::test {
namespace {

/// A folder with lit.vdb (one sun), scattered.vdb (multiple scattering, too) and sky.vdb (albedo 1, a sky of radiance 1
/// alone).
class Certify : public InFolder<Certify> {
public:
    static constexpr const char* made =
        "fractalgen -q --size 16 -o cloud.vdb && illuminate -q cloud.vdb --extinction 20 --albedo 0.99 --g 0.5 "
        "--sun 0.3,1,0.2 -o lit.vdb && p1solve -q lit.vdb -o scattered.vdb && "
        "p1solve -q cloud.vdb --extinction 20 --albedo 1 --sky 1 -o sky.vdb";

protected:
    /// The certificate in the report of one run.
    static nlohmann::json certificate(const std::string& options)
    {
        expect_done("render -q --resolution 48 --json r.json -o picture.exr " + options);
        return nlohmann::json::parse(read_text(*folder_ / "r.json"), nullptr, false)["certificate"];
    }
    /// Mean luminance of a picture.
    static double mean(const std::string& path)
    {
        const PictureFile file = picture(*folder_ / path);
        const auto n = file.channels.size();
        double sum = 0;
        for (size_t k = 0; k < file.pixels.size(); k += n)
            sum += 0.2126 * file.pixels[k + size_t(file.channel("R"))] +
                   0.7152 * file.pixels[k + size_t(file.channel("G"))] +
                   0.0722 * file.pixels[k + size_t(file.channel("B"))];
        return sum;
    }
};

TEST_F(Certify, FurnaceHasNoError)
{
    // Matter that absorbs nothing under a sky of radiance 1 shows 1 in both pictures, in each sample: to rounding, and
    // to P1's solver. Also where another background is drawn.
    for (const char* background : {"", "--background sky", "--background 5,1,2", "--background none"}) {
        const auto c = certificate(std::string("sky.vdb --certify 90% ") + background);
        EXPECT_NEAR(c["luminance"], 1, 1e-3) << background;
        EXPECT_LT(std::abs(double(c["mean"]["value"])), 1e-3) << background;
        EXPECT_LT(double(c["rms_8x8"]["high"]), 2e-3) << background;
    }
}

TEST_F(Certify, ErrorOfSingleScatteringIsThatAgainstPaths)
{
    // Most of the light is scattered more than once.
    const auto c = certificate("lit.vdb --certify 1%");
    const double picture_light = mean("picture.exr");
    expect_done("render -q --resolution 48 lit.vdb --integrator path --spp 100 --seed 77 -o truth.exr");
    const double expected = picture_light / mean("truth.exr") - 1;
    EXPECT_LT(expected, -0.3);
    // The reference's own noise: 100 samples a pixel, 0.2 % of the mean.
    EXPECT_NEAR(double(c["mean"]["value"]), expected,
                1.5 * (double(c["mean"]["high"]) - double(c["mean"]["value"])) + 4e-3);
    EXPECT_LT(double(c["mean"]["high"]) - double(c["mean"]["low"]), 0.05);
    EXPECT_GT(double(c["rms_32x32"]["low"]), 0.9 * std::abs(expected));
    EXPECT_LT(double(c["rms_32x32"]["high"]), 1.5 * std::abs(expected));
    EXPECT_GE(double(c["rms_8x8"]["value"]), double(c["rms_32x32"]["low"]));
    EXPECT_TRUE(c["reached"]);
    EXPECT_TRUE(c["reliable"]);
}

TEST_F(Certify, SeesTheSkyThatIsAskedForWhereNoFileHasOne)
{
    // Of an albedo of 0.99 the matter sends back nearly all of a uniform sky's light, and hides it as well.
    const std::string sky = " --sky-zenith 3,3,3 --sky-horizon 3,3,3 --sky-ground 3,3,3";
    const double without = certificate("lit.vdb --certify 5%")["luminance"];
    const double with = certificate("lit.vdb --certify 5%" + sky)["luminance"];
    EXPECT_GT(with - without, 0.85 * 3);
    EXPECT_LT(with - without, 1.02 * 3);
}

TEST_F(Certify, IsToldStampedAndEqualForAnyThreads)
{
    const RunResult r =
        expect_done("render --resolution 24 scattered.vdb --certify 30% --error-png errors.png -o one.exr --threads 1");
    EXPECT_NE(r.err.find(" % rms over 32x32 pixels, mean "), std::string::npos) << r.err;
    EXPECT_NE(r.err.find(" CPU s\n"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("not covered: "), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("errors.png: red is "), std::string::npos) << r.err;
    expect_done("render -q --resolution 24 scattered.vdb --certify 30% -o two.exr --threads 2");
    EXPECT_EQ(in_folder("idiff -q -fail 0 -warn 0 one.exr two.exr").status, 0);
    const PictureFile one = picture(*folder_ / "one.exr"), two = picture(*folder_ / "two.exr");
    EXPECT_EQ(one.text("vdbcloud:certificate"), two.text("vdbcloud:certificate"));
    EXPECT_NE(one.text("vdbcloud:certificate").find("rms over 32x32"), std::string::npos);
    for (const char* key : {"vdbcloud:error_32x32", "vdbcloud:error_8x8_high", "vdbcloud:certificate_samples"})
        EXPECT_GT(one.number(key), 0) << key;
    for (const char* channel : {"block_error.R", "block_error.G", "block_error.B", "block_deviation.Y"})
        EXPECT_GE(one.channel(channel), 0) << channel;
    for (const char* channel : {"block_guess.Y", "sky.R", "correction.R"})
        EXPECT_LT(one.channel(channel), 0) << channel;
    // Another seed has another noise.
    expect_done("render -q --resolution 24 scattered.vdb --certify 30% -o seed.exr --samples 4 --seed 3");
    EXPECT_NE(picture(*folder_ / "seed.exr").text("vdbcloud:certificate"), one.text("vdbcloud:certificate"));
}

TEST_F(Certify, CorrectionIsThePictureLessItsError)
{
    const auto plain = certificate("lit.vdb --certify 2%");
    const auto corrected = certificate("lit.vdb --certify 2% --correct");
    EXPECT_LT(double(corrected["rms_8x8"]["high"]), 0.5 * double(plain["rms_8x8"]["low"]));
    EXPECT_LT(std::abs(double(corrected["mean"]["value"])), 0.1 * std::abs(double(plain["mean"]["value"])));
    const PictureFile with = picture(*folder_ / "picture.exr");
    expect_done("render -q --resolution 48 lit.vdb -o without.exr");
    const PictureFile without = picture(*folder_ / "without.exr");
    const auto n = with.channels.size(), m = without.channels.size();
    double largest = 0;
    for (size_t k = 0; k < with.pixels.size() / n; ++k) {
        const auto of = [&](const char* channel) { return with.pixels[k * n + size_t(with.channel(channel))]; };
        const float alone = without.pixels[k * m + size_t(without.channel("G"))];
        // R, G, B are halves, whose least step is 6e-8.
        EXPECT_NEAR(of("G") - of("correction.G"), alone, 2e-3 * std::abs(of("G")) + 1e-3 * alone + 6e-8);
        if (of("A") == 0) {
            EXPECT_NEAR(of("correction.G"), 0, 6e-8);
        }
        EXPECT_GE(of("G"), 0);
        largest = std::max(largest, double(of("correction.G")));
    }
    EXPECT_GT(largest, 0);
}

TEST_F(Certify, WhatCannotBeIsRefusedInASentence)
{
    const std::tuple<const char*, int, const char*> lines[] = {
        {"lit.vdb --certify 5s -o x.exr", 2,
         "--certify: '5s': expected seconds (30), a half-width of the error (0.5%)"},
        {"lit.vdb --certify 1,2 -o x.exr", 2, "expected seconds"},
        {"lit.vdb --certify 0% -o x.exr", 2, "expected seconds"},
        {"lit.vdb --certify '' -o x.exr", 2, "expected seconds"},
        {"lit.vdb --certify 1 --integrator path -o x.exr", 2, "--certify has no effect with --integrator path"},
        {"lit.vdb --correct -o x.exr", 2, "--correct has no effect without --certify"},
        {"lit.vdb --certify 1 --sun-irradiance 0 --sun 0,1,0 -o x.exr", 1, "no light"},
        {"scattered.vdb --certify 0.001%,0.01 -o late.exr", 3, "the picture is written"}};
    for (const auto& [line, status, sentence] : lines) {
        const RunResult r = in_folder(std::string("render -q --resolution 12 ") + line);
        EXPECT_EQ(r.status, status) << line << r.err;
        EXPECT_NE(r.err.find(sentence), std::string::npos) << line << "\n" << r.err;
    }
    EXPECT_EQ(in_folder("test -e x.exr").status, 1);
    EXPECT_EQ(in_folder("test -e late.exr").status, 0);
    // A certificate is of one picture's samples.
    expect_done("render -q --resolution 12 scattered.vdb --gather 2 --spp 2 --certify 0.01 -o a.exr");
    expect_done("render -q --resolution 12 scattered.vdb --gather 2 --spp 2 --spp-offset 2 -o b.exr");
    for (const char* inputs : {"a.exr b.exr", "b.exr a.exr", "a.exr"}) {
        const RunResult r = in_folder(std::string("exrmerge ") + inputs + " -o merged.exr");
        EXPECT_EQ(r.status, 1) << inputs;
        EXPECT_NE(r.err.find("has a certificate"), std::string::npos) << r.err;
    }
}

}  // namespace
}  // namespace vdbcloud::test
