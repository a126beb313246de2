// Skies and suns of a published atmosphere, from illuminate to the picture.
#include "in_folder.h"
#include "support/picture_file.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/optics/collided_light.h"
#include "vdbcloud/scene/atmosphere.h"
#include "vdbcloud/scene/colour.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud::test {
namespace {

/// A folder with a cloud, and lit.vdb by a sun of the atmosphere 30 degrees high.
class SkyProgram : public InFolder<SkyProgram> {
public:
    static constexpr const char* made =
        "fractalgen -q --size 16 -o cloud.vdb && illuminate -q cloud.vdb --extinction 6 --albedo 0.95 --g 0.5 "
        "--sun 3,2,0 --sun-irradiance 8,4,2 --sun-colour atmosphere --turbidity 4 -o lit.vdb";

protected:
    static Vec3d mean(const std::string& file)
    {
        const PictureFile p = picture(*folder_ / file);
        Vec3d sum(0);
        for (int j = 0; j < p.height; ++j)
            for (int i = 0; i < p.width; ++i) sum += Vec3d(p.at(i, j, "R"), p.at(i, j, "G"), p.at(i, j, "B"));
        return sum / (p.width * p.height);
    }
    static void expect_refused(const std::string& command, const std::string& piece)
    {
        const RunResult r = in_folder(command);
        EXPECT_EQ(r.status, 2) << command;
        EXPECT_NE(r.err.find(piece), std::string::npos) << r.err;
    }
};

TEST_F(SkyProgram, SunHasTheIrradianceThatTheAtmosphereLetsThrough)
{
    const auto lights = lights_of(read_grid_file(*folder_ / "lit.vdb"));
    ASSERT_EQ(lights.size(), 1u);
    const double height = std::atan2(2, 3) * 180 / M_PI;
    const Vec3d expected = Vec3d(8, 4, 2) * sunlight(height, 4) / luminance(sunlight_above_atmosphere());
    EXPECT_LT((lights[0].strength() - expected).length(), 1e-9);
    // Over z the same sun stands on the horizon.
    expect_done("illuminate -q cloud.vdb --extinction 20 --sun 3,2,0.01 --up z --sun-colour atmosphere -o z.vdb");
    EXPECT_LT(lights_of(read_grid_file(*folder_ / "z.vdb"))[0].strength()[2], 1e-3);
    expect_refused("illuminate cloud.vdb --extinction 1 --sun 1,-0.1,0 --sun-colour atmosphere -o no.vdb",
                   "--sun 1,-0.1,0 is below the horizon");
}

TEST_F(SkyProgram, SkyThatLightsTheMediumIsTheOneBehindIt)
{
    expect_done("p1solve -q lit.vdb --sky preetham --turbidity 4 -o solved.vdb");
    const GridFile file = read_grid_file(*folder_ / "solved.vdb");
    const auto sky = read_sky(*fluence_grid(file));
    ASSERT_TRUE(sky);
    const Sky expected = preetham_sky(Vec3d(3, 2, 0), lights_of(file)[0].strength(), 4, Vec3d(0, 1, 0));
    for (const Vec3d& w : {Vec3d(0, 1, 0), Vec3d(0.8, 0.6, 0), Vec3d(0, -0.6, 0.8)})
        EXPECT_LT((sky->radiance(w) - expected.radiance(w)).length(), 1e-9);
    // One pixel far from the cloud.
    expect_done("render -q solved.vdb --background sky --camera 0,0,50 --direction 0.01,0.5,-1 --fov 1 --resolution 1 "
                "--aov none -o behind.exr");
    EXPECT_LT((mean("behind.exr") - expected.radiance(Vec3d(0.01, 0.5, -1).unit())).length(), 2e-3);
}

TEST_F(SkyProgram, SweepsAndLightPathsAgreeUnderIt)
{
    expect_done(
        "p1solve -q lit.vdb --sky preetham --turbidity 4 --iterations 6 --directions 128 --degree 3 -o swept.vdb");
    const std::string view = " swept.vdb --resolution 12 --aov none ";
    expect_done("render -q" + view + "--samples 16 -o swept.exr");
    expect_done("render -q" + view + "--integrator path --spp 400 -o paths.exr");
    const Vec3d swept = mean("swept.exr"), paths = mean("paths.exr");
    // Sweeps on a cloud of 16 voxels across err by 2.2 to 2.7 % here; the paths have noise of a part of a per cent.
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(swept[c] / paths[c], 1, 0.04) << c;
    // The sky's share is large: without it the picture is another.
    expect_done("render -q lit.vdb --integrator path --spp 100 --resolution 12 --aov none -o sun.exr");
    EXPECT_LT(mean("sun.exr")[2], 0.6 * paths[2]);
    // Paths find the sky by options, too.
    expect_done("render -q lit.vdb --integrator path --spp 400 --resolution 12 --aov none --sky preetham --turbidity 4 "
                "--background none -o asked.exr");
    EXPECT_LT((mean("asked.exr") - paths).length(), 0.03 * paths.length());
}

TEST_F(SkyProgram, RefusesWhatHasNoEffect)
{
    expect_refused("p1solve lit.vdb --sky preetham --sky-zenith 1 -o no.vdb", "--sky-zenith");
    expect_refused("p1solve lit.vdb --sky day --turbidity 3 -o no.vdb", "--turbidity");
    expect_refused("p1solve lit.vdb --sky 1 --turbidity 1.5 --sun-colour atmosphere -o no.vdb", "--turbidity");
    expect_refused("p1solve lit.vdb --sky preetham --sun 0,-1,0 -o no.vdb", "expected a sun above the horizon");
    expect_refused("p1solve cloud.vdb --extinction 1 --lamp 0,9,0 --sky preetham -o no.vdb", "without a sun");
}

/// A folder with a cloud, and pictures of all directions: sky.hdr has a sun, studio.hdr a wide panel.
class Environments : public InFolder<Environments> {
public:
    static constexpr const char* made = "fractalgen -q --size 16 -o cloud.vdb";

protected:
    static constexpr int width = 128, height = 64;
    static constexpr const char* medium = "--extinction 6 --albedo 0.95 --g 0.5 ";

    /// Radiance's .hdr, flat: `exponent` of 2 of each pixel by row and column, and half of it in red.
    static void paint(const std::string& name, const std::function<int(int, int)>& exponent)
    {
        std::string all = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 64 +X 128\n";
        for (int row = 0; row < height; ++row)
            for (int column = 0; column < width; ++column)
                all += {char(64), char(128), char(128), char(129 + exponent(row, column))};
        write_text(*folder_ / name, all);
    }
    void SetUp() override
    {
        paint("sky.hdr", [](int row, int column) { return row == 20 && column == 30 ? 13 : row < 32 ? -1 : -3; });
        paint("studio.hdr",
              [](int row, int column) { return row > 20 && row < 40 && column > 20 && column < 40 ? 6 : -4; });
    }
};

TEST_F(Environments, SunsOfThePictureAreLightsAndTheRestIsTheSkyBehind)
{
    expect_done(std::string("illuminate -q cloud.vdb ") + medium + "--environment sky.hdr -o lit.vdb");
    const auto lights = lights_of(read_grid_file(*folder_ / "lit.vdb"));
    ASSERT_EQ(lights.size(), 1u);
    // A texel of 2^13 and its solid angle; in red one half. 20 times the mean stays with the sky.
    const double size = 2 * M_PI / width * (std::sin(M_PI * (0.5 - 20.0 / 64)) - std::sin(M_PI * (0.5 - 21.0 / 64)));
    EXPECT_NEAR(lights[0].strength()[1] / (8192 * size), 1, 0.02);
    EXPECT_NEAR(lights[0].strength()[0] / lights[0].strength()[1], 0.5, 1e-6);
    const double up = M_PI * (0.5 - 20.5 / height), turn = 2 * M_PI * (0.5 - 30.5 / width);
    const Vec3d towards(std::cos(up) * std::sin(turn), std::sin(up), std::cos(up) * std::cos(turn));
    EXPECT_LT((lights[0].place() - towards).length(), 1e-5);
    // The file tells render all that it needs; asking again changes nothing.
    expect_done("p1solve -q lit.vdb --environment sky.hdr --iterations 2 -o solved.vdb");
    expect_done("render -q solved.vdb --resolution 24 --background sky -o told.exr");
    expect_done("render -q solved.vdb --resolution 24 --environment sky.hdr --background sky -o asked.exr");
    expect_done("idiff -q -fail 0 -warn 0 told.exr asked.exr");
    const PictureFile told = picture(*folder_ / "told.exr");
    EXPECT_NEAR(told.at(0, 0, "G"), 0.5, 0.4) << "the sky, above or below its horizon";
    // Another sky in its place takes the picture out.
    expect_done("p1solve -q solved.vdb --sky 1 -o other.vdb");
    EXPECT_FALSE(find_grid(read_grid_file(*folder_ / "other.vdb"), schema::environment));
}

TEST_F(Environments, PicturesAgreeWithLightPaths)
{
    // Without a sun illuminate adds nothing, and says so.
    const RunResult lit =
        in_folder(std::string("illuminate cloud.vdb ") + medium + "--environment studio.hdr -o lit.vdb");
    EXPECT_EQ(lit.status, 0) << lit.err;
    EXPECT_NE(lit.err.find("the environment has no sun"), std::string::npos) << lit.err;
    EXPECT_TRUE(lights_of(read_grid_file(*folder_ / "lit.vdb")).empty());
    for (const char* name : {"studio.hdr", "sky.hdr"}) {
        const std::string sky = std::string(" --environment ") + name + " --environment-turn 40 ";
        expect_done("p1solve -q cloud.vdb " + std::string(medium) + sky +
                    "--iterations 5 --directions 128 -o solved.vdb");
        const std::string frame = "--resolution 12 --background none ";
        expect_done("render -q solved.vdb --samples 4 " + frame + "-o light.exr");
        expect_done("render -q cloud.vdb " + std::string(medium) + sky + "--integrator path --spp 2048 " + frame +
                    "-o paths.exr");
        const PictureFile light = picture(*folder_ / "light.exr"), paths = picture(*folder_ / "paths.exr");
        double of_light = 0, of_paths = 0;
        for (int j = 0; j < 12; ++j)
            for (int i = 0; i < 12; ++i) {
                of_light += light.at(i, j, "G");
                of_paths += paths.at(i, j, "G");
            }
        // Light scattered by its first two moments, and 16 voxels: within 5 %; noise of the paths 0.5 %.
        EXPECT_NEAR(of_light / of_paths, 1, 0.05) << name;
    }
}

TEST_F(Environments, RefuseWhatIsNoPictureOfAllDirections)
{
    const auto refused = [](const std::string& options, int status, const std::string& piece) {
        const RunResult r = in_folder("p1solve -q cloud.vdb --extinction 1 " + options + " -o no.vdb");
        EXPECT_EQ(r.status, status) << options << r.err;
        EXPECT_NE(r.err.find(piece), std::string::npos) << r.err;
        EXPECT_EQ(in_folder("test -e no.vdb").status, 1);
    };
    refused("--environment missing.exr", 1, "missing.exr");
    refused("--environment cloud.vdb", 1, "cloud.vdb");
    write_text(*folder_ / "square.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + std::string(16, '\x40'));
    refused("--environment square.hdr", 1, "square.hdr: a panorama of 2 x 2 pixels: expected");
    refused("--environment sky.hdr --sky day --sun 0,1,0", 2, "--sky");
    refused("--environment sky.hdr --sky-zenith 1", 2, "--sky-zenith");
    refused("--environment-turn 4", 2, "--environment-turn");
    refused("--environment sky.hdr --series 2 --albedo 0.9", 2, "beside --environment");
}

}  // namespace
}  // namespace vdbcloud::test
