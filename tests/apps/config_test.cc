// --config and --print-config: what is printed reproduces the run, and nothing mistyped passes.
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <random>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

RunResult echo(Words words)
{
    words.insert(words.begin(), program("echo_tool"));
    return run(words);
}

nlohmann::json parameters(Words words)
{
    words.insert(words.end(), {"-o", "/dev/null", "--json", "-"});
    const RunResult r = echo(words);
    EXPECT_EQ(r.status, 0) << r.err;
    return r.status == 0 ? nlohmann::json::parse(r.out)["parameters"] : nlohmann::json();
}

/// Runs with `words`, and with what --print-config says of them.
void expect_round_trip(const Words& words)
{
    const Scratch scratch;
    Words printing = words;
    printing.push_back("--print-config");
    const RunResult printed = echo(printing);
    ASSERT_EQ(printed.status, 0) << printed.err;
    write_text(scratch / "c.toml", printed.out);
    EXPECT_EQ(parameters(words), parameters({"--config", scratch / "c.toml"}));
    EXPECT_EQ(echo({"--config", scratch / "c.toml", "--print-config"}).out, printed.out);
}

TEST(Config, DefaultsRoundTrip) { expect_round_trip({}); }

TEST(Config, EveryKindOfOptionRoundTrips)
{
    expect_round_trip({"5",
                       "--density",
                       "0.1234567890123456789",
                       "--count",
                       "0",
                       "--seed",
                       "18446744073709551615",
                       "--sun",
                       "-1e-300,.5,+7",
                       "--albedo",
                       "0.1,0.2,0.3",
                       "--lamp",
                       "1,2,3",
                       "--lamp",
                       "-4,5,6",
                       "--width",
                       "1e-5",
                       "--width",
                       "3",
                       "--no-haze",
                       "--fast",
                       "--method",
                       "steps",
                       "--keep",
                       "none"});
}

TEST(Config, NumbersAreWrittenInOneWayAndBeyondTomlsIntegersInQuotes)
{
    const std::string text = echo({"--density", ".5", "--count", "+7", "--seed", "007", "--print-config"}).out;
    for (const char* line : {"\ndensity = 0.5\n", "\ncount = 7\n", "\nseed = 7\n"})
        EXPECT_NE(text.find(line), std::string::npos) << text;
    for (const char* number : {"100000.0", "1e5", "+1e+05"})
        EXPECT_NE(echo({"--density", number, "--print-config"}).out.find("\ndensity = 1e+05\n"), std::string::npos);
    const std::string large = echo({"--seed", "18446744073709551615", "--print-config"}).out;
    EXPECT_NE(large.find("\nseed = \"18446744073709551615\"\n"), std::string::npos) << large;
    for (const char* number : {"123456789012345680000", "1e300", "-0", "1e-320", "9007199254740993"})
        expect_round_trip({"--sun", std::string(number) + ",0,0"});
}

TEST(Config, ReadsAllFormsOfTomlAndAByteOrderMark)
{
    const Scratch scratch;
    write_text(scratch / "c.toml", "\xef\xbb\xbf"
                                   "count = 0x1_0\r\nnote = \"\"\"\na\\\n  b\"\"\"\ndensity = 1_000.5\n");
    const nlohmann::json all = parameters({"--config", scratch / "c.toml"});
    EXPECT_EQ(all["count"], 16);
    EXPECT_EQ(all["note"], "ab");
    EXPECT_EQ(all["density"], 1000.5);
}

TEST(Config, AFileWithoutAnEndIsRefused)
{
    RunOptions limits;
    limits.memory = uint64_t(3) << 30;
    limits.seconds = 20;
    for (const char* endless : {"/dev/zero", "/dev/urandom"}) {
        const RunResult r = run({program("echo_tool"), "-o", "/dev/null", "--config", endless}, limits);
        EXPECT_EQ(r.status, 1) << r.err;
        EXPECT_NE(r.err.find(endless + std::string(": has more than 1048576 bytes")), std::string::npos) << r.err;
    }
}

TEST(Config, OneOfSeveralRoundTrips) { expect_round_trip({"--lamp", "1,2,3", "--name", "alone", "--width", "7"}); }

TEST(Config, OddTextRoundTrips)
{
    Words words;
    for (const char* text :
         {"",          " ",    " a ",   "a#b", "a = b", "\"",           "'",          "\"'\\", "\\n",
          "a\nb\tc\r", "true", "false", "1e5", "-3",    ".5",           "0x10",       "007",   "[a]",
          "[1, 2]",    "{}",   "--x",   "a,b", "%%",    "\001\037\177", "Wölkchen ☁", "++",    "nan"})
        words.insert(words.end(), {"--name=" + std::string(text).append(text[0] ? "" : "x")});
    words.insert(words.end(), {"--note", "\\\"# x"});
    expect_round_trip(words);
}

TEST(Config, RandomTextRoundTrips)
{
    std::mt19937 random(1984);
    Words words;
    for (int k = 0; k < 300; ++k) {
        std::string text = "x";
        for (unsigned n = random() % 12; n > 0; --n) text += char(1 + random() % 127);
        words.insert(words.end(), {"--name", text.substr(random() % 2 && text.size() > 2 && text[1] != '-')});
    }
    expect_round_trip(words);
}

TEST(Config, TheCommandLineWins)
{
    const Scratch scratch;
    write_text(scratch / "c.toml",
               "density = 5\ncount = 4 # four\n\n# a comment\nfast = true\nlamp = [[0,1,2],\n [3,4,5],]\n");
    const nlohmann::json all = parameters({"--config", scratch / "c.toml", "--density", "6"});
    EXPECT_EQ(all["density"], 6);
    EXPECT_EQ(all["count"], 4);
    EXPECT_EQ(all["fast"], true);
    EXPECT_EQ(all["lamp"], (nlohmann::json{{0, 1, 2}, {3, 4, 5}}));
}

TEST(Config, AcceptsTheWaysTomlWritesAVector)
{
    const Scratch scratch;
    for (const char* line :
         {"sun = [1, 2.5, -3]", "sun = \"1,2.5,-3\"", "sun = '1,2.5,-3'", "\"sun\" = [ 1 , 2.5 , -3 , ]",
          "sun=[1,\n# odd\n2.5,\n-3]\n", "sun = \"1\\u002c2.5,-3\""}) {
        write_text(scratch / "c.toml", line);
        EXPECT_EQ(parameters({"--config", scratch / "c.toml"})["sun"], (nlohmann::json{1, 2.5, -3})) << line;
    }
    write_text(scratch / "c.toml", "lamp = [1, 2, 3]");
    EXPECT_EQ(parameters({"--config", scratch / "c.toml"})["lamp"], (nlohmann::json{{1, 2, 3}}));
}

TEST(Config, RefusesUnknownKeysWithFileLineAndKey)
{
    const struct {
        const char *text, *said;
    } table[] = {
        {"count = 1\ndensty = 2", "line 2: unknown key 'densty'; did you mean 'density'?"},
        {"zzz = 1\nyyy = 2", "line 1: unknown key 'zzz'"},  // the first in the file, not in the alphabet
        {"[section]\ncount = 1", "line 1: 'section' is a table: tables are not used here"},
        {"sun.x = 1", "line 1: 'sun' is a table"},
        {"count = 1\ncount = 2", "line 2: 'count' is set twice"},
        {"input = \"a\"\n\nthreads = 2", "line 3: 'threads' belongs on the command line"},
        {"config = \"x\"", "'config' belongs on the command line"},
        {"count", "line 1: key-value pair: encountered end-of-file; expected lines key = value, the value a number"},
        {"count =", "expected lines key = value, the value a number, true, false, \"text\" or a [list]"},
        {"count = 1 2", "expected a comment or whitespace, saw '2'"},
        {"count = nan", "line 1: 'count': expected a finite number; text goes between quotes"},
        {"density = 1e400", "'1e400' could not be interpreted"},
        {"note = open", "line 1: value: could not determine value type; expected"},
        {"note = \"open", "string: encountered end-of-file"},
        {"note = \"\\q\"", "unknown escape sequence"},
        {"note = \"\\ud800\"", "surrogates"},
        {"note = \"\xff\"", "line 1: Encountered invalid utf-8 sequence"},
        {"note = 1979-05-27", "'note': expected a number, true, false, \"text\" or a [list]"},
        {"width = [1, 2", "array: encountered end-of-file"},
        {"width = [1 2]", "expected comma or closing ']', saw '2'"},
        {"lamp = [[[1]]]", "'lamp': a list of lists of lists has no meaning here"},
        {"fast = 3", "'fast': expected true or false"},
        {"fast = [true, false]", "'fast': expected true or false"},
        {"density = -1", "line 1: --density: '-1': expected a finite number above 0"},
        {"sun = [1, 2]", "--sun: '1,2': expected three"},
        {"method = \"foo\"", "--method: 'foo': expected cells|steps"},
        {"density = [1, 2]", "--density: '1,2'"},
        {"= 3", "line 1: root table: expected keys"},
        {"\x1f\x8b binary", "line 1: Encountered invalid utf-8 sequence"},
    };
    const Scratch scratch;
    for (const auto& wrong : table) {
        write_text(scratch / "c.toml", wrong.text);
        const RunResult r = echo({"--config", scratch / "c.toml", "-o", "/dev/null"});
        EXPECT_EQ(r.status, 2) << wrong.text;
        EXPECT_NE(r.err.find(wrong.said), std::string::npos) << r.err << "expected: " << wrong.said;
        EXPECT_NE(r.err.find("c.toml: "), std::string::npos) << r.err;
        EXPECT_EQ(r.err.find('\n'), r.err.size() - 1) << r.err;
    }
}

TEST(Config, AFileThatCannotBeReadIsStatusOne)
{
    const Scratch scratch;
    for (const std::string& path : {scratch / "missing.toml", scratch.path()}) {
        const RunResult r = echo({"--config", path, "-o", "/dev/null"});
        EXPECT_EQ(r.status, 1);
        EXPECT_NE(r.err.find(path + ": "), std::string::npos) << r.err;
    }
}

TEST(Config, APrintedDefaultIsNotGiven)
{
    const Scratch scratch;
    const auto given = [&](Words words) {
        words.insert(words.end(), {"-o", "/dev/null", "--json", "-", "--act", "given"});
        return nlohmann::json::parse(echo(words).out)["counts"];
    };
    write_text(scratch / "c.toml", echo({"--print-config"}).out);
    EXPECT_EQ(given({"--config", scratch / "c.toml"}), (nlohmann::json{{"density", false}, {"sun", false}}));
    EXPECT_EQ(given({"--sun", "0.3,1,0.2"}), (nlohmann::json{{"density", false}, {"sun", true}}));
    write_text(scratch / "c.toml", "density = 2\n");
    EXPECT_EQ(given({"--config", scratch / "c.toml"}), (nlohmann::json{{"density", true}, {"sun", false}}));
}

TEST(Config, ArgumentsNeededMayComeFromTheFile)
{
    const Scratch scratch;
    write_text(scratch / "c.toml", "output = \"" + (scratch / "out") + "\"\n");
    EXPECT_EQ(echo({"--config", scratch / "c.toml"}).status, 0);
    EXPECT_EQ(read_text(scratch / "out"), "done\n");
}

}  // namespace
}  // namespace vdbcloud::test
