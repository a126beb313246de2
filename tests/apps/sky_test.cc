// Skies and suns of a published atmosphere, from illuminate to the picture.
#include "in_folder.h"
#include "picture_file.h"

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
        for (int j = 0; j < p.spec.height; ++j)
            for (int i = 0; i < p.spec.width; ++i) sum += Vec3d(p.at(i, j, "R"), p.at(i, j, "G"), p.at(i, j, "B"));
        return sum / (p.spec.width * p.spec.height);
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

}  // namespace
}  // namespace vdbcloud::test
