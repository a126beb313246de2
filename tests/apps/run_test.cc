// Signals, terminals, pipes, threads, progress and the report, on a program that does only what it is told.
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <sstream>
#include <thread>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

RunResult echo(Words words, const RunOptions& options = {})
{
    words.insert(words.begin(), program("echo_tool"));
    return run(words, options);
}

nlohmann::json report_of(Words words, const RunOptions& options = {})
{
    words.insert(words.end(), {"-o", "/dev/null", "--json", "-"});
    return nlohmann::json::parse(echo(words, options).out);
}

class Signals : public testing::TestWithParam<int> {};

TEST_P(Signals, EndTheRunByThatSignalAndLeaveAReportAlone)
{
    const Scratch scratch;
    RunOptions options;
    options.until = "sleeping";
    options.signal = GetParam();
    options.seconds = 20;
    const RunResult r = echo({"-o", scratch / "out", "--act", "sleep", "--json", scratch / "report"}, options);
    EXPECT_EQ(r.status, 128 + GetParam());
    EXPECT_FALSE(r.timed_out);
    EXPECT_EQ(scratch.list(), Words{"report"});
    const auto report = nlohmann::json::parse(read_text(scratch / "report"));
    EXPECT_EQ(report["exit_status"], 128 + GetParam());
    EXPECT_EQ(report["error"], "ended by SIG" + std::string(sigabbrev_np(GetParam())));
    EXPECT_EQ(report["parameters"]["act"], "sleep");
}

INSTANTIATE_TEST_SUITE_P(Run, Signals, testing::Values(SIGINT, SIGTERM, SIGHUP),
                         [](const auto& p) { return std::string(sigabbrev_np(p.param)); });

TEST(Run, ALimitOfProcessorTimeEndsARunAsOtherLimitsDo)
{
    // One number for both limits, at the greater of which the system kills.
    const Scratch scratch;
    const RunResult r =
        shell("ulimit -t 2; echo_tool -o '" + scratch / "out' --act spin --json '" + scratch / "report'");
    EXPECT_EQ(r.status, 1);
    EXPECT_EQ(r.err,
              "echo_tool: the limit of processor time (ulimit -t) ended the run: expected a higher limit, or less "
              "work, which --dry-run estimates\n");
    EXPECT_EQ(scratch.list(), Words{"report"});
    const auto report = nlohmann::json::parse(read_text(scratch / "report"));
    EXPECT_EQ(report["exit_status"], 1);
    EXPECT_EQ(report["error"], "ended by SIGXCPU");
}

TEST(Run, ASignalDoesNotReplaceAReportThatIsADevice)
{
    const Scratch scratch;
    ASSERT_EQ(::mkfifo((scratch / "fifo").c_str(), 0600), 0);
    RunOptions options;
    options.until = "sleeping";
    options.signal = SIGTERM;
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "sleep", "--json", scratch / "fifo"}, options).status, 143);
    struct stat status = {};
    ASSERT_EQ(::lstat((scratch / "fifo").c_str(), &status), 0);
    EXPECT_TRUE(S_ISFIFO(status.st_mode));
    EXPECT_EQ(scratch.list(), Words{"fifo"});
}

TEST(Run, AnInterruptThatTheParentIgnoresIsIgnored)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    const std::string line =
        "trap '' INT; echo_tool -o out --act sleep 2>err & while ! grep -q sleeping err 2>/dev/null; do sleep 0.02; "
        "done; kill -INT $!; sleep 0.2; kill -TERM $!; wait $!";
    EXPECT_EQ(shell(line, there).status, 143);
    EXPECT_EQ(scratch.list(), Words{"err"});
}

TEST(Run, AClosedPipeEndsTheRunAsSigpipe)
{
    for (bool ignored : {false, true}) {
        const Scratch scratch;
        RunOptions options;
        options.close_stdout = true;
        options.ignore_sigpipe = ignored;
        options.seconds = 20;
        EXPECT_EQ(echo({"-o", scratch / "out", "--act", "pipe"}, options).status, 141) << ignored;
        EXPECT_EQ(scratch.list(), Words());
    }
}

TEST(Run, AReaderThatLeavesEndsTheWriterInAShellPipe)
{
    const Scratch scratch;
    const RunResult r = shell("echo_tool -q --act pipe -o '" + (scratch / "out") + "' | head -c 10");
    EXPECT_EQ(r.status, 141);
    EXPECT_EQ(r.out, "xxxxxxxxxx");
    EXPECT_EQ(scratch.list(), Words());
}

TEST(Run, ATerminalGetsNoBinaryUnlessForced)
{
    RunOptions terminal;
    terminal.terminal = true;
    const RunResult refused = echo({"-o", "-", "--act", "say"}, terminal);
    EXPECT_EQ(refused.status, 2);
    EXPECT_NE(refused.out.find("standard output is a terminal"), std::string::npos) << refused.out;
    EXPECT_EQ(refused.out.find("hello"), std::string::npos);
    EXPECT_EQ(echo({"-o", "-", "--act", "say", "--force"}, terminal).status, 0);
    EXPECT_EQ(echo({"-o", "-", "--act", "say"}).status, 0);
}

TEST(Run, ATerminalIsNotReadFrom)
{
    RunOptions terminal;
    terminal.terminal = true;
    const RunResult r = echo({"-", "-o", "/dev/null", "--act", "copy"}, terminal);
    EXPECT_EQ(r.status, 2);
    EXPECT_NE(r.out.find("standard input is a terminal"), std::string::npos) << r.out;
}

TEST(Run, ColoursAndBarsAreForTerminals)
{
    RunOptions terminal, plain;
    terminal.terminal = true;
    terminal.environment = {"NO_COLOR"};
    plain.terminal = true;
    plain.environment = {"NO_COLOR=1"};
    EXPECT_NE(echo({"-o", "/dev/null", "--act", "warn"}, terminal).out.find("\033[33m"), std::string::npos);
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "warn"}, plain).out.find("\033["), std::string::npos);
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "warn"}).err.find("\033["), std::string::npos);
    RunOptions drawn = terminal;
    drawn.until = "waiting";
    drawn.signal = SIGTERM;
    const RunResult bar = echo({"-o", "/dev/null", "--act", "sleep"}, drawn);
    EXPECT_EQ(bar.status, 143);
    EXPECT_NE(bar.out.find("[#"), std::string::npos) << bar.out;
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "steps"}).err, "");
}

TEST(Run, ProgressIsLinesOrObjectsWhenAskedFor)
{
    const std::string lines = echo({"-o", "/dev/null", "--act", "steps", "--progress", "always"}).err;
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 11) << lines;
    EXPECT_NE(lines.find("echo_tool: steps 50 %\n"), std::string::npos);
    std::istringstream machine(echo({"-o", "/dev/null", "--act", "steps", "--progress", "machine"}).err);
    std::string last;
    for (std::string line; std::getline(machine, line);) last = line;
    const auto object = nlohmann::json::parse(last);
    EXPECT_EQ(object["tool"], "echo_tool");
    EXPECT_EQ(object["phase"], "steps");
    EXPECT_EQ(object["fraction"], 1);
    EXPECT_GE(object["seconds"].get<double>(), 0);
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "steps", "--progress", "never"}).err, "");
}

TEST(Run, ThreadsAreAtMostThoseGivenAndThoseAllowed)
{
    EXPECT_EQ(report_of({"--act", "threads", "--threads", "1"})["counts"]["threads_at_once"], 1);
    const auto two = report_of({"--act", "threads", "--threads", "2"});
    EXPECT_EQ(two["threads"], 2);
    EXPECT_LE(two["counts"]["threads_at_once"].get<int>(), 2);
    if (std::thread::hardware_concurrency() > 1) {
        EXPECT_EQ(two["counts"]["threads_at_once"], 2);
    }

    RunOptions slurm;
    slurm.environment = {"SLURM_CPUS_PER_TASK=1"};
    EXPECT_EQ(report_of({}, slurm)["threads"], 1);
    EXPECT_EQ(report_of({"--threads", "3"}, slurm)["threads"], 3);
    const RunResult pinned = shell("taskset -c 0 echo_tool -o /dev/null --json -");
    EXPECT_EQ(nlohmann::json::parse(pinned.out)["threads"], 1);
}

TEST(Report, OfASuccessHasAllParts)
{
    const auto r = report_of({"--act", "warn", "--density", "0.25", "-v"});
    EXPECT_EQ(r["schema"], 1);
    EXPECT_EQ(r["tool"], "echo_tool");
    EXPECT_TRUE(r["version"].is_string());
    EXPECT_EQ(r["exit_status"], 0);
    EXPECT_FALSE(r.contains("error"));
    EXPECT_EQ(r["warnings"], nlohmann::json{"2 negative values became 0"});
    EXPECT_EQ(r["parameters"]["density"], 0.25);
    EXPECT_EQ(r["parameters"]["seed"], 7);
    EXPECT_EQ(r["parameters"]["method"], "cells");
    EXPECT_EQ(r["parameters"]["haze"], true);
    EXPECT_EQ(r["parameters"]["sun"], (nlohmann::json{0.3, 1, 0.2}));
    EXPECT_FALSE(r["parameters"].contains("threads"));
    ASSERT_EQ(r["phases"].size(), 1u);
    EXPECT_EQ(r["phases"][0]["name"], "act");
    EXPECT_GE(r["phases"][0]["wall_seconds"].get<double>(), 0);
    EXPECT_GE(r["phases"][0]["cpu_seconds"].get<double>(), 0);
    EXPECT_GT(r["peak_memory_bytes"].get<double>(), 1e6);
    for (const char* key : {"inputs", "outputs"}) EXPECT_TRUE(r.contains(key)) << key;
    for (const char* key : {"counts", "accuracy", "estimate"}) EXPECT_FALSE(r.contains(key)) << key << " is not filled";
}

TEST(Report, OfAFailureIsWrittenToo)
{
    const Scratch scratch;
    const struct {
        Words words;
        int status;
        const char* said;
    } table[] = {{{"--act", "unconverged"}, 3, "residual 0.1"}, {{"--act", "input-error"}, 1, "no grid 'density'"},
                 {{"--density", "x"}, 2, "--density: 'x'"},     {{"--nonsense"}, 2, "unknown option"},
                 {{"--act", "cancelled"}, 130, "interrupted"},  {{"--act", "warn", "--werror"}, 1, "became 0"}};
    for (const auto& bad : table) {
        Words words = bad.words;
        words.insert(words.end(), {"-o", "/dev/null", "--json", scratch / "r.json"});
        EXPECT_EQ(echo(words).status, bad.status) << bad.said;
        const auto r = nlohmann::json::parse(read_text(scratch / "r.json"));
        EXPECT_EQ(r["exit_status"], bad.status);
        EXPECT_NE(r["error"].get<std::string>().find(bad.said), std::string::npos) << r["error"];
        EXPECT_EQ(scratch.list(), Words{"r.json"});
    }
}

TEST(Report, ThatCannotBeWrittenIsAnError)
{
    RunOptions full;
    full.stdout_to = "/dev/full";
    const RunResult out = echo({"-o", "/dev/null", "--json", "-"}, full);
    EXPECT_EQ(out.status, 1);
    EXPECT_NE(out.err.find("No space left"), std::string::npos) << out.err;
    EXPECT_EQ(echo({"-o", "/dev/null", "--json", "/dev/full"}).status, 1);
    const RunResult both = echo({"-o", "/dev/null", "--json", "/dev/full", "--act", "unconverged"});
    EXPECT_EQ(both.status, 3);
    EXPECT_EQ(std::count(both.err.begin(), both.err.end(), '\n'), 1) << both.err;
}

TEST(Report, OfTextThatIsNoUtf8IsStillJson)
{
    const auto r = report_of({"--note", "\xff\xfe"});
    EXPECT_TRUE(r["parameters"]["note"].is_string());
}

TEST(Run, LackOfMemoryIsOneSentence)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    RunOptions little;
    little.memory = uint64_t(1) << 30;
    const RunResult r = echo({"-o", "/dev/null", "--act", "huge"}, little);
    EXPECT_EQ(r.status, 1);
    EXPECT_NE(r.err.find("not enough memory"), std::string::npos) << r.err;
}

TEST(Run, MemoryThatEndsWhileAnExceptionLeavesIsSaidInASentence)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    RunOptions little;
    little.memory = uint64_t(1) << 29;
    const RunResult r = echo({"-o", "/dev/null", "--act", "hoard"}, little);
    EXPECT_EQ(r.status, 1);
    EXPECT_EQ(r.err, "echo_tool: not enough memory for this; a smaller grid, or a higher limit, would do\n");
}

}  // namespace
}  // namespace vdbcloud::test
