// The suite of hard cases at the size of a change, and the suite itself.
#include "hard/coverage.h"
#include "hard/hostile.h"
#include "hard/soak.h"
#include "hard/suite.h"

#include <gtest/gtest.h>

#include "support/size.h"

#include <filesystem>

namespace vdbcloud::test {
namespace {

class Hard : public testing::Test {
protected:
    /// Expects that every row passes, and shows those that do not.
    void expect_pass()
    {
        std::vector<Row> bad;
        for (const Row& row : suite.rows())
            if (!row.passes()) bad.push_back(row);
        if (bad.empty()) return;
        ADD_FAILURE() << table(bad);
        for (const Failure& failure : suite.failures())
            ADD_FAILURE() << failure.invariant << " " << failure.value << ", limit " << failure.limit << ": "
                          << failure.where << "\n"
                          << failure.world;
    }

    Programs programs;
    Scratch scratch;
    Suite suite{programs, scratch.path()};
};

TEST_F(Hard, CasesHold)
{
    for (const World& world : read_worlds(VDBCLOUD_HARD "/cases.txt")) suite.run_case(world);
    EXPECT_GE(suite.rows().size(), 100u);
    expect_pass();
}

class HardWorlds : public Hard, public testing::WithParamInterface<int> {};

// `make -C tests hard SIZE=full` runs 10000.
TEST_P(HardWorlds, Hold)
{
    for (int seed = GetParam(); seed < GetParam() + 50; ++seed) suite.run_random(uint64_t(seed));
    expect_pass();
}

INSTANTIATE_TEST_SUITE_P(From, HardWorlds, testing::Range(1, 301, 50));

// `make -C tests hard SIZE=full` sends 5000 to each program.
TEST_F(Hard, HostileFilesEndInASentence)
{
    Hostile hostile(programs, scratch.path());
    EXPECT_EQ(hostile.refused_when_healthy(), Words());
    for (const std::string& tool : Hostile::tools())
        for (uint64_t seed = 1; seed <= 8; ++seed) hostile.run(tool, seed);
    for (const Row& row : hostile.rows())
        EXPECT_TRUE(row.passes() || (!Programs::start_once() && row.invariant != "ends")) << table({row}) << row.where;
    for (const Failure& failure : hostile.failures()) ADD_FAILURE() << failure.where << "\n" << failure.world;
    EXPECT_EQ(hostile.rows().size(), 3 * Hostile::tools().size());
    // Neither all files are refused nor are they all harmless.
    EXPECT_GE(hostile.statuses().at(0), 8);
    EXPECT_GE(hostile.statuses().at(1), 20);
}

TEST(HardHostile, EndsWithoutASentenceAreComplaints)
{
    EXPECT_EQ(complaint("render", 0, ""), "");
    EXPECT_EQ(complaint("render", 0, "render: warning: a\nrender: b\n"), "");
    EXPECT_EQ(complaint("render", 1, "a library's words\nrender: x.vdb: damaged\n"), "");
    EXPECT_NE(complaint("render", 1, ""), "");
    EXPECT_NE(complaint("render", 1, "render: x\nterminate called\n"), "");
    EXPECT_NE(complaint("render", 2, "p1solve: x.vdb: damaged\n"), "");
    EXPECT_NE(complaint("render", 139, "render: x.vdb: damaged\n"), "");
    EXPECT_NE(complaint("render", 4, "render: x.vdb: damaged\n"), "");
    EXPECT_NE(complaint("render", 0, "render: warning: grid '\x1b[31m'\n"), "");
    EXPECT_NE(complaint("render", 1, "render: " + std::string(70000, 'x')), "");
}

TEST_F(Hard, HostileFilesAreOfAllKinds)
{
    Hostile hostile(programs, scratch.path());
    std::map<std::string, int> seen;
    for (const std::string& tool : Hostile::tools())
        for (uint64_t seed = 1; seed <= (tool == "cloudsim" ? 150 : 30); ++seed) {
            const Mutant mutant = hostile.mutant(tool, seed);
            EXPECT_FALSE(mutant.bytes == read_text(scratch / mutant.what.substr(0, mutant.what.find(':'))))
                << tool << ", seed " << seed << ": " << mutant.what;
            for (const char* kind :
                 {"damaged", "spliced", "key ", "= missing", "background", "transform of", "another name", " as Tree",
                  "a tile", "far away", "flags", "many grids", "compressed", "Blosc", ": text", "claims of a .exr",
                  "claims of a .png", "claims of a .hdr", "a value of the state"})
                seen[kind] += mutant.what.find(kind) != std::string::npos;
            seen["standard input"] += mutant.input != "/dev/null";
        }
    for (const auto& [kind, count] : seen) EXPECT_GT(count, 0) << kind;
    EXPECT_EQ(hostile.mutant("render", 5).bytes, hostile.mutant("render", 5).bytes);
}

TEST_F(Hard, FramesTakeNeitherMoreMemoryNorDescriptorsNorFiles)
{
    if (!Programs::start_once()) GTEST_SKIP() << "sanitizers keep freed memory";
    for (const Row& row : soak(sized(10, 200), scratch.path())) EXPECT_TRUE(row.passes()) << table({row}) << row.where;
}

TEST_F(Hard, GrowthIsSeen)
{
    const std::string frames = "for n in 1 2 3 4 5 6 7 8; do %s echo > frame.000$n; sleep 0.05; done";
    const auto growth = [&](const std::string& each, const std::string& left) {
        std::string line = frames;
        line.replace(line.find("%s"), 2, each);
        return watch("/bin/bash", {"-c", line + left}, scratch.path(), "frame.%04d", 8);
    };
    const Growth still = growth("", "");
    EXPECT_EQ(still.status, 0);
    EXPECT_LT(still.memory, 0.1);
    EXPECT_LE(std::abs(still.descriptors), 2) << "the shell's own, while it opens a frame";
    EXPECT_EQ(still.left, 0);
    std::filesystem::remove(scratch / "frame.0004");
    const Growth grown =
        growth("x=$x$(printf %02000000d 0); exec {file}</dev/null;", "; echo > \"$TMPDIR/a\"; echo > .b");
    EXPECT_GT(grown.memory, 0.3);
    EXPECT_GE(grown.descriptors, 3);
    EXPECT_EQ(grown.left, 2);
}

// A program that is started once gives what it gives when it is started anew.
TEST_F(Hard, ProgramsStartedOnceWriteTheFilesOfProgramsStartedAnew)
{
    const Words options{"--size", "8", "--seed", "3", "-q", "--threads", "1", "-o"};
    Words once = options, anew = options;
    once.push_back("once.vdb");
    anew.push_back(scratch / "anew.vdb");
    anew.insert(anew.begin(), program("fractalgen"));
    EXPECT_EQ(programs.run("fractalgen", once, scratch.path()).status, 0);
    EXPECT_EQ(programs.run("fractalgen", once, scratch.path()).status, 0);
    EXPECT_EQ(run(anew).status, 0);
    const std::string bytes = read_text(scratch / "once.vdb");
    EXPECT_GT(bytes.size(), 1000u);
    EXPECT_TRUE(bytes == read_text(scratch / "anew.vdb"));
    EXPECT_EQ(programs.run("fractalgen", {"--no-such-option"}, scratch.path()).status, 2);
}

TEST_F(Hard, ARunEndsAtItsLimits)
{
    if (!Programs::start_once()) GTEST_SKIP() << "under sanitizers";
    Programs brief({1, 2147483648.0}), small({20, 300e6});
    const Words large{"--size", "400", "--threads", "1", "-q", "-o", "large.vdb"};
    EXPECT_EQ(small.run("fractalgen", large, scratch.path()).status, 1);
    EXPECT_EQ(brief.run("fractalgen", {"--size", "8", "-q", "-o", "small.vdb"}, scratch.path()).status, 0);
    const Words slow{"small.vdb", "--extinction", "100", "--integrator", "path", "--samples",
                     "1000000",   "--threads",    "1",   "-q",           "-o",   "slow.exr"};
    EXPECT_EQ(brief.run("render", slow, scratch.path()).status, 1);
    EXPECT_NE(read_text(scratch / "stderr").find("the limit of processor time (ulimit -t) ended the run"),
              std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(scratch / "slow.exr"));
}

// The programs are those of apps/CMakeLists.txt, so a new program needs rows, too.
std::vector<std::string> all_programs()
{
    const std::string text = read_text(VDBCLOUD_SOURCE "/apps/CMakeLists.txt");
    const std::string before = "foreach(app common ", after = " vdbcloud)";
    const size_t begin = text.find(before) + before.size();
    return split(text.substr(begin, text.find(after, begin) - begin));
}

TEST_F(Hard, EveryProgramAndOptionHasARow)
{
    const auto programs_here = all_programs();
    ASSERT_GE(programs_here.size(), 9u);
    std::vector<World> worlds = read_worlds(VDBCLOUD_HARD "/cases.txt");
    for (uint64_t seed = 1; seed <= 1000; ++seed) worlds.push_back(random_world(seed));
    const OptionSet help = options_of_help(programs_here);
    EXPECT_EQ(help.size(), programs_here.size());
    const OptionSet used = options_of_worlds(worlds);
    for (const std::string& sentence :
         missing_rows(help, used, options_without_rows(VDBCLOUD_HARD "/without_rows.txt", help, used)))
        ADD_FAILURE() << sentence << " (tests/hard/README.md)";
}

TEST(HardCoverage, NamesWhatHasNoRowAndWhatIsExcusedInVain)
{
    const OptionSet help = {{"render", {"--a", "--b", "--c"}}};
    EXPECT_EQ(missing_rows(help, {{"render", {"--a"}}}, {{"render", {"--b"}}}), Words{"render --c has no row"});
    EXPECT_EQ(missing_rows(help, {{"render", {"--a", "--b"}}}, {{"render", {"--b", "--c"}}}),
              Words{"render --b has rows, and a line that says it has none"});
    EXPECT_EQ(missing_rows(help, {{"render", {"--a", "--b", "--c"}}}, {{"render", {"--d"}}}),
              Words{"render has no option --d"});
    EXPECT_TRUE(missing_rows(help, {{"render", {"--a", "--b"}}}, {{"render", {"--c"}}}).empty());
}

World small_world()
{
    World world;
    world.name = "small";
    world.bodies = {"noise n=5,4,3 seed=2"};
    world.medium = "--extinction 1 --albedo 0.9";
    world.lights = {WorldLight()};
    world.lights[0].at = Vec3d(0.3, 1, 0.2);
    world.solve = "--reentry-rays 0";
    world.view = "--resolution 3";
    return world;
}

// The suite must notice what it is for: two worlds that are not twins differ.
TEST_F(Hard, DifferenceSeesAnotherSunAndAnotherDensity)
{
    Chain chain(programs, scratch.path());
    const World world = small_world();
    const Seen seen = chain.run(world);
    ASSERT_EQ(seen.failure, "");
    EXPECT_EQ(difference(seen, seen, {}, 1).worst, 0);
    World other = world;
    other.lights[0].at[0] = 0.31;
    EXPECT_GT(difference(seen, chain.run(other), {}, 1).worst, 1e-3);
    other = world;
    other.bodies[0] += " times=1.01";
    EXPECT_GT(difference(seen, chain.run(other), {}, 1).worst, 1e-3);
    other = world;
    other.medium = "--extinction 1 --albedo 0.9 --g 0.1";
    EXPECT_GT(difference(seen, chain.run(other), {}, 1).worst, 1e-3);
    Change mirror;  // of the index axis alone: another body
    mirror.sign[0] = -1;
    EXPECT_LT(difference(seen, chain.run(world, mirror), mirror, 1).worst, 1e-5);
    EXPECT_GT(difference(seen, chain.run(world, mirror), {}, 1).worst, 0.0);
}

TEST_F(Hard, AFailureIsMadeSmaller)
{
    World world = small_world();
    world.name = "seed-0";
    world.lights.push_back(world.lights[0]);
    world.origin = Vec3d(3, 4, 5);
    world.holds = {{"finite", -1.0}, {"bounds", 1}};
    suite.run_case(world);
    ASSERT_EQ(suite.failures().size(), 1u);
    const World small = suite.smallest(world, "finite", "");
    EXPECT_EQ(small.lights.size(), 1u);
    EXPECT_EQ(small.origin, Vec3d(0));
    EXPECT_EQ(small.stages, "p1solve");
    EXPECT_EQ(small.holds.size(), 1u);
}

TEST_F(Hard, ARefusalNeedsItsStatusAndItsSentence)
{
    const auto passes = [&](const std::string& command, int status, const std::string& sentence) {
        World world;
        world.name = "refusal";
        world.commands = {"fractalgen --size 6 -q -o ok.vdb", command};
        world.refused = status;
        world.sentence = sentence;
        Suite one(programs, scratch.path());
        one.run_case(world);
        return one.rows().at(0).passes();
    };
    const std::string missing = "render none.vdb -o out.exr";
    EXPECT_TRUE(passes(missing, 1, "No such file"));
    EXPECT_FALSE(passes(missing, 2, "No such file"));
    EXPECT_FALSE(passes(missing, 1, "a level set"));
    EXPECT_FALSE(passes("vdbprobe ok.vdb --grid density --at 0,0,0", 1, "No such file")) << "nothing is refused";
    World early;  // the program before the last one fails
    early.name = "early";
    early.commands = {missing, "fractalgen --size 6 -q -o ok.vdb"};
    early.refused = 1;
    early.sentence = "No such file";
    suite.run_case(early);
    EXPECT_FALSE(suite.rows().at(0).passes());
}

TEST_F(Hard, NumbersOfReportsAreCompared)
{
    Chain chain(programs, scratch.path());
    write_text(scratch / "one.json", R"({"a": {"b": [2, 0, true]}})");
    write_text(scratch / "lines.json", "{\"t\": 1}\n{\"t\": 3}\n");
    const auto error = [&](const std::string& held) { return judged(chain, {}, {}, "number " + held).worst; };
    EXPECT_EQ(error("one.json /a/b/0 2"), 0);
    EXPECT_NEAR(error("one.json /a/b/0 4"), 0.5, 1e-15);
    EXPECT_NEAR(error("one.json /a/b/0 -2"), 2, 1e-15);
    EXPECT_NEAR(error("one.json /a/b/0 0"), 2, 1e-15) << "of 0 the absolute difference";
    EXPECT_EQ(error("one.json /a/b/1 0"), 0);
    EXPECT_EQ(error("one.json /a/b/2 1"), 0);
    EXPECT_NEAR(error("lines.json /1/t one.json /a/b/0"), 0.5, 1e-15);
    EXPECT_THROW(error("one.json /a/c 0"), std::exception);
    EXPECT_THROW(error("none.json /a 0"), std::exception);
}

TEST(HardRecords, AreReadAsTheyAreWritten)
{
    for (const uint64_t seed : {1, 2, 3, 40, 500, 6000}) {
        const World world = random_world(seed);
        const Scratch scratch;
        write_text(scratch / "one.txt", "# a comment\n\n" + world.text() + "\n");
        const auto read = read_worlds(scratch / "one.txt");
        ASSERT_EQ(read.size(), 1u);
        EXPECT_EQ(read[0].text(), world.text());
    }
    EXPECT_NE(random_world(1).text(), random_world(2).text());
}

TEST(HardRows, OfSeveralRangesAddUp)
{
    const Row a{"random worlds", "finite", 1e-3, 2e-3, 10, 1, "seed-1: x", ""},
        b{"random worlds", "finite", 4e-3, 2e-3, 5, 2, "seed-9: y", ""};
    std::vector<Row> rows = rows_of_csv(csv({a}));
    ASSERT_EQ(rows.size(), 1u);
    for (const Row& row : rows_of_csv(csv({b, {"case", "lights", 0, 1, 1, 0, "", "a reason"}}))) add_row(rows, row);
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[0].worlds, 15);
    EXPECT_EQ(rows[0].failed, 3);
    EXPECT_EQ(rows[0].worst, 4e-3);
    EXPECT_EQ(rows[0].where, "seed-9: y");
    EXPECT_FALSE(rows[0].passes());
    EXPECT_EQ(rows[1].known, "a reason");
    EXPECT_FALSE(rows[1].passes()) << "a known failure that passes is red";
}

}  // namespace
}  // namespace vdbcloud::test
