// What a run is: values that a checkpoint holds and compares, changes from a checkpoint on, and one run at a time.
#include "cloudsim_run.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <sstream>

namespace vdbcloud::test {
namespace {

/// A small dry box, fast enough for many runs. Options of `more` replace those of the box.
RunResult dry(const Scratch& scratch, const Words& more, const std::string& minutes = "2",
              const std::string& every = "30s", const RunOptions& options = {})
{
    Words words{program("cloudsim")};
    const Words box[] = {{"--cells", "6"},   {"--moisture", "off"}, {"--minutes", minutes},
                         {"--every", every}, {"--threads", "1"},    {"-o", scratch / "f.%02d.vdb"}};
    for (const Words& option : box)
        if (std::find(more.begin(), more.end(), option[0]) == more.end()) words = with(words, option);
    return run(with(words, more), options);
}

std::vector<double> times(const std::string& log)
{
    std::vector<double> list;
    std::istringstream in(log);
    for (std::string line; std::getline(in, line);) list.push_back(nlohmann::json::parse(line)["time"]);
    return list;
}

TEST(CloudsimResume, RefusesAnotherRunByName)
{
    const Scratch scratch;
    const std::string state = scratch / "state";
    ASSERT_EQ(dry(scratch, {"--checkpoint", state, "--unpruned"}).status, 0);
    const std::string frame = scratch / "f.04.vdb";
    // What is given on resuming, what the refusal names, and whether --change may take it.
    const struct {
        Words words;
        std::string named;
        bool can_change;
    } cases[] = {
        {{"--every", "20s"}, "every = 20", true},           {{"--up", "z"}, "up = Z", false},
        {{"--first-frame", "3"}, "first_frame = 3", false}, {{"--init", frame}, "init = ", false},
        {{"--heat-flux", "0.1"}, "heat_flux = 0.1", true},
    };
    for (const auto& c : cases) {
        Words words{"--resume", state, "--unpruned"};
        words.insert(words.end(), c.words.begin(), c.words.end());
        const RunResult r = dry(scratch, words, "3");
        EXPECT_EQ(r.status, 2) << c.named << ": " << r.err;
        EXPECT_NE(r.err.find("this run has '" + c.named), std::string::npos) << r.err;
        EXPECT_EQ(r.err.find("or --change") != std::string::npos, c.can_change) << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
    }
    // --change takes no constant.
    const Words change{"--resume", state, "--unpruned", "--change", "--minutes", "2"};
    const RunResult r = dry(scratch, with(change, {"--sponge", "0.5", "--gravity", "5"}));
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("this one cannot change within a run"), std::string::npos) << r.err;
    EXPECT_EQ(dry(scratch, {"--change"}).status, 2) << "without --resume";
}

TEST(CloudsimResume, ChangesHoldFromTheCheckpointOnAndAreNoted)
{
    const Scratch scratch;
    const auto line = [&](const std::string& name, const Words& more, const std::string& minutes,
                          const std::string& every) {
        Words words{"--checkpoint", scratch / (name + ".state"),    "--log",     scratch / (name + ".log"),
                    "-o",           scratch / (name + ".%02d.vdb"), "--unpruned"};
        words.insert(words.end(), more.begin(), more.end());
        return dry(scratch, words, minutes, every);
    };
    const auto mean = [&](const std::string& name) {
        std::istringstream in(read_text(scratch / (name + ".log")));
        double theta = 0;
        for (std::string text; std::getline(in, text);) theta = nlohmann::json::parse(text)["theta_mean"];
        return theta;
    };
    // No heat for two minutes, then 0.5 K m/s, then none again: the box of 3840 m gains what the flux brings.
    const Words still{"--no-forcing", "--noise", "0"};
    const auto heated = [&](const std::string& flux) {
        return Words{"--no-forcing", "--noise", "0", "--heat-flux", flux, "--resume", scratch / "a.state", "--change"};
    };
    ASSERT_EQ(line("a", still, "2", "30s").status, 0);
    const double before = mean("a");
    RunResult r = line("a", heated("0.5"), "4", "20s");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.err.find("after 120 s: heat_flux = 0 -> 0.5"), std::string::npos) << r.err;
    const double warmed = mean("a");
    EXPECT_NEAR((warmed - before) / (0.5 * 120 / 3840), 1, 0.02);  // the mean of 300 K is a float's last bits
    // The same command again, as make would call it: nothing changes twice, and nothing is left to do.
    r = line("a", heated("0.5"), "4", "20s");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_EQ(mean("a"), warmed);
    r = line("a", heated("0"), "6", "20s");
    ASSERT_EQ(r.status, 0) << r.err;
    EXPECT_NEAR(mean("a"), warmed, 1e-4);
    // Frames 0 to 4 each 30 s, then each 20 s.
    const std::vector<double> expected{0, 30, 60, 90, 120, 140, 160, 180, 200, 220, 240, 260, 280, 300, 320, 340, 360};
    EXPECT_EQ(times(read_text(scratch / "a.log")), expected);
    const GridFile last = read_grid_file(scratch / "a.16.vdb");
    EXPECT_EQ(get_text(*last.metadata, schema::sim_changes, ""),
              "after 120 s: heat_flux = 0 -> 0.5\nafter 120 s: every = 30 -> 20\n"
              "after 240 s: heat_flux = 0.5 -> 0\n");
    EXPECT_NE(get_text(*last.metadata, schema::sim_parameters, "").find("every = 20\n"), std::string::npos);
    const GridFile first = read_grid_file(scratch / "a.04.vdb");
    EXPECT_EQ(get_text(*first.metadata, schema::sim_changes, "none"), "none");
    // Without --change the command of the start is another run.
    r = line("a", with(still, {"--resume", scratch / "a.state"}), "6", "30s");
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("'every = 20', this run has 'every = 30'"), std::string::npos) << r.err;
}

TEST(CloudsimResume, LongerMinutesContinueTheSameFramesOrAreRefused)
{
    const Scratch scratch;
    const Words state{"--checkpoint", scratch / "state", "--resume", scratch / "state", "--log", scratch / "log"};
    ASSERT_EQ(dry(scratch, state, "1").status, 0);
    // Lines that are none of a run's, with a frame that is no number among them, are not kept.
    write_text(scratch / "log", read_text(scratch / "log") + "{\"frame\": \"x\"}\n[1]\n{\"frame\": null}\nno JSON\n");
    ASSERT_EQ(dry(scratch, state, "1.75").status, 0);  // the last frame is a quarter of a minute early
    EXPECT_EQ(times(read_text(scratch / "log")), (std::vector<double>{0, 30, 60, 90, 105}));
    const RunResult r = dry(scratch, state, "3");
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.err.find("before its next frame was due at 120"), std::string::npos) << r.err;
    ASSERT_EQ(dry(scratch, with(state, {"--change"}), "3").status, 0);
    EXPECT_EQ(times(read_text(scratch / "log")), (std::vector<double>{0, 30, 60, 90, 105, 135, 165, 180}));
    EXPECT_EQ(dry(scratch, state, "2").status, 0) << "nothing is left to do";
}

TEST(CloudsimResume, RunsThatWriteTheSameFilesRefuseEachOther)
{
    const Scratch scratch;
    const Words mine{"-o",    scratch / "f.%03d.vdb", "--checkpoint", scratch / "state",
                     "--log", scratch / "log",        "--cells",      "6"};
    for (const std::string taken : {"f.000.vdb", "state", "log"}) {
        const RunLock other_run(scratch / taken);  // this process stands for it
        const RunResult r = dry(scratch, mine, "0");
        EXPECT_EQ(r.status, 1) << taken << r.err;
        EXPECT_NE(r.err.find(taken + ": another run (process " + std::to_string(getpid()) + " on "), std::string::npos)
            << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
        if (taken != "log") continue;
        const RunResult free = dry(scratch, {"-o", scratch / "g.%03d.vdb"}, "0");  // of the same folder
        EXPECT_EQ(free.status, 0) << free.err;
    }
    EXPECT_EQ(scratch.list(), Words{"g.000.vdb"});
}

TEST(CloudsimResume, WhatAKilledRunLeavesGoesWithTheNext)
{
    for (const int signal : {SIGTERM, SIGKILL}) {
        const Scratch scratch;
        const Words words{"-o", scratch / "f.%03d.vdb", "--checkpoint", scratch / "state", "--log", scratch / "log"};
        RunOptions kill;
        kill.until = "frame 2";
        kill.signal = signal;
        EXPECT_EQ(dry(scratch, words, "6000", "1min", kill).status, 128 + signal);
        const auto hidden = [&] {
            Words names;
            for (const std::string& name : scratch.list())
                if (name[0] == '.') names.push_back(name);
            return names;
        };
        // A signal that can be caught leaves nothing; after the other one the marks are there, and in nobody's way.
        EXPECT_EQ(hidden().empty(), signal == SIGTERM);
        write_text(scratch / ".state.0123456789", "left by a killed run");
        write_text(scratch / ".log.0123456789abcdef", "left by a killed run");
        write_text(scratch / ".f.007.0123456789abcdef.vdb", "left by a killed run");
        write_text(scratch / ".f.0x7.0123456789abcdef.vdb", "not this run's");
        write_text(scratch / ".notes.0123456789", "not this run's");
        AtomicFile alive(scratch / "f.008.vdb");  // another program writes this one now
        const RunResult next = dry(scratch, words, "0");
        EXPECT_EQ(next.status, 0) << next.err;
        Words expected{".f.0x7.0123456789abcdef.vdb", ".notes.0123456789",
                       alive.name().substr(scratch.path().size() + 1)};
        std::sort(expected.begin(), expected.end());
        EXPECT_EQ(hidden(), expected);
    }
}

TEST(CloudsimResume, FramesOfAnEarlierRunAreSaid)
{
    const Scratch scratch;
    const Words words{"-o", scratch / "f.%03d.vdb"};
    const auto said = [&](const std::string& minutes, const Words& more = {}) {
        const RunResult r = dry(scratch, with(words, more), minutes);
        EXPECT_EQ(r.status, 0) << r.err;
        return r.err;
    };
    EXPECT_EQ(said("4").find("earlier run"), std::string::npos) << "the folder is empty";
    EXPECT_EQ(said("4").find("earlier run"), std::string::npos) << "all frames are replaced";
    const std::string shorter = said("2");
    EXPECT_NE(shorter.find("4 frames of an earlier run, f.005.vdb to f.008.vdb, beyond the last of this run, 4"),
              std::string::npos)
        << shorter;
    EXPECT_EQ(said("1", {"--first-frame", "7"}).find("earlier run"), std::string::npos) << "a film is continued";
}

TEST(CloudsimResume, ADeviceIsNoCheckpoint)
{
    const Scratch scratch;
    const RunResult r = dry(scratch, {"-o", scratch / "f.%03d.vdb", "--resume", "/dev/zero"});
    EXPECT_EQ(r.status, 1);
    EXPECT_NE(r.err.find("/dev/zero: a folder or device: expected a checkpoint"), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find("remove"), std::string::npos) << r.err;
}

TEST(CloudsimResume, OneFileForManyFramesIsSaid)
{
    const Scratch scratch;
    const RunResult r = dry(scratch, {"-o", scratch / "last.vdb"});
    EXPECT_EQ(r.status, 0);
    EXPECT_NE(r.err.find("has no place for a number"), std::string::npos) << r.err;
}

/// Frames are 15 s apart and steps shorter, so that the count of the rest is that of the run within the steps that land
/// on frames: a third.
TEST(CloudsimResume, DryRunCountsTheRestAlone)
{
    const Scratch scratch;
    const std::string state = scratch / "state";
    const Words box{"--cells", "16", "--moisture", "on", "--every", "15s", "--json", "-", "-q"};
    const auto report = [&](const Words& more, const std::string& minutes) {
        const RunResult r = dry(scratch, with(box, more), minutes);
        EXPECT_EQ(r.status, 0) << r.err;
        return nlohmann::json::parse(r.out);
    };
    const double first = report({"--checkpoint", state}, "6")["counts"]["steps"];
    const nlohmann::json rest = report({"--resume", state, "--dry-run"}, "15")["estimate"],
                         whole = report({"--dry-run"}, "15")["estimate"],
                         nothing = report({"--resume", state, "--dry-run"}, "6")["estimate"];
    const nlohmann::json taken = report({"--resume", state}, "15");
    const double steps = double(taken["counts"]["steps"]) - first;
    EXPECT_GT(steps, 30);
    EXPECT_NEAR(rest["steps"], steps, 0.35 * steps);
    EXPECT_NEAR(whole["steps"], steps + first, 0.35 * (steps + first));
    EXPECT_EQ(rest["events"]["sim_frame_cell"], taken["events"]["sim_frame_cell"]);
    EXPECT_EQ(nothing["steps"], 0);
    EXPECT_EQ(nothing["events"].value("sim_frame_cell", 0.0), 0);

    const RunResult other = dry(scratch, with(box, {"--resume", state, "--dry-run", "--up", "z"}), "15");
    EXPECT_EQ(other.status, 2);
    EXPECT_NE(other.err.find("up = Z"), std::string::npos) << other.err;
}

}  // namespace
}  // namespace vdbcloud::test
