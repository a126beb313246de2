// vdbprobe as a script sees it: its table, its report and its refusals.
#include "support/grids.h"
#include "support/run.h"

#include "vdbcloud/file/io.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using namespace test;

class Vdbprobe : public testing::Test {
protected:
    void SetUp() override
    {
        const auto wind = Vec3SGrid::create(Vec3f(1, 2, 3));
        wind->setName("wind");
        const auto mask = registered<openvdb::BoolGrid>();
        mask->setName("mask");
        write_grid_file(folder_ / "a.vdb", file_of({ball("density", 4), ball("heat", 2), wind, mask}));
        write_text(folder_ / "points.txt", "# x y z\n0 0 0\n2 0 0\n");
    }

    RunResult probe(std::vector<std::string> words, const RunOptions& options = {})
    {
        words.insert(words.begin(), program("vdbprobe"));
        return run(words, options);
    }

    Scratch folder_;
};

TEST_F(Vdbprobe, PrintsALineForEachPointAndAColumnForEachNumber)
{
    // The ball falls by a quarter a voxel; half way between two voxels is the mean of both.
    const RunResult r = probe({folder_ / "a.vdb", "--grid", "density", "--grid", "wind", "--at", "0.5,0,0", "--points",
                               folder_ / "points.txt", "-q"});
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(r.out, "# x y z density wind.x wind.y wind.z\n0.5 0 0 0.875 1 2 3\n0 0 0 1 1 2 3\n2 0 0 0.5 1 2 3\n");
}

TEST_F(Vdbprobe, ReportsTheSameNumbersAsJsonInPlaceOfTheTable)
{
    RunOptions options;
    options.input = "1 0 0\n9 9 9\n";
    const RunResult r = probe({folder_ / "a.vdb", "--grid", "density", "--points", "-", "--json", "-"}, options);
    EXPECT_EQ(r.status, 0) << r.err;
    const auto report = nlohmann::json::parse(r.out);
    ASSERT_EQ(report["points"].size(), 2u);
    EXPECT_EQ(report["points"][0]["at"][0], 1);
    EXPECT_EQ(report["points"][0]["values"][0]["value"][0], 0.75);
    EXPECT_EQ(report["points"][0]["values"][0]["inside"], true);
    EXPECT_EQ(report["points"][1]["values"][0]["inside"], false);
    EXPECT_NE(r.err.find("1 values lie outside the active voxels"), std::string::npos) << r.err;
}

TEST_F(Vdbprobe, RefusesWhatItCannotRead)
{
    const std::string a = folder_ / "a.vdb";
    EXPECT_EQ(probe({a, "--grid", "density"}).status, 2) << "no point";
    EXPECT_EQ(probe({a, "--at", "0,0,0"}).status, 2) << "no grid";
    EXPECT_EQ(probe({"-", "--grid", "density", "--points", "-"}).status, 2);
    EXPECT_EQ(probe({a, "--grid", "nothing", "--at", "0,0,0"}).status, 1);
    EXPECT_EQ(probe({a, "--grid", "mask", "--at", "0,0,0"}).status, 1);
    write_text(folder_ / "two.txt", "1 2\n");
    const RunResult r = probe({a, "--grid", "density", "--points", folder_ / "two.txt"});
    EXPECT_EQ(r.status, 1);
    EXPECT_NE(r.err.find("two.txt: rows of 2 numbers: expected three, x y z"), std::string::npos) << r.err;
    RunOptions full;
    full.stdout_to = "/dev/full";
    EXPECT_EQ(probe({a, "--grid", "density", "--at", "0,0,0"}, full).status, 1);
}

TEST_F(Vdbprobe, ShowsTheBoxesOfVdbimport)
{
    write_text(folder_ / "boxes.txt", "-8 -8 -8 8 8 8 0.5 0\n-2 -2 -2 2 2 2 0.25 3\n");
    const std::string boxes = folder_ / "boxes.vdb";
    const auto import = [&](const std::string& table) {
        return run({program("vdbimport"), folder_ / table, "--boxes", "--cell", "2,1,2", "-q", "-o", boxes});
    };
    EXPECT_EQ(import("boxes.txt").status, 0);
    const RunResult r = probe({boxes, "--grid", "density", "--grid", "emission", "--at", "1,0.5,1", "--at", "5,0.5,1",
                               "--at", "9,9,9", "-q"});
    EXPECT_EQ(
        r.out,
        "# x y z density emission.x emission.y emission.z\n1 0.5 1 0.25 3 3 3\n5 0.5 1 0.5 0 0 0\n9 9 9 0 0 0 0\n");
    write_text(folder_ / "six.txt", "0 0 0 1 1 1\n");
    const RunResult refused = import("six.txt");
    EXPECT_EQ(refused.status, 1);
    EXPECT_NE(refused.err.find("rows of 6 numbers: expected x0 y0 z0 x1 y1 z1"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace vdbcloud
