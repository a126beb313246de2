// Files that options name: an output is never another output, nor an input, under any spelling, and has the name of its
// kind.
#include "apps/tools.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>

namespace vdbcloud::test {
namespace {

namespace fs = std::filesystem;

/// A folder with a lit cloud; commands run in it.
class NamedFiles : public testing::Test {
protected:
    void SetUp() override
    {
        make_lit_cloud(scratch / "in.vdb");
        fs::create_directory(scratch / "sub");
    }
    RunResult at(const std::string& line) const
    {
        RunOptions there;
        there.folder = scratch.path();
        return shell(line, there);
    }
    Scratch scratch;
};

TEST_F(NamedFiles, TwoOutputsOfOneFileAreRefusedUnderEverySpelling)
{
    write_text(scratch / "there", "old");
    fs::create_symlink("there", scratch / "link");
    fs::create_symlink("absent", scratch / "dangling");
    fs::create_symlink("sub", scratch / "folder");
    fs::create_hard_link(scratch / "there", scratch / "hard");
    const struct {
        std::string output, report;
        bool same;
    } table[] = {{"there", "there", true},        {"there", "./there", true},
                 {"there", "sub/../there", true}, {"there", scratch / "there", true},
                 {"there", "link", true},         {"there", "hard", true},
                 {"hard", "link", true},          {"absent", "dangling", true},
                 {"absent", "./absent", true},    {"sub/absent", "folder/absent", true},
                 {"-", "/dev/stdout", true},      {"there", "absent", false},
                 {"absent", "sub/absent", false}, {"/dev/null", "/dev/null", false},
                 {"-", "/dev/stderr", false}};
    for (const auto& [output, report, same] : table) {
        const RunResult r = at("echo_tool -o '" + output + "' --json '" + report + "'");
        EXPECT_EQ(r.status, same ? 2 : 0) << output << " " << report << "\n" << r.err;
        EXPECT_EQ(r.err.find("are the same file: expected a file for each") != std::string::npos, same) << r.err;
        if (same) {
            EXPECT_EQ(read_text(scratch / "there"), "old") << output << " " << report;
            EXPECT_FALSE(fs::exists(scratch / "absent") || fs::exists(scratch / "sub/absent"));
        }
        write_text(scratch / "there", "old");
        fs::remove(scratch / "absent");
        fs::remove(scratch / "sub/absent");
    }
}

TEST_F(NamedFiles, EveryProgramRefusesOutputsThatAreOneFileOrAnInput)
{
    const std::string before = read_text(scratch / "in.vdb");
    fs::create_symlink("in.vdb", scratch / "in");
    write_text(scratch / "table", "1 1\n");
    write_text(scratch / "scene", "");
    write_text(scratch / "state", "a checkpoint");
    for (const char* line :
         {"render in.vdb --resolution 4 -o a.png --png a.png", "render in.vdb --resolution 4 -o a.png --png ./a.png",
          "render --config scene in.vdb -o a.exr --json scene", "p1solve in.vdb --albedo 0.9 -o - --flux-map -",
          "illuminate in.vdb -o a.vdb --json in", "fractalgen --size 8 in.vdb -o a.vdb --json in",
          "fractalgen --size 8 --envelope-from in -o in.vdb --json in",
          "vdbimport table --cell 1,1,1 -o a.vdb --json table", "vdbprobe in --grid density --at 0,0,0 --json in",
          "vdbdiff in in.vdb --json in", "exrmerge in.vdb -o a.exr --json in",
          "cloudsim --preset smoke --cells 4 --minutes 0.1 -o a.vdb --log x --checkpoint x",
          "cloudsim --preset smoke --cells 4 --minutes 0.1 -o - --log -",
          "cloudsim --preset smoke --cells 4 --minutes 0.1 -o a.vdb --resume state --log state",
          "cloudsim --preset smoke --cells 4 --minutes 0.1 --init in.vdb -o in.vdb"}) {
        const RunResult r = at(line);
        EXPECT_EQ(r.status, 2) << line << "\n" << r.err;
        EXPECT_NE(r.err.find("same file"), std::string::npos) << line << "\n" << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
        EXPECT_TRUE(read_text(scratch / "in.vdb") == before) << line;
        EXPECT_EQ(read_text(scratch / "table") + read_text(scratch / "scene"), "1 1\n") << line;
        EXPECT_EQ(scratch.list(), (Words{"in", "in.vdb", "scene", "state", "sub", "table"})) << line;
    }
}

TEST_F(NamedFiles, AReportOfAWrongCommandNeverReplacesAnotherFileOfTheCommand)
{
    const std::string before = read_text(scratch / "in.vdb");
    fs::create_symlink("in.vdb", scratch / "in");
    for (const char* report : {"in.vdb", "in", "./in.vdb"}) {
        EXPECT_EQ(at("illuminate in.vdb -o a.vdb --no-such-option --json " + std::string(report)).status, 2);
        EXPECT_TRUE(read_text(scratch / "in.vdb") == before) << report;
    }
    EXPECT_EQ(at("illuminate in.vdb -o a.vdb --no-such-option --json report").status, 2);
    EXPECT_EQ(nlohmann::json::parse(read_text(scratch / "report"))["exit_status"], 2);
}

TEST_F(NamedFiles, EachWriterTakesTheExtensionsOfItsKind)
{
    const struct {
        const char* line;
        const char* said;  // null: accepted
    } table[] = {
        {"fractalgen --size 8 -o f.nvdb",
         "--output f.nvdb: expected a name that ends in .vdb; for NanoVDB write f.vdb, "
         "then nanovdb_convert f.vdb f.nvdb"},
        {"fractalgen --size 8 -o f", "expected a name that ends in .vdb"},
        {"fractalgen --size 8 -o F.VDB", nullptr},
        {"fractalgen --size 8 -o /dev/null", nullptr},
        {"fractalgen --size 8 -o - | cat > piped", nullptr},
        {"illuminate in.vdb -o shot.exr", "--output shot.exr: expected a name that ends in .vdb"},
        {"p1solve in.vdb --albedo 0.9 -o shot.png", "expected a name that ends in .vdb"},
        {"p1solve in.vdb --albedo 0.9 -o a.vdb --flux-map map.png",
         "--flux-map map.png: expected a name that ends in .exr"},
        {"cloudsim --preset smoke --cells 4 --minutes 0.1 -o f.%04d.exr", "expected a name that ends in .vdb"},
        {"cloudsim --preset smoke --cells 4 --minutes 0.1 -o f.vdb --log f.exr",
         "expected a name that does not end in .exr"},
        {"vdbimport in.vdb --cell 1,1,1 -o a.txt", "expected a name that ends in .vdb"},
        {"render in.vdb --resolution 4 -o a.vdb", "expected a name that ends in .exr or .png"},
        {"render in.vdb --resolution 4 -o a.jpg", "then oiiotool a.exr -o a.jpg"},
        {"render in.vdb --resolution 4 -o a.exr --png a.exr", "--png a.exr: expected a name that ends in .png"},
        {"render in.vdb --resolution 4 -o a.exr --json shot.exr", "expected a name that does not end in .exr"},
        {"render in.vdb --resolution 4 -o A.EXR --png a.PNG --json r", nullptr},
        {"exrmerge in.vdb -o a.png", "expected a name that ends in .exr"},
    };
    for (const auto& [line, said] : table) {
        const RunResult r = at(line);
        EXPECT_EQ(r.status, said ? 2 : 0) << line << "\n" << r.err;
        if (said) {
            EXPECT_NE(r.err.find(said), std::string::npos) << line << "\n" << r.err;
        }
    }
    for (const char* absent : {"f.nvdb", "f", "shot.exr", "shot.png", "a.txt", "a.vdb", "a.jpg", "a.exr", "f.vdb"})
        EXPECT_FALSE(fs::exists(scratch / absent)) << absent;
}

TEST_F(NamedFiles, AStageMayWriteOverItsInput)
{
    ASSERT_EQ(at("illuminate in.vdb --sun 1,1,0 -o out.vdb && illuminate in.vdb --sun 1,1,0 -o in.vdb").status, 0);
    EXPECT_EQ(at("vdbdiff --metadata in.vdb out.vdb").status, 0);
}

TEST_F(NamedFiles, TheReportAtASignalFollowsNoLinkThatAnotherPlaced)
{
    // exec keeps the process number, so that the link has the name that a careless writer would take.
    write_text(scratch / "victim", "mine");
    RunOptions options;
    options.until = "sleeping";
    options.signal = SIGTERM;
    options.folder = scratch.path();
    const RunResult r = shell("ln -s victim .r.json.$$ && exec echo_tool -o out --act sleep --json r.json", options);
    EXPECT_EQ(r.status, 143) << r.err;
    EXPECT_EQ(read_text(scratch / "victim"), "mine");
    EXPECT_EQ(nlohmann::json::parse(read_text(scratch / "r.json"))["exit_status"], 143);
    const Words names = scratch.list();
    EXPECT_EQ(std::count_if(names.begin(), names.end(), [](const std::string& n) { return n[0] == '.'; }), 1);
}

}  // namespace
}  // namespace vdbcloud::test
