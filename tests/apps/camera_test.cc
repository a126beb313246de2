// The camera that render places: it stands before all matter, also before what framing takes for too thin to see.
#include "support/picture_file.h"
#include "support/run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::picture;
using test::program;
using Words = std::vector<std::string>;

/// A file of one density of the given voxels.
template<typename F>
void write_density(const std::string& path, const Vec3i& n, double h, F value)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
    grid->transform().postTranslate(Vec3d(0.5 * h));
    auto set = grid->getAccessor();
    for (int x = 0; x < n[0]; ++x)
        for (int y = 0; y < n[1]; ++y)
            for (int z = 0; z < n[2]; ++z)
                if (const double v = value(x, y, z); v > 0) set.setValueOn(Coord(x, y, z), float(v));
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    file.grids = {grid};
    write_grid_file(path, file);
}

TEST(AutomaticCamera, StandsBeforeTheFringeOfTheLargestCells)
{
    // A cube of edge 16 in 1 and 4 cells along an edge: the ramps of half a cell before and behind it make up for
    // the half cells that they take, so the depth through its middle is 1.6.
    const test::Scratch scratch;
    for (const int cells : {1, 4})
        for (const char* projection : {"orthographic", "perspective"}) {
            write_density(scratch / "cube.vdb", Vec3i(cells), 16.0 / cells, [](int, int, int) { return 1.0; });
            const auto result = test::run({program("render"),
                                           scratch / "cube.vdb",
                                           "-o",
                                           scratch / "a.exr",
                                           "--projection",
                                           projection,
                                           "--direction",
                                           "0,0,-1",
                                           "--resolution",
                                           "3",
                                           "--crop",
                                           "1,1,2,2",
                                           "--extinction",
                                           "0.1",
                                           "--sun",
                                           "0,0,1",
                                           "--aov",
                                           "transmittance",
                                           "--spp",
                                           "1",
                                           projection[0] == 'o' ? "--ortho-width" : "--fov",
                                           "0.01"});
            ASSERT_EQ(result.status, 0) << result.err;
            EXPECT_NEAR(picture(scratch / "a.exr").at(1, 1, "transmittance.G"), std::exp(-1.6), 1e-3)
                << cells << projection;
            EXPECT_EQ(result.err.find("behind the camera"), std::string::npos) << result.err;
        }
}

TEST(AutomaticCamera, StandsBeforeAVeilTooThinToFrame)
{
    // A dense ball in a veil of density 0.003 and 40 cells: beside the ball the transmittance is exp(-0.003 * 40 * 5).
    const test::Scratch scratch;
    write_density(scratch / "veil.vdb", Vec3i(40), 1, [](int x, int y, int z) {
        const Vec3d r(x - 19.5, y - 19.5, z - 19.5);
        return r.length() < 4 ? 1.0 : 0.003;
    });
    const Words common{"--direction", "0,0,-1",        "--resolution", "9", "--extinction", "5",  "--sun", "0,0,1",
                       "--aov",       "transmittance", "--spp",        "1", "--margin",     "0.3"};
    for (const Words& camera :
         {Words{"--projection", "orthographic"}, Words{"--fov", "20"}, Words{"--look-at", "20,28,38", "--fov", "5"},
          Words{"--projection", "orthographic", "--camera", "20,20,60"}}) {
        Words words{program("render"), scratch / "veil.vdb", "-o", scratch / "a.exr"};
        words.insert(words.end(), common.begin(), common.end());
        words.insert(words.end(), camera.begin(), camera.end());
        const auto result = test::run(words);
        ASSERT_EQ(result.status, 0) << result.err;
        EXPECT_NEAR(std::log(picture(scratch / "a.exr").at(4, 0, "transmittance.G")), -0.6, 0.02) << camera[1];
        EXPECT_EQ(result.err.find("behind the camera"), std::string::npos) << result.err;
    }
    Words words{program("render"), scratch / "veil.vdb", "-o",       scratch / "a.exr",
                "--projection",    "orthographic",       "--camera", "20,20,20"};
    words.insert(words.end(), common.begin(), common.end());
    const auto result = test::run(words);
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NE((result.out + result.err).find("part of the medium lies behind the camera"), std::string::npos)
        << result.err;
}

}  // namespace
}  // namespace vdbcloud
