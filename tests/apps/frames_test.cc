// Numbered frames in and out of the stages.
#include "apps/tools.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace vdbcloud::test {
namespace {

namespace fs = std::filesystem;

/// A folder with the frames 1, 3 and 5 of a sequence; commands run in it.
class Frames : public testing::Test {
protected:
    void SetUp() override
    {
        for (const char* seed : {"1", "3", "5"})
            make_lit_cloud(scratch / ("in.000" + std::string(seed) + ".vdb"), {"--seed", seed});
    }
    RunResult at(const std::string& line) const
    {
        RunOptions there;
        there.folder = scratch.path();
        return shell(line, there);
    }
    void refused(const std::string& line, int status, const std::string& said) const
    {
        const RunResult r = at(line);
        EXPECT_EQ(r.status, status) << line << "\n" << r.err;
        EXPECT_NE(r.err.find(said), std::string::npos) << line << "\n" << r.err;
    }
    Scratch scratch;
};

TEST_F(Frames, OfASequenceEqualSingleRuns)
{
    // Options may hold IN, which stands for the input, and OUT.ext for outputs.
    const struct {
        std::string command;
        std::vector<std::string> extensions;
    } stages[] = {{"illuminate -q IN --sun 1,1,0 -o OUT.vdb", {".vdb"}},
                  {"p1solve -q IN --albedo 0.9 --flux-map OUT.exr -o OUT.vdb", {".vdb", ".exr"}},
                  {"render -q IN --resolution 8 --png OUT.png -o OUT.exr", {".exr", ".png"}},
                  {"fractalgen -q IN --mountain --size 16 -o OUT.vdb", {".vdb"}},
                  {"fractalgen -q --envelope-from IN --size 8 -o OUT.vdb", {".vdb"}}};
    const auto with = [](std::string line, const std::string& input, const std::string& output) {
        for (const auto& [mark, text] : {std::pair{"IN", input}, {"OUT", output}})
            for (size_t k; (k = line.find(mark)) != std::string::npos;) line.replace(k, std::string(mark).size(), text);
        return line;
    };
    fs::create_directory(scratch / "one");
    fs::create_directory(scratch / "all");
    for (const auto& [command, extensions] : stages) {
        const RunResult all = at(with(command, "'in.%04d.vdb'", "'all/x.####'") + " --frames 1-5x2");
        ASSERT_EQ(all.status, 0) << command << "\n" << all.err;
        std::string before;
        for (const std::string number : {"0001", "0003", "0005"}) {
            ASSERT_EQ(at(with(command, "in." + number + ".vdb", "one/x." + number)).status, 0);
            for (const std::string& extension : extensions) {
                const std::string one = read_text(scratch / ("one/x." + number + extension));
                EXPECT_GT(one.size(), 100u);
                EXPECT_TRUE(read_text(scratch / ("all/x." + number + extension)) == one) << command << " " << number;
            }
            const std::string now = read_text(scratch / ("all/x." + number + extensions.front()));
            EXPECT_TRUE(now != before) << "frames differ";
            before = now;
        }
        EXPECT_FALSE(fs::exists(scratch / ("all/x.0002" + extensions.front())));
        EXPECT_FALSE(fs::exists(scratch / ("all/x.####" + extensions.front())));
    }
}

TEST_F(Frames, TheReportHasAPartForEachFrameAndAllFiles)
{
    ASSERT_EQ(at("render -q in.%04d.vdb --resolution 8 --frames 1,5 -o a.%d.exr --json r.json").status, 0);
    const auto report = nlohmann::json::parse(read_text(scratch / "r.json"));
    ASSERT_EQ(report["frames"].size(), 2u);
    EXPECT_EQ(report["frames"][0]["number"], 1);
    EXPECT_EQ(report["frames"][1]["number"], 5);
    EXPECT_NE(report["frames"][0]["exposure"], report["frames"][1]["exposure"]);
    ASSERT_EQ(report["inputs"].size(), 2u);
    EXPECT_EQ(report["inputs"][1]["path"], "in.0005.vdb");
    ASSERT_EQ(report["outputs"].size(), 2u);
    EXPECT_EQ(report["outputs"][0]["path"], "a.1.exr");
    EXPECT_FALSE(report.contains("exposure"));
}

TEST_F(Frames, EverySpellingOfTheNumberIsUnderstood)
{
    const std::pair<std::string, std::string> table[] = {{"a.%d.vdb", "a.5.vdb"},     {"b.%04d.vdb", "b.0005.vdb"},
                                                         {"c.%3d.vdb", "c.  5.vdb"},  {"d.####.vdb", "d.0005.vdb"},
                                                         {"e.#.vdb", "e.5.vdb"},      {"f_##_g.vdb", "f_05_g.vdb"},
                                                         {"h.$F4.vdb", "h.0005.vdb"}, {"i$F.vdb", "i5.vdb"}};
    for (const auto& [pattern, name] : table) {
        const RunResult r = at("illuminate -q 'in.####.vdb' --frames 5 -o '" + pattern + "'");
        EXPECT_EQ(r.status, 0) << r.err;
        EXPECT_TRUE(fs::exists(scratch / name)) << name;
    }
    refused("illuminate -q 'in.#####.vdb' --frames 5 -o 'j.####.vdb'", 1, "in.00005.vdb");
    const std::string cloudsim = "cloudsim -q --preset smoke --cells 4 --minutes 0.1 --every 6s -o 's/x.##.vdb'";
    EXPECT_EQ(at(cloudsim).status, 0);
    EXPECT_TRUE(fs::exists(scratch / "s/x.00.vdb") && fs::exists(scratch / "s/x.01.vdb"));
    EXPECT_FALSE(fs::exists(scratch / "s/x.##.vdb"));
    // A # or a % within words is text.
    EXPECT_EQ(at("cp in.0001.vdb 'tree #3, 50%.vdb' && illuminate -q 'tree #3, 50%.vdb' -o 'lit #3, 50%.vdb'").status,
              0);
    EXPECT_TRUE(fs::exists(scratch / "lit #3, 50%.vdb"));
    // A file of the very name is that file.
    EXPECT_EQ(at("cp in.0001.vdb 'odd.%d.vdb' && illuminate -q 'odd.%d.vdb' -o odd.vdb").status, 0);
}

TEST_F(Frames, MistakesAreRefusedWithTheWayOut)
{
    refused("illuminate in.%04d.vdb -o l.%04d.vdb", 2, "add --frames 1-5x2, the frames that are there");
    refused("illuminate no.%04d.vdb -o l.%04d.vdb", 2, "add --frames A-B");
    refused("illuminate in.0001.vdb -o 'l.####.vdb'", 2, "--output l.####.vdb has a place for the number");
    refused("illuminate in.%04d.vdb -o l.vdb --frames 1,3", 2, "expected a numbered name with --frames, as l.%04d.vdb");
    refused("illuminate in.0001.vdb -o l.%d.vdb --frames 1,3", 2, "--frames has no effect without a numbered input");
    refused("illuminate - -o l.%d.vdb --frames 1,3 < in.0001.vdb", 2, "standard input has one frame");
    refused("illuminate in.%04d.vdb -o l.%d.vdb --frames 1,2 --json r.%d.json", 2, "expected one file for all frames");
    refused("illuminate in.%04d.vdb -o l.%d.%d.vdb --frames 1", 2, "expected one number like %04d");
    refused("illuminate in.%04f.vdb -o l.vdb", 2, "expected one number like %04d");
    refused("illuminate in.0001.vdb -o l.vdb --json r.%d.json", 2, "expected a name without it");
    refused("vdbimport in.0001.vdb --cell 1,1,1 -o t.%d.vdb", 2, "expected a name without it");
    for (const char* frames : {"5-1", "1-3x0", "x", "1-", "-1", "1,,2", "1-3,2", "1x2", "1.5", "1-9999999"})
        refused("illuminate in.%04d.vdb -o l.%d.vdb --frames=" + std::string(frames), 2, "--frames");
    EXPECT_EQ(scratch.list(), (Words{"in.0001.vdb", "in.0003.vdb", "in.0005.vdb"}));
}

TEST_F(Frames, SeparateFramesAreNoMediumUnlessAskedFor)
{
    for (const char* stage :
         {"render --resolution 4 -o a.exr", "illuminate -o a.vdb", "p1solve --albedo 0.9 -o a.vdb"}) {
        refused(std::string(stage) + " in.*.vdb", 2, "the inputs look like frames of a sequence, as in.%04d.vdb");
        refused(std::string(stage) + " in.0001.vdb --one-medium", 2, "--one-medium has no effect");
        const RunResult one = at(std::string(stage) + " -q in.*.vdb --one-medium");
        EXPECT_EQ(one.status, 0) << one.err;
    }
    EXPECT_EQ(
        at("cp in.0001.vdb low.vdb && cp in.0003.vdb high.vdb && cp in.0001.vdb part1.vdb && cp in.0003.vdb "
           "part2.vdb && illuminate -q low.vdb high.vdb -o a.vdb && illuminate -q part1.vdb part2.vdb -o b.vdb && "
           "cmp a.vdb b.vdb")
            .status,
        0);
}

TEST_F(Frames, AnOptionNeedsOneOfThemThatItChanges)
{
    const auto hot = FloatGrid::create(0.0f);
    hot->fill(openvdb::CoordBBox(openvdb::Coord(-9), openvdb::Coord(9)), 1500.0f);
    hot->setName("temperature");
    GridFile file = read_grid_file(scratch / "in.0003.vdb");
    file.grids.push_back(hot);
    write_grid_file(scratch / "in.0003.vdb", file);
    const RunResult r = at("p1solve 'in.%04d.vdb' --frames 1-5x2 --fire-intensity 0.5 -o 'x.%04d.vdb'");
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.err.find("--fire-intensity has no effect on this frame: it needs an input with a grid temperature"),
              std::string::npos)
        << r.err;
    EXPECT_EQ(at("p1solve -q in.0003.vdb --fire-intensity 0.5 -o one.vdb && vdbdiff one.vdb x.0003.vdb").status, 0);
    refused("p1solve 'in.%04d.vdb' --frames 1,5 --fire-intensity 0.5 -o 'y.%04d.vdb'", 2,
            "--fire-intensity has no effect without an input with a grid temperature or flame");
    refused("p1solve in.0001.vdb --fire-intensity 0.5 -o y.vdb", 2, "--fire-intensity has no effect without");
    EXPECT_FALSE(fs::exists(scratch / "y.vdb"));
}

TEST_F(Frames, AMissingFrameEndsTheRunAndKeepsThoseBeforeIt)
{
    refused("illuminate -q in.%04d.vdb -o l.%04d.vdb --frames 1-3 --json r.json", 1, "in.0002.vdb: cannot read");
    EXPECT_TRUE(fs::exists(scratch / "l.0001.vdb"));
    EXPECT_FALSE(fs::exists(scratch / "l.0003.vdb"));
    const auto report = nlohmann::json::parse(read_text(scratch / "r.json"));
    EXPECT_EQ(report["exit_status"], 1);
    EXPECT_EQ(report["outputs"].size(), 1u);
    EXPECT_EQ(report["frames"].size(), 2u);
}

TEST_F(Frames, NoClobberLooksAtEachFrame)
{
    write_text(scratch / "l.0003.vdb", "mine");
    refused("illuminate -q in.%04d.vdb -o l.%04d.vdb --frames 1,3 --no-clobber", 1, "l.0003.vdb: file exists");
    EXPECT_EQ(read_text(scratch / "l.0003.vdb"), "mine");
}

}  // namespace
}  // namespace vdbcloud::test
