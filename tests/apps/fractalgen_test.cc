// fractalgen as a user meets it: where the cloud is, what each option does, what passes through.
#include "support/run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/medium.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>

namespace vdbcloud {
namespace {

using namespace test;
using Words = std::vector<std::string>;

class Fractalgen : public testing::Test {
protected:
    RunResult run_it(Words words)
    {
        words.insert(words.begin(), {program("fractalgen"), "-q"});
        return run(words);
    }

    GridFile make(const Words& options, const std::string& size = "32")
    {
        const std::string path = folder_ / "made.vdb";
        Words words{"-o", path, "--size", size};
        words.insert(words.end(), options.begin(), options.end());
        const auto result = run_it(words);
        EXPECT_EQ(result.status, 0) << result.err;
        return read_grid_file(path);
    }

    FloatGridPtr density(const Words& options, const std::string& size = "32")
    {
        const auto file = make(options, size);
        return openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"));
    }

    Scratch folder_;
};

TEST_F(Fractalgen, BaseIsAtHeightZeroWithVoxelCentresAtHalfVoxels)
{
    const auto grid = density({}, "64");
    EXPECT_TRUE(grid->indexToWorld(openvdb::Coord(0, 0, 0)).eq(Vec3d(-1, 0, -1) + Vec3d(1 / 64.0), 1e-12));
    EXPECT_TRUE(grid->voxelSize().eq(Vec3d(1 / 32.0), 1e-12));
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
    openvdb::CoordBBox box;
    ASSERT_TRUE(grid->tree().evalActiveVoxelBoundingBox(box));
    EXPECT_EQ(box.min()[1], 0) << "the base is the bottom of the bounds";
    EXPECT_LT(box.max()[1], 40);
    EXPECT_GT(box.max()[1], 20);
    EXPECT_GT(box.dim()[0], 35);
}

TEST_F(Fractalgen, VoxelsAreCubesForOneSizeAndAsGivenForThree)
{
    const auto cubes = density({"--bounds", "10,20,30,13,21,32", "--envelope", "box"}, "30");
    EXPECT_TRUE(cubes->voxelSize().eq(Vec3d(0.1), 1e-12));
    EXPECT_TRUE(cubes->indexToWorld(openvdb::Coord(0, 0, 0)).eq(Vec3d(10.05, 20.05, 30.05), 1e-9));
    openvdb::CoordBBox box;
    ASSERT_TRUE(cubes->tree().evalActiveVoxelBoundingBox(box));
    EXPECT_GE(box.min().x(), 0);
    EXPECT_LE(box.max().x(), 29);
    EXPECT_LE(box.max().y(), 9);
    EXPECT_LE(box.max().z(), 19);
    const auto uneven = density({"--bounds", "0,0,0,4,4,4", "--envelope", "sphere"}, "20,11,7");
    EXPECT_TRUE(uneven->voxelSize().eq(Vec3d(0.2, 4 / 11.0, 4 / 7.0), 1e-9));
}

TEST_F(Fractalgen, BaseIsLowestForBothUpAxes)
{
    const auto file = make({"--up", "z"}, "48");
    EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Z");
    const auto grid = openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"));
    EXPECT_TRUE(grid->indexToWorld(openvdb::Coord(0, 0, 0)).eq(Vec3d(-1, -1, 0) + Vec3d(1 / 48.0), 1e-12));
    std::map<int, int> layers;  // cloudy voxels a layer
    grid->tree().voxelizeActiveTiles();
    for (auto it = grid->cbeginValueOn(); it; ++it) layers[it.getCoord().z()] += *it > 0.5f;
    EXPECT_GT(layers[1], 300) << "a broad base";
    EXPECT_LT(layers.rbegin()->second, layers[1] / 4) << "below a narrow top";
}

TEST_F(Fractalgen, EveryOptionOfTheShapeChangesIt)
{
    std::map<std::string, std::string> seen{{grid_digest(*density({})), "the default"}};
    for (const Words& options : std::vector<Words>{{"--seed", "2"},
                                                   {"--beta", "3"},
                                                   {"--outer", "8"},
                                                   {"--low-cut", "5"},
                                                   {"--high-cut", "8"},
                                                   {"--stretch", "1,3,1"},
                                                   {"--envelope", "sphere"},
                                                   {"--envelope", "ellipsoid"},
                                                   {"--envelope", "slab"},
                                                   {"--envelope", "box"},
                                                   {"--towers", "3"},
                                                   {"--height", "0.4"},
                                                   {"--generations", "1"},
                                                   {"--coverage", "0.5"},
                                                   {"--edge", "0.1"},
                                                   {"--roughness", "0.05"},
                                                   {"--warp", "0.05"},
                                                   {"--billow", "1"},
                                                   {"--up", "z"},
                                                   {"--bounds", "0,0,0,2,2,2"}}) {
        const auto [at, fresh] = seen.emplace(grid_digest(*density(options)), options[0] + " " + options[1]);
        EXPECT_TRUE(fresh) << options[0] << " " << options[1] << " makes the same as " << at->second;
    }
}

TEST_F(Fractalgen, DigestIsEqualOnAnyThreadsAndThroughAPipe)
{
    const auto one = grid_digest(*density({"--threads", "1", "--coverage", "0.7"}, "50"));
    EXPECT_EQ(grid_digest(*density({"--threads", "3", "--coverage", "0.7"}, "50")), one);
    const std::string piped = folder_ / "piped.vdb";
    ASSERT_EQ(shell("fractalgen -q --size 50 --coverage 0.7 -o - > '" + piped + "'").status, 0);
    const auto file = read_grid_file(piped);
    EXPECT_EQ(grid_digest(*openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"))), one);
}

TEST_F(Fractalgen, DensityHoldsTheGivenPartsOfTheMediumAlone)
{
    EXPECT_FALSE(has_meta(*density({}), schema::albedo));
    const auto some = density({"--albedo", "0.9,0.8,0.7"});
    EXPECT_FALSE(has_meta(*some, schema::sigma_t_per_density)) << "a later stage chooses it";
    EXPECT_EQ(read_medium(*some).albedo, Vec3d(0.9, 0.8, 0.7));
    const auto all = density({"--extinction", "30", "--g", "0.6"});
    EXPECT_EQ(read_medium(*all).sigma_t_per_density, Vec3d(30));
    EXPECT_EQ(read_medium(*all).phase.mean_cosine(), 0.6);
    EXPECT_EQ(get_text(*all, schema::sigma_t_origin, ""), "given");
    const auto droplets = density({"--phase", "hg-draine", "--droplet-diameter", "12"});
    EXPECT_EQ(read_medium(*droplets).phase, PhaseFunction("hg-draine", {12}));
    EXPECT_FALSE(has_meta(*droplets, "vdbcloud:g"));
}

TEST_F(Fractalgen, AMountainJoinsTheGridsOfTheInput)
{
    const std::string cloud = folder_ / "cloud.vdb";
    ASSERT_EQ(run_it({"--size", "24", "-o", cloud}).status, 0);
    const auto before = read_grid_file(cloud);
    const auto file = make({cloud, "--mountain", "--seed", "4"}, "48");
    ASSERT_EQ(file.grids.size(), 2u);
    EXPECT_EQ(grid_digest(*openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"))),
              grid_digest(*openvdb::gridPtrCast<FloatGrid>(find_grid(before, "density"))));
    const auto solid = openvdb::gridPtrCast<FloatGrid>(find_grid(file, "solid"));
    ASSERT_TRUE(solid);
    EXPECT_EQ(solid->getGridClass(), openvdb::GRID_LEVEL_SET);
    const auto history = get_text(*file.metadata, schema::history, "");
    EXPECT_EQ(std::count(history.begin(), history.end(), '\n'), 1) << history;
    std::map<std::string, std::string> seen;
    for (const Words& options : std::vector<Words>{{"--seed", "4"},
                                                   {"--relief", "0.2"},
                                                   {"--ridges", "0"},
                                                   {"--peak", "0"},
                                                   {"--band", "5"},
                                                   {"--beta", "2.5"},
                                                   {"--outer", "4"}}) {
        Words words{"--mountain"};
        words.insert(words.end(), options.begin(), options.end());
        const auto made = make(words);
        const auto digest = grid_digest(*openvdb::gridPtrCast<FloatGrid>(find_grid(made, "solid")));
        EXPECT_TRUE(seen.emplace(digest, options[0]).second) << options[0] << " makes the same as " << seen[digest];
    }
}

TEST_F(Fractalgen, EnvelopeFromFillsFogAndLevelSets)
{
    const std::string mask = folder_ / "mask.vdb";
    ASSERT_EQ(run_it({"--envelope", "sphere", "--roughness", "0", "--warp", "0", "--bounds", "4,4,4,6,6,6", "--size",
                      "40", "-o", mask})
                  .status,
              0);
    const auto filled = density({"--envelope-from", mask, "--roughness", "0", "--warp", "0", "--edge", "0"}, "60");
    double volume = 0;
    filled->tree().voxelizeActiveTiles();
    for (auto it = filled->cbeginValueOn(); it; ++it) {
        volume += *it > 0.5f;
        ASSERT_LT((filled->indexToWorld(it.getCoord()) - Vec3d(5)).length(), 1.1);
    }
    const double h = filled->voxelSize()[0];
    // Radius 1 less the mask's soft skin and that of the new edge, half a voxel of each grid.
    EXPECT_NEAR(volume * h * h * h, 4.19, 0.7);

    const std::string land = folder_ / "land.vdb";
    ASSERT_EQ(run_it({"--mountain", "--size", "32", "-o", land}).status, 0);
    const auto fog = density({"--envelope-from", land}, "40");
    EXPECT_GT(fog->activeVoxelCount(), 500u);
    EXPECT_EQ(run_it({"--envelope-from", land, "--envelope-grid", "nothing", "-o", folder_ / "x.vdb"}).status, 1);
    EXPECT_EQ(run_it({"--envelope-from", land, "--mountain", "-o", folder_ / "x.vdb"}).status, 2);
}

TEST_F(Fractalgen, ACloudFarFromZeroHasTheShapeOfOneThere)
{
    // Places as floats would be off by 64 voxels and more.
    const auto here = density({"--bounds", "0,0,0,4,4,4", "--envelope", "sphere"});
    const auto there = density({"--bounds", "1e9,-1e9,1e9,1000000004,-999999996,1000000004", "--envelope", "sphere"});
    ASSERT_GT(here->activeVoxelCount(), 1000u);
    EXPECT_EQ(here->activeVoxelCount(), there->activeVoxelCount());
    for (auto v = here->cbeginValueOn(); v; ++v) ASSERT_EQ(there->tree().getValue(v.getCoord()), *v);
    EXPECT_TRUE(there->indexToWorld(openvdb::Coord(0, 0, 0)).eq(Vec3d(1e9, -1e9, 1e9) + Vec3d(0.0625), 1e-6));
    // A mask at these places, and the same one at 0.
    const auto filled = [&](const char* bounds) {
        const std::string mask = folder_ / "mask.vdb";
        EXPECT_EQ(
            run_it({"--envelope", "sphere", "--roughness", "0", "--bounds", bounds, "--size", "24", "-o", mask}).status,
            0);
        return density({"--envelope-from", mask, "--roughness", "0"}, "20")->activeVoxelCount();
    };
    const double near = double(filled("0,0,0,4,4,4"));
    EXPECT_GT(near, 500);
    EXPECT_NEAR(double(filled("1e9,-1e9,1e9,1000000004,-999999996,1000000004")) / near, 1, 0.02) << "rounding at 1e9";
}

TEST_F(Fractalgen, RefusesImpossibleOptions)
{
    for (const Words& options : std::vector<Words>{{"--size", "0"},
                                                   {"--size", "513"},
                                                   {"--size", "8,8"},
                                                   {"--size", "8.5"},
                                                   {"--size", "nan"},
                                                   {"--bounds", "0,0,0,1,1"},
                                                   {"--bounds", "0,0,0,1,0,1"},
                                                   {"--bounds", "0,0,0,1,1,inf"},
                                                   {"--coverage", "1.1"},
                                                   {"--beta", "-1"},
                                                   {"--envelope", "teapot"},
                                                   {"--towers", "0"},
                                                   {"--edge", "-1"},
                                                   {"--extinction", "0"},
                                                   {"--g1", "0.5"},
                                                   {"--phase", "hg-draine"}}) {
        Words words{"-o", folder_ / "x.vdb"};
        words.insert(words.end(), options.begin(), options.end());
        EXPECT_EQ(run_it(words).status, 2) << options[0] << " " << options[1];
    }
    EXPECT_EQ(run_it({"--size", "16,8,16", "--mountain", "--bounds", "0,0,0,1,1,1", "-o", folder_ / "x.vdb"}).status,
              1);
    EXPECT_EQ(folder_.list(), Words{});
}

TEST_F(Fractalgen, DryRunEstimatesMemoryAndWritesNothing)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    const auto result = run_it({"--size", "512,512,512", "--dry-run", "--json", "-", "-o", folder_ / "x.vdb"});
    ASSERT_EQ(result.status, 0) << result.err;
    const auto report = nlohmann::json::parse(result.out);
    // The field of noise, which ends where blocks of the surface, a few hundredths of the box, are made.
    const double field = 512. * 512 * 528 * 4, said = report["estimate"]["memory_bytes"].get<double>();
    EXPECT_GT(said, field);
    EXPECT_LT(said, 1.4 * field);
    EXPECT_EQ(report["estimate"]["events"]["noise_point"], 512. * 512 * 512);
}

TEST_F(Fractalgen, RefusesAtOnceWhatCannotFitTheMemory)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    // The field alone needs 554 MB. Of 300 MB of address space the program itself takes a part.
    RunOptions little;
    little.memory = uint64_t(300) << 20;
    const auto start = std::chrono::steady_clock::now();
    const RunResult r =
        run({program("fractalgen"), "--size", "512,512,512", "-o", folder_ / "x.vdb", "--threads", "1"}, little);
    EXPECT_EQ(r.status, 1);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5);
    for (const char* said : {"not enough memory", "554 MB", "ulimit -v", "a smaller --size"})
        EXPECT_NE(r.err.find(said), std::string::npos) << r.err;
    EXPECT_EQ(folder_.list(), Words{});
    // Where there is room nothing is refused: a field of 74 MB.
    little.memory = uint64_t(600) << 20;
    EXPECT_EQ(
        run({program("fractalgen"), "--size", "256,256,256", "-o", folder_ / "x.vdb", "--threads", "1", "-q"}, little)
            .status,
        0);
    std::filesystem::remove(folder_ / "x.vdb");
    EXPECT_EQ(folder_.list(), Words{});
}

/// A frame of a simulation: a ball with a velocity, and a time.
TEST_F(Fractalgen, DetailComesFromAFrameAndGoesOnWithIt)
{
    const auto coarse = FloatGrid::create(0.0f);
    coarse->setName("density");
    coarse->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (int x = 0; x < 6; ++x)
        for (int y = 0; y < 6; ++y)
            for (int z = 0; z < 6; ++z) coarse->tree().setValue(openvdb::Coord(x, y, z), 0.5f);
    set_vector(*coarse, schema::sigma_t_per_density, Vec3d(3));
    const auto vel = Vec3SGrid::create(Vec3f(1, 0, 0));
    vel->setName("vel");
    vel->tree().setValue(openvdb::Coord(0, 0, 0), Vec3f(1, 0, 0));
    GridFile frame{"memory", {coarse, vel}, std::make_shared<MetaMap>()};
    set_text(*frame.metadata, schema::up_axis, "Z");
    const auto written = [&](const std::string& name, std::optional<double> time) {
        if (time)
            set_number(*frame.metadata, "cloudsim:time", *time);
        else
            frame.metadata->removeMeta("cloudsim:time");
        write_grid_file(folder_ / name, frame);
        return folder_ / name;
    };
    const auto detailed = [&](const std::string& from, Words options = {}) {
        Words words{"--detail-from", from, "-o", folder_ / "fine.vdb"};
        words.insert(words.end(), options.begin(), options.end());
        const RunResult r = run_it(words);
        EXPECT_EQ(r.status, 0) << r.err;
        return read_grid_file(folder_ / "fine.vdb");
    };
    const auto digest = [&](const GridFile& file) {
        return grid_digest(*openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density")));
    };
    const std::string at_rest = written("f0.vdb", std::nullopt), at_30 = written("f30.vdb", 30.0);
    const GridFile file = detailed(at_30);
    const auto fine = openvdb::gridPtrCast<FloatGrid>(find_grid(file, "density"));
    ASSERT_TRUE(fine);
    EXPECT_TRUE(fine->voxelSize().eq(Vec3d(0.25), 1e-12));
    EXPECT_EQ(fine->activeVoxelCount(), 6u * 6 * 6 * 64);
    EXPECT_EQ(get_vector(*fine, schema::sigma_t_per_density, Vec3d(0.0)), Vec3d(3));
    EXPECT_TRUE(find_grid(file, "vel"));
    EXPECT_EQ(get_text(*file.metadata, schema::up_axis, ""), "Z");
    // Each option counts; the time is that of the simulation unless it is given.
    const std::string plain = digest(file);
    for (const Words& options : {Words{"--seed", "2"},
                                 {"--detail-factor", "2"},
                                 {"--detail-amount", "2"},
                                 {"--detail-period", "50"},
                                 {"--detail-time", "35"}})
        EXPECT_NE(digest(detailed(at_30, options)), plain) << options[0];
    EXPECT_EQ(digest(detailed(at_rest, {"--detail-time", "30"})), plain);
    EXPECT_NE(digest(detailed(at_rest)), plain);
    const RunResult refused = run_it({"--detail-from", at_30, "--towers", "3", "-o", folder_ / "no.vdb"});
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.err.find("--detail-from"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace vdbcloud
