// What every program promises on its command line, on a program that does only what it is told.
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

RunResult echo(const Words& words, const RunOptions& options = {})
{
    Words command{program("echo_tool")};
    command.insert(command.end(), words.begin(), words.end());
    return run(command, options);
}

/// One line, the program's name first, and no control characters in it.
void expect_one_line(const std::string& text)
{
    EXPECT_EQ(text.rfind("echo_tool: ", 0), 0u) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    EXPECT_EQ(text.empty() ? '\0' : text.back(), '\n');
    EXPECT_LT(text.size(), 5000u);
    for (char c : text) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
}

struct Act {
    const char* act;
    int status;
    const char* said;
};

class Acts : public testing::TestWithParam<Act> {};

TEST_P(Acts, EndWithTheirStatusAndOneLine)
{
    if (sanitized && GetParam().act == std::string("huge")) GTEST_SKIP() << "a sanitizer refuses such sizes itself";
    const Scratch scratch;
    const RunResult r = echo({"-o", scratch / "out", "--act", GetParam().act});
    EXPECT_EQ(r.status, GetParam().status);
    EXPECT_NE(r.err.find(GetParam().said), std::string::npos) << r.err;
    if (r.status != 130) expect_one_line(r.err);
    EXPECT_EQ(scratch.list(), Words());
}

INSTANTIATE_TEST_SUITE_P(Contract, Acts,
                         testing::Values(Act{"input-error", 1, "w.vdb: no grid 'density'; it has: water"},
                                         Act{"io-error", 1, "x.vdb: cannot read it"},
                                         Act{"usage-error", 2, "--sun 0,1,0: the light was computed with 1,0,0"},
                                         Act{"unconverged", 3, "residual 0.1 after 7 iterations"},
                                         Act{"cancelled", 130, ""}, Act{"no-memory", 1, "not enough memory"},
                                         Act{"huge", 1, "not enough memory"}, Act{"int", 1, "internal error"},
                                         Act{"silent", 1, "exception without a message"},
                                         Act{"lines", 1, "first second ?[31mred xxx"},
                                         Act{"thread", 1, "internal error"}),
                         [](const auto& p) {
                             std::string name = p.param.act;
                             std::replace(name.begin(), name.end(), '-', '_');
                             return name;
                         });

TEST(Contract, DoneIsStatusZeroAndSilent)
{
    const Scratch scratch;
    const RunResult r = echo({"-o", scratch / "out"});
    EXPECT_EQ(r.status, 0);
    EXPECT_EQ(r.out + r.err, "");
    EXPECT_EQ(read_text(scratch / "out"), "done\n");
}

struct Wrong {
    Words words;
    const char* said;
};

TEST(Contract, AWrongCommandLineIsStatusTwoAndNamesTheExpectation)
{
    const Wrong table[] = {
        {{}, "the option --output is required"},
        {{"-o"}, "--output: expected a value"},
        {{"-o", "x", "--densty", "3"}, "unknown option '--densty'; did you mean '--density'?"},
        {{"-o", "x", "--qqqqqqqqq=3"}, "unknown option '--qqqqqqqqq'\n"},
        {{"-o", "x", "--sn", "1,2,3"}, "unknown option '--sn'\n"},
        {{"-o", "x", "--usn", "1,2,3"}, "unknown option '--usn'; did you mean '--sun'?"},
        {{"-o", "x", "--meth", "steps"}, "unknown option '--meth'; did you mean '--method'?"},
        {{"--outptu", "x"}, "unknown option '--outptu'; did you mean '--output'?"},
        {{"-o", "x", "--densty=3"}, "unknown option '--densty'; did you mean '--density'?"},
        {{"-o", "x", "in", "--densty", "3"}, "unknown option '--densty'; did you mean '--density'?"},
        {{"--denstiy", "3", "in", "-o", "x"}, "unknown option '--denstiy'; did you mean '--density'?"},
        {{"-o", "x", "in", "-k", "3"}, "unknown option '-k'; expected -o, -q, -v, -f or -h"},
        {{"-o", "x", "-density", "3"}, "unknown option '-density'; did you mean '--density'?"},
        {{"-output", "x"}, "unknown option '-output'; did you mean '--output'?"},
        {{"-o", "x", "in", "more"}, "unexpected argument 'more'"},
        {{"-o", "x", "in", "-3"}, "unexpected argument '-3'"},
        {{"-o", "x", "--density", "nan"}, "--density: 'nan': expected a finite number"},
        {{"-o", "x", "--density", "inf"}, "--density: 'inf': expected a finite number"},
        {{"-o", "x", "--density", "1.1e30"}, "--density: '1.1e30': expected numbers of a size up to 1e+30"},
        {{"-o", "x", "--density", "1e400"}, "--density: '1e400': expected a finite number"},
        {{"-o", "x", "--density", "0"}, "--density: '0': expected a finite number above 0"},
        {{"-o", "x", "--density", "-1"}, "--density: '-1': expected a finite number above 0"},
        {{"-o", "x", "--density", ""}, "--density: '': expected a finite number"},
        {{"-o", "x", "--density", " 1"}, "--density: ' 1': expected a finite number"},
        {{"-o", "x", "--density", "1x"}, "--density: '1x': expected a finite number"},
        {{"-o", "x", "--density", "1,2"}, "--density: '1,2'"},
        {{"-o", "x", "--density="}, "--density: expected a value after ="},
        {{"-o", "x", "--density", "1", "--density", "2"}, "--density: given more often than once"},
        {{"-o", "x", "--count", "4.5"}, "--count: '4.5': expected a whole number"},
        {{"-o", "x", "--count", "101"}, "--count: '101': expected a number in [0, 100]"},
        {{"-o", "x", "--count", "99999999999999999999"}, "--count: '99999999999999999999'"},
        {{"-o", "x", "--seed", "-1"}, "--seed: '-1': expected a whole number, 0 or above"},
        {{"-o", "x", "--seed", "18446744073709551616"},
         "--seed: '18446744073709551616': expected a smaller whole number"},
        {{"-o", "x", "--sun", "1,2"}, "--sun: '1,2': expected three finite numbers x,y,z"},
        {{"-o", "x", "--sun", "1,2,nan"}, "--sun: '1,2,nan'"},
        {{"-o", "x", "--sun", "1,2,3,4"}, "--sun: '1,2,3,4'"},
        {{"-o", "x", "--sun", "1,,3"}, "--sun: '1,,3'"},
        {{"-o", "x", "--albedo", "1,2"}, "--albedo: '1,2': expected one finite number, or three as r,g,b"},
        {{"-o", "x", "--albedo", "0.5,0.5,1.5"}, "--albedo: '0.5,0.5,1.5': expected a number in [0, 1]"},
        {{"-o", "x", "--method", "foo"}, "--method: 'foo': expected cells|steps"},
        {{"-o", "x", "--fast=maybe"}, "--fast: 'maybe': expected true or false"},
        {{"-o", "x", "--threads", "-1"}, "--threads: '-1': expected a number in [0, 4096]"},
        {{"-o", "-", "--json", "-"}, "--output - and --json - are the same file: expected a file for each"},
    };
    for (const Wrong& wrong : table) {
        const RunResult r = echo(wrong.words);
        EXPECT_EQ(r.status, 2) << wrong.said;
        EXPECT_EQ(r.out, "");
        EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err << "\nexpected: " << wrong.said;
        expect_one_line(r.err);
    }
}

TEST(Contract, WordsAreTakenInAnyCaseAndKeptInOne)
{
    for (const char* word : {"steps", "STEPS", "Steps"}) {
        const RunResult r = echo({"-o", "x", "--method", word, "--print-config"});
        EXPECT_EQ(r.status, 0) << r.err;
        EXPECT_NE(r.out.find("\nmethod = \"steps\"\n"), std::string::npos) << r.out;
    }
}

TEST(Contract, VectorsMayBeginWithAMinus)
{
    const RunResult r =
        echo({"-o", "-", "--sun", "-1,0,-2e-1", "--albedo", "0.5", "--lamp=-1,-2,-3", "--print-config"});
    EXPECT_EQ(r.status, 0) << r.err;
    EXPECT_NE(r.out.find("\nsun = [-1, 0, -0.2]\n"), std::string::npos) << r.out;
    EXPECT_NE(r.out.find("\nalbedo = 0.5\n"), std::string::npos) << r.out;
    EXPECT_NE(r.out.find("\nlamp = [[-1, -2, -3]]\n"), std::string::npos) << r.out;
}

TEST(Contract, AnUnwritableOutputIsRefusedBeforeTheWork)
{
    const Scratch scratch;
    write_text(scratch / "there", "old");
    const Words act{"--act", "unconverged"};  // status 3 if the work began
    for (const Words& words :
         {Words{"-o", scratch / "none/x"}, Words{"-o", scratch.path()}, Words{"-o", scratch / "there", "--no-clobber"},
          Words{"-o", "x", "--json", scratch / "no/j"}, Words{"-o", "x", "--json", scratch.path()},
          Words{"-o", scratch / "there/x"}}) {
        Words all = words;
        all.insert(all.end(), act.begin(), act.end());
        const RunResult r = echo(all);
        EXPECT_EQ(r.status, 1) << r.err;
        expect_one_line(r.err);
        EXPECT_NE(r.err.find(scratch.path()), std::string::npos) << r.err;
    }
    EXPECT_EQ(read_text(scratch / "there"), "old");
}

TEST(Contract, HelpAndVersionGoToStandardOutputAndNoticeAFullDisk)
{
    for (const char* word : {"--help", "-h", "--help-all", "--version", "--print-config"}) {
        const RunResult good = echo({word});
        EXPECT_EQ(good.status, 0) << word << good.err;
        EXPECT_EQ(good.err, "");
        EXPECT_GT(good.out.size(), 60u);
        RunOptions full;
        full.stdout_to = "/dev/full";
        const RunResult bad = echo({word}, full);
        EXPECT_EQ(bad.status, 1) << word;
        expect_one_line(bad.err);
    }
    const std::string version = echo({"--version"}).out;
    for (const char* part : {"echo_tool", "OpenVDB 10.", "file format 22", "blosc", "zip", "compiler"})
        EXPECT_NE(version.find(part), std::string::npos) << version;
}

/// Longest line of a text.
size_t widest(const std::string& text)
{
    size_t most = 0, from = 0;
    for (size_t end; (end = text.find('\n', from)) != std::string::npos; from = end + 1)
        most = std::max(most, end - from);
    return most;
}

TEST(Contract, HelpNamesEveryOptionWithItsRangeAndDefault)
{
    const std::string brief = echo({"--help"}).out, full = echo({"--help-all"}).out;
    for (const char* part : {"Usage: echo_tool [OPTIONS] [input] -o FILE", "--count N", "--name TEXT ...",
                             "(0..100; default 3)", "--method cells|steps", "(default cells)", "--threads"}) {
        EXPECT_NE(brief.find(part), std::string::npos) << part << "\n" << brief;
        EXPECT_NE(full.find(part), std::string::npos) << part;
    }
    EXPECT_NE(full.find("Exit status:"), std::string::npos);
    EXPECT_EQ(full.find("--completion"), std::string::npos);
    EXPECT_LE(widest(brief), 100u);
    EXPECT_LE(widest(full), 110u);
}

TEST(Contract, ShellsCompleteOptionsAndTheirWords)
{
    const Scratch scratch;
    write_text(scratch / "c", echo({"--completion", "bash"}).out);
    const auto complete = [&](const std::string& words) {
        return shell("source '" + (scratch / "c") + "'; COMP_WORDS=(echo_tool " + words +
                     "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _echo_tool; echo ${COMPREPLY[*]}")
            .out;
    };
    EXPECT_EQ(complete("--dens"), "--density\n");
    EXPECT_EQ(complete("--method s"), "steps\n");
    EXPECT_EQ(complete("--prog"), "--progress\n");
    EXPECT_EQ(complete("--density ''"), "\n");
    EXPECT_NE(echo({"--completion", "zsh"}).out.find("'*--method[how]:cells steps:(cells steps)'"), std::string::npos);
    EXPECT_NE(echo({"--completion", "fish"}).out.find("-l method -x -a 'cells steps' -d 'how'"), std::string::npos);
    EXPECT_EQ(echo({"--completion", "tcsh"}).status, 2);
}

TEST(Contract, QuietPrintsWarningsAlone)
{
    EXPECT_EQ(echo({"-o", "-", "--act", "say"}).err, "echo_tool: hello\n");
    EXPECT_EQ(echo({"-o", "-", "--act", "say", "-q"}).err, "");
    EXPECT_EQ(echo({"-o", "-", "--act", "warn", "-q"}).err, "echo_tool: warning: 2 negative values became 0\n");
}

TEST(Contract, WithWerrorAWarningEndsTheRun)
{
    const Scratch scratch;
    const RunResult r = echo({"-o", scratch / "out", "--act", "warn", "--werror"});
    EXPECT_EQ(r.status, 1);
    expect_one_line(r.err);
    EXPECT_NE(r.err.find("2 negative values became 0"), std::string::npos);
    EXPECT_EQ(scratch.list(), Words());
}

TEST(Contract, DryRunWritesNothing)
{
    const Scratch scratch;
    EXPECT_EQ(echo({"-o", scratch / "out", "--dry-run"}).status, 0);
    EXPECT_EQ(scratch.list(), Words());
}

TEST(Contract, HistoryGrowsByOneLineWithoutFolders)
{
    const Words words{"/home/someone/cloud.vdb",
                      "-o",
                      "/tmp/secret.vdb",
                      "--act",
                      "history",
                      "--threads",
                      "2",
                      "--dry-run",
                      "--note",
                      "old 1 a=2\nold 2 b=\"\033[31m\"",
                      "--density",
                      "0.1"};
    const std::string text = echo(words).out;
    EXPECT_EQ(text.rfind("old 1 a=2\nold 2 b=\"?[31m\"\necho_tool ", 0), 0u) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
    EXPECT_NE(text.find(" input=\"cloud.vdb\" "), std::string::npos) << text;
    EXPECT_NE(text.find(" density=0.1 "), std::string::npos) << text;
    EXPECT_NE(text.find(" sun=[0.3, 1, 0.2] "), std::string::npos) << text;
    for (const char* absent : {"someone", "secret", "threads", "/tmp"})
        EXPECT_EQ(text.find(absent), std::string::npos) << text;
}

TEST(Contract, AnOptionWithoutEffectIsRefusedWithTheOtherOptionAndTheWayOut)
{
    const Wrong table[] = {
        {{"--step", "2"}, "--step has no effect without --method steps: add --method steps, or leave out --step"},
        {{"--step", "1"}, "--step has no effect without --method steps"},  // its default, but it was given
        {{"--unit", "m"}, "--unit has no effect without --sun: add --sun, or leave out --unit"},
        {{"--no-haze", "--colour", "red"}, "--colour has no effect with --no-haze: leave out one of them"},
        {{"--width", "3", "--act", "narrow"}, "--width has no effect without --act wide"},
    };
    for (const Wrong& wrong : table) {
        Words words{"-o", "/dev/null"};
        words.insert(words.end(), wrong.words.begin(), wrong.words.end());
        const RunResult r = echo(words);
        EXPECT_EQ(r.status, 2) << wrong.said;
        EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err;
        expect_one_line(r.err);
    }
    const Scratch scratch;
    write_text(scratch / "c.toml", "note = \"x\"\nstep = 2\n");
    const RunResult filed = echo({"-o", "/dev/null", "--config", scratch / "c.toml"});
    EXPECT_EQ(filed.status, 2);
    EXPECT_NE(filed.err.find("c.toml: line 2: --step has no effect"), std::string::npos) << filed.err;
    write_text(scratch / "c.toml", "step = 1\n");  // as --print-config writes a default
    for (const Words& words :
         {Words{"--method", "steps", "--step", "2"}, Words{"--sun", "1,2,3", "--unit", "m"}, Words{"--colour", "red"},
          Words{"--act", "narrow"}, Words{"--width", "3"}, Words{"--config", scratch / "c.toml"}}) {
        Words all{"-o", "/dev/null"};
        all.insert(all.end(), words.begin(), words.end());
        EXPECT_EQ(echo(all).status, 0) << words.front();
    }
}

TEST(Contract, AHandleKnowsItsNameAndValue)
{
    EXPECT_EQ(echo({"-o", "/dev/null", "--act", "text", "--sun", "1,2,3"}).err,
              "echo_tool: --sun 1,2,3 --width 1 0.1\n");
    const RunResult r = echo({"-o", "/dev/null", "--act", "undeclared"});
    EXPECT_EQ(r.status, 1);
    EXPECT_NE(r.err.find("a handle of an option that was not declared"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace vdbcloud::test
