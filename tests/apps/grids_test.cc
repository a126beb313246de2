// Reading and writing under the shared options: history, --keep, what the report says of grids.
#include "support/run.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

RunResult copy(Words words, const RunOptions& options = {})
{
    words.insert(words.begin(), {program("echo_tool"), "--act", "copy"});
    return run(words, options);
}

/// density 2 on 4^3 voxels of edge 0.5, and two grids that copying has no use for.
void write_sample(const std::string& path)
{
    GridFile file;
    file.metadata = std::make_shared<MetaMap>();
    for (const char* name : {"density", "temperature", "flame"}) {
        auto grid = FloatGrid::create(0.0f);
        grid->setName(name);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
        grid->fill(openvdb::CoordBBox::createCube({0, 0, 0}, 4), 2.0f);
        file.grids.push_back(grid);
    }
    write_grid_file(path, file);
}

Words names(const std::string& path)
{
    Words all;
    for (const GridBasePtr& grid : read_grid_file(path).grids) all.push_back(grid->getName());
    return all;
}

std::string history(const std::string& path) { return get_text(*read_grid_file(path).metadata, "history", ""); }

class Grids : public testing::Test {
protected:
    void SetUp() override { write_sample(scratch / "a.vdb"); }
    Scratch scratch;
};

TEST_F(Grids, KeepSelectsTheUnusedGridsOfTheInput)
{
    const auto kept = [&](const std::string& keep) {
        EXPECT_EQ(copy({scratch / "a.vdb", "-o", scratch / "b.vdb", "--keep", keep}).status, 0) << keep;
        return names(scratch / "b.vdb");
    };
    EXPECT_EQ(kept("all"), (Words{"density", "temperature", "flame"}));
    EXPECT_EQ(kept("none"), (Words{"density"}));
    EXPECT_EQ(kept("flame"), (Words{"density", "flame"}));
    EXPECT_EQ(kept("flame,temperature"), (Words{"density", "temperature", "flame"}));
    const RunResult r = copy({scratch / "a.vdb", "-o", scratch / "b.vdb", "--keep", "flames"});
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("no grid 'flames'"), std::string::npos) << r.err;
}

TEST_F(Grids, NamesInKeepMayHoldCommas)
{
    GridFile file = read_grid_file(scratch / "a.vdb");
    for (const char* name : {"a,b", "a", "b,c", "x"}) {
        file.grids.push_back(FloatGrid::create(1.0f));
        file.grids.back()->setName(name);
    }
    write_grid_file(scratch / "c.vdb", file);
    const std::vector<std::pair<std::string, Words>> table = {
        {"a,b", {"density", "a,b"}},   {"a,b,x", {"density", "a,b", "x"}}, {"x,b,c", {"density", "b,c", "x"}},
        {"a", {"density", "a"}},       {"a,x", {"density", "a", "x"}},     {"flame,a,b", {"density", "flame", "a,b"}},
        {"a,b,c", {"density", "a,b"}},
    };
    for (const auto& [keep, expected] : table) {
        const RunResult r = copy({scratch / "c.vdb", "-o", scratch / "d.vdb", "--keep", keep});
        if (keep == "a,b,c") {  // the longest name from the left is a,b: nothing is called c
            EXPECT_NE(r.err.find("no grid 'c'"), std::string::npos) << r.err;
            continue;
        }
        ASSERT_EQ(r.status, 0) << keep << r.err;
        EXPECT_EQ(names(scratch / "d.vdb"), expected) << keep;
    }
}

TEST_F(Grids, HistoryGrowsByOneLineAStageAndIsTheSameThroughPipes)
{
    const std::string a = scratch / "a.vdb", b = scratch / "b.vdb", c = scratch / "c.vdb", d = scratch / "d.vdb";
    EXPECT_EQ(copy({a, "-o", b}).status, 0);
    EXPECT_EQ(copy({b, "-o", c, "--density", "0.5"}).status, 0);
    const std::string text = history(c);
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_EQ(text.find(scratch.path()), std::string::npos) << text;
    EXPECT_NE(text.find("input=\"a.vdb\""), std::string::npos) << text;
    EXPECT_EQ(text.find("b.vdb"), std::string::npos) << text;
    EXPECT_EQ(get_text(*read_grid_file(c).metadata, "creator", "").rfind("echo_tool 0.", 0), 0u);

    const std::string tool = "echo_tool --act copy ";
    EXPECT_EQ(shell(tool + "'" + a + "' -o - | " + tool + "- -o '" + d + "' --density 0.5").status, 0);
    EXPECT_EQ(history(d), text);
}

TEST_F(Grids, ReportDescribesInputsAndOutputs)
{
    const RunResult r = copy({scratch / "a.vdb", "-o", scratch / "b.vdb", "--json", "-"});
    ASSERT_EQ(r.status, 0) << r.err;
    const auto report = nlohmann::json::parse(r.out);
    ASSERT_EQ(report["inputs"].size(), 1u);
    const auto& input = report["inputs"][0];
    EXPECT_EQ(input["path"], scratch / "a.vdb");
    EXPECT_EQ(input["bytes"], read_text(scratch / "a.vdb").size());
    EXPECT_GE(input["digest"].get<std::string>().size(), 16u);
    ASSERT_EQ(input["grids"].size(), 3u);
    const auto& grid = input["grids"][0];
    EXPECT_EQ(grid["name"], "density");
    EXPECT_EQ(grid["type"], "float");
    EXPECT_EQ(grid["active_voxels"], 64);
    EXPECT_EQ(grid["min"], 2);
    EXPECT_EQ(grid["max"], 2);
    EXPECT_EQ(grid["mean"], 2);
    EXPECT_EQ(grid["not_finite"], 0);
    EXPECT_EQ(grid["voxel_size"], (nlohmann::json{0.5, 0.5, 0.5}));
    EXPECT_EQ(grid["index_min"], (nlohmann::json{0, 0, 0}));
    EXPECT_EQ(grid["index_max"], (nlohmann::json{3, 3, 3}));
    EXPECT_EQ(report["outputs"][0]["grids"].size(), 3u);
    std::vector<std::string> phases;
    for (const auto& phase : report["phases"]) phases.push_back(phase["name"]);
    EXPECT_EQ(phases, (Words{"read", "write", "act"}));
}

TEST_F(Grids, InputsThatCannotBeReadAreStatusOneWithTheirPath)
{
    write_text(scratch / "cut.vdb", read_text(scratch / "a.vdb").substr(0, 300));
    write_text(scratch / "text.vdb", "no grids here\n");
    for (const std::string& bad : {scratch / "none.vdb", scratch.path(), scratch / "cut.vdb", scratch / "text.vdb"}) {
        const RunResult r = copy({bad, "-o", scratch / "b.vdb"});
        EXPECT_EQ(r.status, 1) << bad;
        EXPECT_EQ(r.err.rfind("echo_tool: " + bad + ": ", 0), 0u) << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    }
    EXPECT_EQ(copy({scratch / "a.vdb", "-o", scratch / "b.vdb", "--max-input", "1e-7"}).status, 1);
    EXPECT_EQ(scratch.list(), (Words{"a.vdb", "cut.vdb", "text.vdb"}));
}

TEST_F(Grids, OutputsThatCannotBeWrittenAreStatusOne)
{
    EXPECT_EQ(copy({scratch / "a.vdb", "-o", "/dev/full"}).status, 1);
    RunOptions full;
    full.stdout_to = "/dev/full";
    const RunResult r = copy({scratch / "a.vdb", "-o", "-"}, full);
    EXPECT_EQ(r.status, 1);
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}

}  // namespace
}  // namespace vdbcloud::test
