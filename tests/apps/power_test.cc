// p1solve --flux-map and --heating as a user runs them: files against the report, refusals, threads.
#include "apps/stages.h"
#include "support/picture_file.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"

#include <nlohmann/json.hpp>

#include <cmath>

namespace vdbcloud::test {
namespace {

class Power : public Stages {
protected:
    nlohmann::json solve(const std::string& input, const Words& options)
    {
        stage("p1solve", input, "lit.vdb", with(options, {"--json", scratch / "lit.json"}));
        return nlohmann::json::parse(read_text(scratch / "lit.json"), nullptr, false);
    }
    RunResult refused(const std::string& input, const Words& options)
    {
        return run(with({program("p1solve"), input, "-o", scratch / "no.vdb"}, options));
    }
    std::string cloud()
    {
        return stage("fractalgen", "", "cloud.vdb", {"--size", "20", "--extinction", "15", "--albedo", "0.99,0.9,0.9"});
    }
    Words map() const { return {"--flux-map", scratch / "map.exr"}; }
};

TEST_F(Power, TheMeanOfTheMapTimesItsAreaIsThePowerOfTheReport)
{
    for (const Words& sweeps : {Words{}, Words{"--iterations", "2", "--directions", "16"}}) {
        const auto report = solve(
            cloud(), with({"--sun", "1,1,0.3", "--sun-irradiance", "1,2,4", "--sky", "0.1"}, with(map(), sweeps)));
        const PictureFile picture = test::picture(scratch / "map.exr");
        const double area = picture.number("vdbcloud:column_area");
        EXPECT_NEAR(area, 0.01, 1e-6) << "20 voxels of a cloud of two units";
        EXPECT_EQ(picture.channels.size(), 15u);
        const std::vector<std::pair<std::string, std::string>> layers{{"diffuse_up", "out_of_top"},
                                                                      {"diffuse_down", "out_of_base"},
                                                                      {"direct_top", "direct_at_top"},
                                                                      {"direct_base", "direct_at_base"},
                                                                      {"absorbed", "absorbed"}};
        for (const auto& [layer, key] : layers)
            for (const auto& [channel, letter] : {std::pair("R", "r"), {"G", "g"}, {"B", "b"}}) {
                double sum = 0;
                for (int j = 0; j < picture.height; ++j)
                    for (int i = 0; i < picture.width; ++i) sum += double(picture.at(i, j, layer + "." + channel));
                const double told = report["channels"][letter]["budget"][key];
                EXPECT_NEAR(sum * area / told, 1, 2e-5) << layer << ' ' << channel;
                EXPECT_GT(told, 0.001) << layer;
            }
        for (const char* key : {"vdbcloud:unit", "vdbcloud:first_column", "vdbcloud:column_step_x",
                                "vdbcloud:column_step_y", "history", "creator"})
            EXPECT_NE(picture.text(key), "") << key;
        EXPECT_NEAR(std::stod(picture.text("vdbcloud:column_step_x")), 0.1, 1e-9);
        EXPECT_EQ(picture.text("vdbcloud:column_step_y").substr(0, 6), "0,0,0.");
        const auto& budget = report["channels"]["g"]["budget"];
        EXPECT_NEAR(double(budget["out_of_top"]) + double(budget["out_of_base"]) + double(budget["out_of_sides"]),
                    double(budget["reflected"]) + double(budget["transmitted_diffuse"]), 1e-9);
        EXPECT_NEAR(double(budget["reflected"]) + double(budget["transmitted_diffuse"]) + double(budget["absorbed"]) +
                        double(budget["entered_again"]),
                    double(budget["beam_lost_in_medium"]) + double(budget["sky_into_box"]), 1e-5);
    }
}

TEST_F(Power, EqualRunsWriteEqualMaps)
{
    const std::string input = cloud();
    const auto bytes = [&](const char* threads) {
        solve(input, with({"--sun", "1,1,0.3", "--heating", "--threads", threads}, map()));
        return read_text(scratch / "map.exr") + read_text(scratch / "lit.vdb");
    };
    const std::string one = bytes("1");
    EXPECT_GT(one.size(), 10000u);
    EXPECT_TRUE(one == bytes("2")) << "threads";
}

TEST_F(Power, HeatingIsWrittenOnRequestAndDoesNotOutliveItsSolve)
{
    const std::string input = cloud();
    const auto report = solve(input, {"--sun", "1,1,0.3", "--heating"});
    double sum[3] = {};
    const GridFile file = read_grid_file(scratch / "lit.vdb");
    const auto heating = openvdb::gridPtrCast<Vec3SGrid>(find_grid(file, "heating"));
    ASSERT_TRUE(heating) << "channels of two albedos";
    for (auto v = heating->cbeginValueOn(); v; ++v)
        for (int c = 0; c < 3; ++c) sum[c] += double((*v)[c]) * 0.001;
    for (const auto& [c, letter] : {std::pair(0, "r"), {1, "g"}, {2, "b"}})
        EXPECT_NEAR(sum[c] / double(report["channels"][letter]["budget"]["absorbed"]), 1, 1e-5);
    EXPECT_GT(sum[1], 3 * sum[0]) << "albedo .9 against .99";
    stage("p1solve", scratch / "lit.vdb", "again.vdb", {"--sun", "1,1,0.3", "--albedo", "0.5"});
    EXPECT_FALSE(find_grid(read_grid_file(scratch / "again.vdb"), "heating"));
    stage("p1solve", input, "grey.vdb", {"--sun", "1,1,0.3", "--albedo", "0.5", "--heating", "--iterations", "1"});
    EXPECT_EQ(find_grid(read_grid_file(scratch / "grey.vdb"), "heating")->valueType(), "float");
}

TEST_F(Power, WhatCannotBeMappedIsRefused)
{
    const std::string input = cloud();
    struct Refusal {
        Words options;
        int status;
        std::string says;
    };
    write_text(scratch / "old.exr", "old");
    for (const Refusal& of : {Refusal{{"--flux-map", scratch / "map.png"}, 2, "ends in .exr"},
                              {{"--flux-map", scratch / "map"}, 2, "ends in .exr"},
                              {{"--flux-map", scratch / "none/map.exr"}, 1, "there is no folder"},
                              {{"--flux-map", scratch / "old.exr", "--no-clobber"}, 1, "--no-clobber"},
                              {{"--albedo", "1", "--heating"}, 2, "--heating"},
                              {{"--directions", "64"}, 2, "--flux-map"}}) {
        const RunResult r = refused(input, with({"--sun", "0,1,0"}, of.options));
        EXPECT_EQ(r.status, of.status) << r.err;
        EXPECT_NE(r.err.find(of.says), std::string::npos) << r.err;
        EXPECT_EQ(read_text(scratch / "no.vdb"), "");
    }
    EXPECT_EQ(read_text(scratch / "old.exr"), "old");
    const RunResult both = run({program("p1solve"), input, "--sun", "0,1,0", "-o", "-", "--flux-map", "-"});
    EXPECT_EQ(both.status, 2);
    EXPECT_NE(both.err.find("--flux-map -"), std::string::npos) << both.err;
    // A layer that repeats upwards has no top.
    auto grid = openvdb::FloatGrid::create();
    grid->setName("density");
    grid->denseFill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(7)), 1.0f);
    write_grid_file(scratch / "layer.vdb", file_of({grid}));
    const RunResult endless = refused(scratch / "layer.vdb", with({"--sun", "1,0,0", "--periodic", "yz"}, map()));
    EXPECT_EQ(endless.status, 1);
    EXPECT_NE(endless.err.find("a map by column along y"), std::string::npos) << endless.err;
    EXPECT_EQ(read_text(scratch / "map.exr"), "");
}

TEST_F(Power, AMapGoesToStandardOutput)
{
    RunOptions there;
    there.folder = scratch.path();
    const std::string command = "p1solve -q '" + cloud() + "' --sun 0,1,0 -o lit.vdb --flux-map - > piped.exr";
    EXPECT_EQ(shell(command, there).status, 0);
    EXPECT_EQ(test::picture(scratch / "piped.exr").channels.size(), 15u);
}

}  // namespace
}  // namespace vdbcloud::test
