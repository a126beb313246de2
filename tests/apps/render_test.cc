// render as a user runs it: on small grids, against closed forms where there are any.
#include "support/picture_file.h"
#include "support/run.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/schema.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::picture;
using test::PictureFile;
using test::program;
using test::read_text;

/// The greatest difference of two pictures in a channel, relative to the first one's greatest value there.
double difference(const PictureFile& a, const PictureFile& b, const std::string& channel)
{
    double most = 0, scale = 0;
    for (int j = 0; j < a.height; ++j)
        for (int i = 0; i < a.width; ++i) {
            most = std::max(most, double(std::abs(a.at(i, j, channel) - b.at(i, j, channel))));
            scale = std::max(scale, double(std::abs(a.at(i, j, channel))));
        }
    EXPECT_GT(scale, 0) << channel << " is black";
    return most / scale;
}

using Transform = openvdb::math::Transform;

Transform::Ptr scaled(double h) { return Transform::createLinearTransform(h); }

/// A lump of 16^3 voxels, denser in the middle, uneven; where `keep` says so.
template<typename F>
void write_lump(const std::string& path, const Transform::Ptr& transform, F keep)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(transform);
    auto accessor = grid->getAccessor();
    for (int x = -8; x < 8; ++x)
        for (int y = -8; y < 8; ++y)
            for (int z = -8; z < 8; ++z) {
                const double r = std::sqrt(x * x + y * y + z * z) / 8;
                const double u = uniform(hash_bits(3, uint64_t(x + 8), uint64_t(y + 8), uint64_t(z + 8)));
                if (r < 1 && keep(Coord(x, y, z))) accessor.setValue(Coord(x, y, z), float((1 - r) * (0.5 + u)));
            }
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {grid};
    write_grid_file(path, file);
}

void write_lump(const std::string& path, const Transform::Ptr& transform = scaled(0.25))
{
    write_lump(path, transform, [](const Coord&) { return true; });
}

class Render : public testing::Test {
protected:
    std::string path(const std::string& name) const { return scratch / name; }

    test::RunResult run(std::vector<std::string> arguments)
    {
        arguments.insert(arguments.begin(), program("render"));
        return test::run(arguments);
    }
    /// Runs at a small size and expects success.
    PictureFile rendered(const std::string& input, const std::string& output, std::vector<std::string> arguments = {})
    {
        arguments.insert(arguments.end(), {input, "-o", path(output), "--resolution", "32"});
        const auto result = run(arguments);
        EXPECT_EQ(result.status, 0) << result.err;
        return picture(path(output));
    }
    void expect_refused(int status, const std::string& word, const std::vector<std::string>& arguments)
    {
        const auto result = run(arguments);
        EXPECT_EQ(result.status, status) << word << "\n" << result.err;
        EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    }
    test::Scratch scratch;
};

TEST_F(Render, AFileWithoutMetadataIsFramedLitAndExposed)
{
    write_lump(path("lump.vdb"));
    const auto result = run({path("lump.vdb"), "-o", path("a.exr"), "--png", path("a.png")});
    EXPECT_EQ(result.status, 0) << result.err;
    const PictureFile exr = picture(path("a.exr")), png = picture(path("a.png"));
    EXPECT_EQ(exr.width, 512);
    EXPECT_GT(exr.at(256, 256, "A"), 0.9);
    EXPECT_EQ(exr.at(2, 2, "A"), 0);
    EXPECT_GT(exr.at(230, 200, "R"), 0.05);
    EXPECT_EQ(exr.at(2, 2, "Z"), 1e30f);
    EXPECT_LT(exr.at(256, 256, "Z"), 100);
    EXPECT_GT(png.at(230, 200, "R"), 0.5);                  // exposed
    EXPECT_GT(png.at(2, 2, "B"), png.at(2, 2, "R") + 0.1);  // before a blue sky
    EXPECT_NE(exr.text("history").find("render 0."), std::string::npos);
}

TEST_F(Render, MeetsTheSunAxisIdentitiesPixelByPixel)
{
    // With the sun behind the camera L = w0 p(-1) E (1 - T^2)/2, looking into it w0 p(1) E tau exp(-tau), for
    // any density.
    write_lump(path("lump.vdb"));
    const double w0 = 0.8, g = 0.3, E = 2;
    for (const double side : {-1.0, 1.0}) {
        const PictureFile p =
            rendered(path("lump.vdb"), "a.exr",
                     {"--projection", "orthographic", "--direction", "0.3,-0.4,-1", "--sun",
                      side < 0 ? "-0.3,0.4,1" : "0.3,-0.4,-1", "--sun-irradiance", "2,2,2", "--albedo", "0.8", "--g",
                      "0.3", "--extinction", "0.6", "--shadow-rays", "--aov", "transmittance,direct"});
        const double phase = (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * side, 1.5));
        int seen = 0;
        for (int j = 0; j < 32; ++j)
            for (int i = 0; i < 32; ++i) {
                const double T = p.at(i, j, "transmittance.G"), tau = -std::log(T);
                const double expected = w0 * phase * E * (side < 0 ? (1 - T * T) / 2 : tau * T);
                // Half floats round by 2^-11; the march, at sigma_t h = 0.2, adds less than that.
                EXPECT_NEAR(p.at(i, j, "G"), expected, expected * 1e-3 + 2e-5 * w0 * phase * E);
                EXPECT_EQ(p.at(i, j, "G"), p.at(i, j, "direct_sun.G"));
                EXPECT_NEAR(p.at(i, j, "A"), 1 - T, 1e-3);
                seen += T < 0.7;
            }
        EXPECT_GT(seen, 50);
    }
}

TEST_F(Render, PicturesAreByteIdenticalOnAnyNumberOfThreads)
{
    write_lump(path("lump.vdb"));
    const std::vector<std::string> line{path("lump.vdb"), "--samples", "4", "--resolution", "40x24"};
    std::map<std::string, std::string> bytes;
    for (const std::string threads : {"1", "2", "3"})
        for (const std::string name : {".exr", ".png"}) {
            auto with = line;
            with.insert(with.end(), {"--threads", threads, "-o", path("out" + name)});
            if (name == ".exr") with.insert(with.end(), {"--aov", "all"});
            EXPECT_EQ(run(with).status, 0);
            const std::string now = read_text(path("out" + name));
            EXPECT_GT(now.size(), 500u);
            EXPECT_TRUE(bytes.emplace(name, now).first->second == now) << name << " with " << threads << " threads";
        }
}

TEST_F(Render, APipeOfStagesWritesEqualBytesToFiles)
{
    write_lump(path("lump.vdb"));
    const std::string light = "illuminate --sun 0.3,1,0.2 -q ", picture = "render --resolution 32 -q ";
    test::RunOptions there;
    there.folder = scratch.path();
    const auto files = test::shell(light + "lump.vdb -o lit.vdb && " + picture + "lit.vdb -o files.exr", there);
    EXPECT_EQ(files.status, 0) << files.err;
    const auto pipe = test::shell(light + "lump.vdb -o - | " + picture + "- -o - > pipe.exr", there);
    EXPECT_EQ(pipe.status, 0) << pipe.err;
    EXPECT_TRUE(read_text(path("files.exr")) == read_text(path("pipe.exr")));
    EXPECT_EQ(files.err, "");  // the light's grid was taken as it is
}

TEST_F(Render, ACropIsPartOfTheWhole)
{
    write_lump(path("lump.vdb"));
    const PictureFile whole = rendered(path("lump.vdb"), "whole.exr", {"--samples", "3"});
    const PictureFile part = rendered(path("lump.vdb"), "part.exr", {"--samples", "3", "--crop", "9,5,20,30"});
    EXPECT_EQ(part.x, 9);
    EXPECT_EQ(part.height, 25);
    EXPECT_EQ(part.full_width, 32);
    for (int j = 5; j < 30; ++j)
        for (int i = 9; i < 20; ++i)
            for (const auto& channel : {"R", "A", "Z"}) ASSERT_EQ(part.at(i, j, channel), whole.at(i, j, channel));
}

TEST_F(Render, PictureIsInvariantUnderScaleTranslationAndUpAxis)
{
    write_lump(path("lump.vdb"));
    auto large = scaled(0.25 * 400);
    large->postTranslate(Vec3d(1e4, -300, 70));
    write_lump(path("large.vdb"), large);
    auto turned = scaled(0.25);
    turned->postRotate(openvdb::math::pi<double>() / 2, openvdb::math::X_AXIS);  // y to z, z to -y
    write_lump(path("turned.vdb"), turned);
    const PictureFile rest = rendered(path("lump.vdb"), "a.exr");
    const PictureFile scaled_up = rendered(path("large.vdb"), "b.exr"),
                      z_up = rendered(path("turned.vdb"), "c.exr", {"--up", "z"});
    for (const auto& channel : {"R", "A"}) {  // half floats round by 2^-11
        EXPECT_LT(difference(rest, scaled_up, channel), 1e-3);
        EXPECT_LT(difference(rest, z_up, channel), 1e-3);
    }
}

TEST_F(Render, SeveralInputsAddUp)
{
    write_lump(path("whole.vdb"));
    // Thinner all over, in two files: extinction 0.4 + 0.6 of one.
    const std::vector<std::string> view{"--sun", "1,1,1", "--resolution", "24", "--aov", "transmittance"};
    const auto with = [&](std::vector<std::string> more, const std::string& output) {
        more.insert(more.end(), view.begin(), view.end());
        more.insert(more.end(), {"-o", path(output)});
        const auto result = run(more);
        EXPECT_EQ(result.status, 0) << result.err;
        return picture(path(output));
    };
    const PictureFile twice = with({path("whole.vdb"), path("whole.vdb"), "--extinction", "0.4"}, "two.exr");
    const PictureFile once = with({path("whole.vdb"), "--extinction", "0.8"}, "one.exr");
    for (const auto& channel : {"R", "A", "transmittance.B"}) EXPECT_LT(difference(once, twice, channel), 2e-3);
}

TEST_F(Render, BackgroundIsDrawnIfGivenElseAlphaIsKept)
{
    write_lump(path("lump.vdb"));
    const PictureFile clear = rendered(path("lump.vdb"), "a.exr"),
                      red = rendered(path("lump.vdb"), "b.exr", {"--background", "0.5,0,0"});
    EXPECT_EQ(clear.at(1, 1, "R"), 0);
    EXPECT_EQ(clear.at(1, 1, "A"), 0);
    EXPECT_EQ(red.at(1, 1, "R"), 0.5f);
    EXPECT_EQ(red.at(1, 1, "A"), 1);
    for (int i = 0; i < 32; ++i)
        EXPECT_NEAR(red.at(i, 16, "R"), clear.at(i, 16, "R") + (1 - clear.at(i, 16, "A")) * 0.5f, 1e-3);
    const PictureFile sky = rendered(path("lump.vdb"), "c.exr",
                                     {"--sky-zenith", "0,0,1", "--sky-horizon", "0.25", "--direction", "0,1,0.001"});
    EXPECT_NEAR(sky.at(1, 1, "B"), 1, 0.2);
    EXPECT_LT(sky.at(1, 1, "R"), 0.1);
}

TEST_F(Render, ACameraWithinSeesCloudAndOneTurnedAwaySeesNone)
{
    write_lump(path("lump.vdb"));
    const PictureFile inside =
        rendered(path("lump.vdb"), "a.exr", {"--camera", "0.1,0,0", "--look-at", "5,1,0", "--extinction", "3"});
    for (int k = 0; k < 32; k += 5) EXPECT_GT(inside.at(k, 31 - k, "A"), 0.8);
    const PictureFile away = rendered(path("lump.vdb"), "b.exr", {"--camera", "9,0,0", "--look-at", "20,0,0"});
    for (int k = 0; k < 32; k += 5) EXPECT_EQ(away.at(k, k, "A"), 0);
}

TEST_F(Render, ALightGridOfAnotherExtinctionIsRecomputedWithAWarning)
{
    write_lump(path("lump.vdb"));
    const auto lit = test::run(
        {program("illuminate"), path("lump.vdb"), "--sun", "1,1,0", "--extinction", "1", "-o", path("lit.vdb")});
    EXPECT_EQ(lit.status, 0) << lit.err;
    const auto again = run({path("lit.vdb"), "--extinction", "2", "--resolution", "32", "-o", path("a.exr")});
    EXPECT_EQ(again.status, 0);
    EXPECT_NE(again.err.find("was computed with extinction 1, now 2"), std::string::npos) << again.err;
    const PictureFile fresh = rendered(path("lump.vdb"), "b.exr", {"--sun", "1,1,0", "--extinction", "2"});
    EXPECT_LT(difference(fresh, picture(path("a.exr")), "R"), 1e-3);
}

TEST_F(Render, APrintedConfigurationGivesThePictureAgain)
{
    write_lump(path("lump.vdb"));
    const std::vector<std::string> options{
        "--samples", "2",     "--filter", "gaussian",         "--fov", "25",  "--aov", "Z,transmittance", "--sun",
        "0,1,0",     "--sun", "1,0,0",    "--sun-irradiance", "1,2,3", "--g", "0.5"};
    auto print = options;
    print.insert(print.end(), {path("lump.vdb"), "-o", path("a.exr"), "--resolution", "32", "--print-config"});
    test::write_text(path("a.toml"), run(print).out);
    const PictureFile direct = rendered(path("lump.vdb"), "a.exr", options);
    const auto again = run({"--config", path("a.toml"), path("lump.vdb"), "-o", path("b.exr")});
    EXPECT_EQ(again.status, 0) << again.err;
    const PictureFile other = picture(path("b.exr"));
    for (const auto& channel : {"R", "B", "transmittance.R"}) EXPECT_EQ(difference(direct, other, channel), 0);
}

TEST_F(Render, AnEmptyDensityShowsTheBackgroundAndANote)
{
    write_lump(path("empty.vdb"), scaled(1), [](const Coord&) { return false; });
    const auto result = run({path("empty.vdb"), "-o", path("a.exr"), "--resolution", "16", "--background", "0.25"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NE(result.err.find("empty"), std::string::npos);
    EXPECT_EQ(picture(path("a.exr")).at(8, 8, "R"), 0.25f);
}

TEST_F(Render, RefusesInOneSentenceWithItsStatus)
{
    write_lump(path("lump.vdb"));
    const std::string in = path("lump.vdb"), out = path("a.exr");
    expect_refused(2, ".png", {in, "-o", path("a.jpg")});
    expect_refused(2, "--png", {in, "-o", out, "--png", path("b.exr")});
    expect_refused(2, "crop", {in, "-o", out, "--crop", "0,0,600,10"});
    expect_refused(2, "crop", {in, "-o", out, "--crop", "9,0,3,10"});
    expect_refused(2, "resolution", {in, "-o", out, "--resolution", "12x"});
    expect_refused(2, "background", {in, "-o", out, "--background", "blue"});
    expect_refused(2, "layer", {in, "-o", out, "--aov", "albedo"});
    expect_refused(2, "--g", {in, "-o", out, "--phase", "rayleigh", "--g", "0.5"});
    expect_refused(2, "--g", {in, "-o", out, "--g", "1.5"});
    expect_refused(2, "--sun-irradiance", {in, "-o", out, "--sun-irradiance", "1,1,1"});
    expect_refused(2, "direction", {in, "-o", out, "--camera", "0,0,9", "--look-at", "0,0,0", "--direction", "1,0,0"});
    expect_refused(1, "none.vdb", {path("none.vdb"), "-o", out});
    expect_refused(1, "no/a.exr", {in, "-o", path("no/a.exr")});
    EXPECT_EQ(scratch.list(), std::vector<std::string>{"lump.vdb"});
}

TEST_F(Render, RefusesOptionsThatWouldHaveNoEffect)
{
    write_lump(path("lump.vdb"));
    const std::vector<std::vector<std::string>> lines{{"--step", "0.1"},
                                                      {"--tolerance", "1e-3"},
                                                      {"--integrator", "steps", "--parts", "2"},
                                                      {"--ortho-width", "3"},
                                                      {"--projection", "orthographic", "--fov", "20"},
                                                      {"--filter", "gaussian"},
                                                      {"--shadow-rays", "--fidelity", "exact"},
                                                      {"--background", "1,1,1", "--sky-zenith", "0,0,1"},
                                                      {"--background", "none", "--sky-haze", "2"}};
    for (auto line : lines) {
        line.insert(line.end(), {path("lump.vdb"), "-o", path("a.exr"), "--resolution", "8"});
        expect_refused(2, "no effect", line);
    }
}

TEST_F(Render, ThreeIntegratorsAgreeTo2e3)
{
    write_lump(path("lump.vdb"));
    const std::vector<std::string> light{"--sun", "1,1,1", "--extinction", "1"};
    const auto by = [&](const std::string& name, std::vector<std::string> more) {
        more.insert(more.end(), light.begin(), light.end());
        more.insert(more.end(), {"--integrator", name});
        return rendered(path("lump.vdb"), name + ".exr", more);
    };
    const PictureFile cells = by("cells", {}), romberg = by("romberg", {}), steps = by("steps", {"--step", "0.05"});
    EXPECT_LT(difference(cells, romberg, "R"),
              2e-3);  // half floats, and what cells makes of the light within a voxel
    EXPECT_LT(difference(cells, steps, "R"), 2e-3);
    const PictureFile coarse = by("steps", {"--step", "4"});
    EXPECT_GT(difference(cells, coarse, "R"), 1e-2);  // the step is heeded
}

TEST_F(Render, AFullDiskIsStatusOne)
{
    write_lump(path("lump.vdb"));
    expect_refused(1, "/dev/full", {path("lump.vdb"), "-o", "/dev/full", "--resolution", "16"});
    test::RunOptions full;
    full.stdout_to = "/dev/full";
    EXPECT_EQ(test::run({program("render"), path("lump.vdb"), "-o", "-", "--resolution", "16"}, full).status, 1);
}

TEST_F(Render, DryRunEstimatesAndWritesNothing)
{
    write_lump(path("lump.vdb"));
    const auto result = run({path("lump.vdb"), "-o", path("a.exr"), "--dry-run"});
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.err.find("512x512"), std::string::npos) << result.err;
    EXPECT_EQ(scratch.list(), std::vector<std::string>{"lump.vdb"});
}

}  // namespace
}  // namespace vdbcloud
