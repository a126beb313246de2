// render --integrator path and exrmerge as a user runs them.
#include "in_folder.h"
#include "support/picture_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {
namespace {

/// A folder with a cloud, lit.vdb by one sun and sky.vdb of albedo 1 by a sky of radiance 1 alone.
class PathProgram : public InFolder<PathProgram> {
public:
    static constexpr const char* made =
        "fractalgen -q --size 16 -o cloud.vdb && illuminate -q cloud.vdb --extinction 20 --albedo 0.9 --g 0.5 "
        "--sun 0.3,1,0.2 -o lit.vdb && p1solve -q cloud.vdb --extinction 20 --albedo 1 --sky 1 -o sky.vdb && "
        "p1solve -q lit.vdb -o scattered.vdb";

protected:
    static std::string path(const std::string& options, const std::string& input = "lit.vdb")
    {
        return "render -q --integrator path --resolution 12 " + input + " " + options;
    }
    static PictureFile traced(const std::string& options, const std::string& input = "lit.vdb")
    {
        expect_done(path(options + " -o picture.exr", input));
        return picture(*folder_ / "picture.exr");
    }
    /// exrmerge refuses with status 1 and one sentence that holds `word`.
    static void expect_not_merged(const std::string& inputs, const std::string& word)
    {
        const RunResult r = in_folder("exrmerge " + inputs + " -o refused.exr");
        EXPECT_EQ(r.status, 1) << inputs;
        EXPECT_EQ(r.err.rfind("exrmerge: ", 0), 0u) << r.err;
        EXPECT_NE(r.err.find(word), std::string::npos) << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
        EXPECT_NE(in_folder("test -e refused.exr").status, 0);
    }
};

TEST_F(PathProgram, MergedPartsAreOneRun)
{
    expect_done(path("--aov all --spp 5 -o a.exr"));
    expect_done(path("--aov all --spp 20 --spp-offset 5 -o b.exr"));
    expect_done(path("--aov all --spp 7 --spp-offset 25 -o c.exr"));
    expect_done(path("--aov all --spp 32 -o whole.exr"));
    const RunResult r = expect_done("exrmerge c.exr a.exr b.exr -o merged.exr");
    EXPECT_EQ(r.err, "exrmerge: 32 samples a pixel, of indices 0-31\n");
    const PictureFile merged = picture(*folder_ / "merged.exr"), whole = picture(*folder_ / "whole.exr");
    ASSERT_EQ(merged.channels, whole.channels);
    const size_t channels = whole.channels.size();
    std::vector<double> scale(channels, 0.0);
    for (size_t k = 0; k < whole.pixels.size(); ++k)
        scale[k % channels] = std::max(scale[k % channels], std::min(1e3, std::abs(double(whole.pixels[k]))));
    for (size_t k = 0; k < whole.pixels.size(); ++k)
        EXPECT_NEAR(merged.pixels[k], whole.pixels[k], 2e-6 * scale[k % channels]) << whole.channels[k % channels];
    for (const char* channel : {"R", "direct_sun.G", "multiscatter.B", "standard_error.R", "variance.Y", "Z"})
        EXPECT_GT(scale[size_t(whole.channel(channel))], 0) << channel;
    for (const char* key : {"vdbcloud:sample_ranges", "vdbcloud:scene", "vdbcloud:seed", "vdbcloud:light_sun"})
        EXPECT_EQ(merged.text(key), whole.text(key)) << key;
    EXPECT_EQ(merged.number("vdbcloud:samples"), 32);
    EXPECT_NE(merged.text("history").find("exrmerge"), std::string::npos);
    EXPECT_NE(merged.text("history").find("illuminate"), std::string::npos);
    // In steps, and over a background drawn in.
    expect_done("exrmerge -q c.exr a.exr -o ac.exr && exrmerge -q ac.exr b.exr -o steps.exr");
    EXPECT_EQ(picture(*folder_ / "steps.exr").text("vdbcloud:sample_ranges"), "0-31");
    EXPECT_EQ(picture(*folder_ / "ac.exr").text("vdbcloud:sample_ranges"), "0-4 25-31");
    EXPECT_EQ(in_folder("idiff -q -fail 1e-5 -warn 1e-5 steps.exr merged.exr").status, 0);
    expect_done(path("--aov standard_error --background 5,1,2 --spp 6 -o a.exr"));
    expect_done(path("--aov standard_error --background 5,1,2 --spp 6 --spp-offset 6 -o b.exr"));
    expect_done(path("--aov standard_error --background 5,1,2 --spp 12 -o whole.exr"));
    expect_done("exrmerge -q a.exr b.exr -o merged.exr");
    EXPECT_EQ(in_folder("idiff -q -fail 1e-5 -warn 1e-5 whole.exr merged.exr").status, 0);
}

TEST_F(PathProgram, OtherRunsAreNotMerged)
{
    expect_done(path("--spp 2 -o first.exr"));
    const std::pair<const char*, const char*> others[] = {{"--spp 2 --spp-offset 1", "sample 1 is there twice"},
                                                          {"--spp 2 --spp-offset 9 --g 0.4", "another scene"},
                                                          {"--spp 2 --spp-offset 9 --sun 1,0,0", "another scene"},
                                                          {"--spp 2 --spp-offset 9 --direction 1,0,0", "another scene"},
                                                          {"--spp 2 --spp-offset 9 --filter gaussian", "another scene"},
                                                          {"--spp 2 --spp-offset 9 --seed 4", "--seed"},
                                                          {"--spp 2 --spp-offset 9 --aov none", "--aov"},
                                                          {"--spp 2 --spp-offset 9 --crop 0,0,6,6", "--crop"},
                                                          {"--spp 2 --spp-offset 9 --resolution 10x12", "size"}};
    for (const auto& [options, word] : others) {
        expect_done(
            "render -q --integrator path lit.vdb -o other.exr " +
            std::string(std::string(options).find("--resolution") == std::string::npos ? "--resolution 12 " : "") +
            options);
        expect_not_merged("first.exr other.exr", word);
    }
    expect_done("render -q lit.vdb --resolution 12 -o cells.exr");
    expect_not_merged("first.exr cells.exr", "expected an .exr of render --integrator path");
    expect_not_merged("first.exr lit.vdb", "lit.vdb");
    expect_not_merged("first.exr missing.exr", "missing.exr");
}

TEST_F(PathProgram, PathsEndInTheSolutionOfTheFile)
{
    const std::string file = "scattered.vdb";
    expect_done(path("--gather 3 --spp 4 --aov all -o a.exr", file));
    expect_done(path("--gather 3 --spp 4 --aov all --spp-offset 4 -o b.exr", file));
    expect_done("render -q --resolution 12 " + file + " --gather 3 --spp 8 --aov all -o whole.exr");
    expect_done("exrmerge -q b.exr a.exr -o merged.exr");
    EXPECT_EQ(in_folder("idiff -q -fail 1e-5 -warn 1e-5 whole.exr merged.exr").status, 0);
    EXPECT_EQ(picture(*folder_ / "whole.exr").text("vdbcloud:integrator"), "path");
    EXPECT_EQ(picture(*folder_ / "whole.exr").number("vdbcloud:gather"), 3);
    expect_done("render -q --resolution 12 " + file + " --gather 3 --spp 8 --aov all --threads 1 -o one.exr");
    EXPECT_EQ(in_folder("idiff -q -fail 0 -warn 0 whole.exr one.exr").status, 0);
    // Of another solution, number of vertices or without end: another scene.
    expect_done("p1solve -q lit.vdb --iterations 2 -o closed.vdb");
    for (const std::string& other : {path("--gather 2 --spp 2 --aov all --spp-offset 8 -o other.exr", file),
                                     path("--gather 3 --spp 2 --aov all --spp-offset 8 -o other.exr", "closed.vdb"),
                                     path("--spp 2 --aov all --spp-offset 8 -o other.exr", file)}) {
        expect_done(other);
        expect_not_merged("a.exr other.exr", "another scene");
    }
    const RunResult r = in_folder(path("--gather 3 -o refused.exr"));
    EXPECT_EQ(r.status, 1);
    EXPECT_EQ(
        r.err,
        "render: lit.vdb: --gather 3: expected multiple scattering in which light paths end: run p1solve first\n");
    // Beneath a sky of radiance 1 matter that absorbs nothing is not seen; P1 is exact there, and so is every path.
    const PictureFile sky = traced("--gather 2 --spp 4 --background sky", "sky.vdb");
    for (size_t k = 0; k < sky.pixels.size(); ++k)
        if (sky.channels[k % sky.channels.size()] == "G") {
            EXPECT_NEAR(sky.pixels[k], 1, 1e-4);
        }
}

TEST_F(PathProgram, ThreadsDoNotChangeTheFile)
{
    expect_done(path("--threads 1 --aov all -o a.exr"));
    expect_done(path("--threads 2 --aov all -o b.exr"));
    EXPECT_EQ(read_text(*folder_ / "a.exr"), read_text(*folder_ / "b.exr"));
    EXPECT_EQ(picture(*folder_ / "a.exr").text("vdbcloud:sample_ranges"), "0-15");  // without --samples
}

TEST_F(PathProgram, NothingComputedBeforeIsRead)
{
    // The light of lit.vdb and the collided light of scattered.vdb do not matter, the sun and the medium do.
    expect_done(path("-o a.exr"));
    expect_done(path("-o b.exr", "scattered.vdb"));
    expect_done(path("--extinction 20 --albedo 0.9 --g 0.5 --sun 0.3,1,0.2 -o c.exr", "cloud.vdb"));
    EXPECT_EQ(picture(*folder_ / "a.exr").pixels, picture(*folder_ / "b.exr").pixels);
    EXPECT_EQ(picture(*folder_ / "a.exr").pixels, picture(*folder_ / "c.exr").pixels);
    EXPECT_NE(picture(*folder_ / "a.exr").pixels, traced("--sun 1,0,0").pixels);
}

TEST_F(PathProgram, TheSkyThatLitTheInputMakesAFurnace)
{
    const PictureFile p = traced("--background sky --aov none --spp 3", "sky.vdb");
    for (size_t k = 0; k < p.pixels.size(); ++k) EXPECT_NEAR(p.pixels[k], 1, 1e-6);
    // Asked for by options it is the same sky; without one there is no light but the sun.
    const std::string white = "--sky-zenith 1 --sky-horizon 1 --sky-ground 1 --background sky --aov none --spp 3 ";
    const PictureFile q = traced(white + "--extinction 20 --albedo 1", "cloud.vdb");
    for (size_t k = 0; k < q.pixels.size(); ++k) EXPECT_NEAR(q.pixels[k], 1, 1e-6);
    // A backdrop lights nothing.
    const PictureFile dark = traced("--aov none --spp 3"), backdrop = traced("--background 1,1,1 --aov none --spp 3");
    double transparent = 0;
    for (size_t k = 0; k < dark.pixels.size(); k += 4) {
        EXPECT_NEAR(backdrop.pixels[k], dark.pixels[k] + 1 - dark.pixels[k + 3], 1e-5);
        transparent += 1 - dark.pixels[k + 3];
    }
    EXPECT_GT(transparent, 1);
}

TEST_F(PathProgram, NoiseAndTimeEndTheRunAndAreTold)
{
    const RunResult r = in_folder(path("--noise 0.2 -o a.exr").replace(0, 9, "render"));
    EXPECT_EQ(r.status, 0);
    const std::string before = " samples a pixel, noise ";
    ASSERT_NE(r.err.find(before), std::string::npos) << r.err;
    // A pass doubles the samples at most, which halves the variance.
    const double noise = std::stod(r.err.substr(r.err.find(before) + before.size()));
    EXPECT_LE(noise, 0.2);
    EXPECT_GT(noise, 0.1);
    const PictureFile p = picture(*folder_ / "a.exr");
    const int samples = int(p.number("vdbcloud:samples"));
    EXPECT_GT(samples, 16);
    EXPECT_EQ(p.text("vdbcloud:sample_ranges"), "0-" + std::to_string(samples - 1));
    // The same number of samples, asked for, is the same picture.
    EXPECT_EQ(p.pixels, traced("--spp " + std::to_string(samples)).pixels);
    const PictureFile timed = traced("--time-limit 0.2 --aov seconds,standard_error --spp-offset 7");
    EXPECT_EQ(timed.text("vdbcloud:sample_ranges").rfind("7-", 0), 0u);
    EXPECT_GE(timed.channel("seconds.Y"), 0);
    EXPECT_GE(timed.channel("standard_error.B"), 0);
}

TEST_F(PathProgram, LayersOfPathsNeedPaths)
{
    for (const char* layer : {"standard_error", "seconds"}) {
        const RunResult r = in_folder(std::string("render lit.vdb --resolution 4 -o x.exr --aov ") + layer);
        EXPECT_EQ(r.status, 2);
        EXPECT_NE(r.err.find("path"), std::string::npos) << r.err;
    }
}

TEST_F(PathProgram, MergeRefusesAPngAndWritesNothingOnADryRun)
{
    expect_done(path("--spp 2 -o a.exr"));
    EXPECT_EQ(in_folder("exrmerge a.exr -o x.png").status, 2);
    expect_done("exrmerge a.exr -o dry.exr --dry-run");
    EXPECT_NE(in_folder("test -e dry.exr").status, 0);
    expect_done("exrmerge -q a.exr -o - > piped.exr");
    EXPECT_EQ(in_folder("idiff -q a.exr piped.exr").status, 0);
    EXPECT_EQ(in_folder("exrmerge a.exr -o piped.exr --no-clobber").status, 1);
}

TEST_F(PathProgram, ExamplesOfMergeRunAsPrinted)
{
    const RunResult r = in_folder(
        "mkdir examples && cd examples && exrmerge --help | sed '1,/^Examples:/d' | grep -v '^ *#' > commands && "
        "grep -c 'exrmerge ' commands && bash -e commands && test -s both.exr");
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.out.substr(0, 2), "3\n");
    EXPECT_NE(r.out.find("\"sample_ranges\": \"0-15\""), std::string::npos) << r.out;
}

}  // namespace
}  // namespace vdbcloud::test
