// Every program as a user meets it: help, wrong command lines, inputs and outputs that cannot be, configuration.
#include "apps/tools.h"

#include "support/size.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <sstream>

namespace vdbcloud::test {
namespace {

const auto by_name = [](const auto& p) { return p.param.name; };

class EveryTool : public testing::TestWithParam<Tool> {
protected:
    const Tool& tool() const { return GetParam(); }

    /// A file every program can read, made when first asked for.
    std::string cloud()
    {
        const std::string path = scratch / "cloud.vdb";
        if (read_text(path).empty()) make_lit_cloud(path);
        return path;
    }
    std::string out(const std::string& stem) const { return scratch / (stem + tool().extension); }

    Scratch scratch;
};
class ReadingTool : public EveryTool {};
class WritingTool : public EveryTool {};

INSTANTIATE_TEST_SUITE_P(Tools, EveryTool, testing::ValuesIn(tools()), by_name);
INSTANTIATE_TEST_SUITE_P(Tools, ReadingTool, testing::ValuesIn(reading_tools()), by_name);
INSTANTIATE_TEST_SUITE_P(Tools, WritingTool, testing::ValuesIn(writing_tools()), by_name);

TEST_P(EveryTool, HelpReadsWell)
{
    for (const char* option : {"--help", "--help-all"}) {
        const RunResult r = run({program(tool().name), option});
        EXPECT_EQ(r.status, 0);
        EXPECT_EQ(r.err, "");
        EXPECT_EQ(r.out.rfind(tool().name + ": ", 0), 0u) << r.out;
        EXPECT_NE(r.out.find("\nUsage: " + tool().name + " [OPTIONS]"), std::string::npos) << r.out;
        std::istringstream lines(r.out);
        for (std::string line; std::getline(lines, line);) {
            EXPECT_LE(line.size(), 110u) << line;
            EXPECT_EQ(line.find(" []"), std::string::npos) << line;
            EXPECT_EQ(line.find("default )"), std::string::npos) << line;
        }
    }
}

TEST_P(EveryTool, EveryOptionIsExplained)
{
    std::istringstream lines(run({program(tool().name), "--help-all"}).out);
    std::string line, next;
    for (std::getline(lines, line); std::getline(lines, next); line = next) {
        if (line == "Files:") break;
        if (line.rfind("  -", 0) != 0) continue;
        const bool below = next.rfind(std::string(30, ' '), 0) == 0;
        EXPECT_TRUE(below || (line.size() > 31 && line.find("  ", 4) != std::string::npos)) << line;
    }
}

TEST_P(EveryTool, VersionNamesTheToolAndItsLibraries)
{
    const RunResult r = run({program(tool().name), "--version"});
    EXPECT_EQ(r.status, 0);
    EXPECT_EQ(r.out.rfind(tool().name + " (vdbcloud) ", 0), 0u) << r.out;
    EXPECT_NE(r.out.find("OpenVDB"), std::string::npos);
}

TEST_P(EveryTool, WrongCommandLinesAreStatusTwo)
{
    const Words good = tool().command("none.vdb", out("out"));
    const auto with = [&](const Words& more) {
        Words words = good;
        words.insert(words.end(), more.begin(), more.end());
        return words;
    };
    expect_refused(tool(), with({"--no-such-option"}), 2);
    expect_refused(tool(), with({"--threads", "x"}), 2);
    expect_refused(tool(), with({"--json"}), 2);
    if (!tool().several) expect_refused(tool(), with({"one", "too", "many"}), 2);
    if (!tool().extension.empty()) expect_refused(tool(), tool().command("none.vdb", ""), 2);
    if (tool().reads) expect_refused(tool(), {program(tool().name), "-o", out("out")}, 2);
    EXPECT_EQ(scratch.list(), Words());
}

TEST_P(EveryTool, AnUnknownOptionIsNamedWithTheNearestKnownOne)
{
    const Words good = tool().command("none.vdb", out("out"));
    const auto refused = [&](const Words& wrong) {
        std::string all;
        for (const size_t at : {size_t(1), good.size()}) {  // first and last on the line
            Words words = good;
            words.insert(words.begin() + long(at), wrong.begin(), wrong.end());
            all += expect_refused(tool(), words, 2).err;
        }
        return all;
    };
    const std::string nearest = tool().name + ": unknown option '--thraeds'; did you mean '--threads'?\n";
    EXPECT_EQ(refused({"--thraeds", "3"}), nearest + nearest);
    EXPECT_EQ(refused({"--thraeds=3"}), nearest + nearest);
    const std::string one_letter = refused({"-k", "3"});
    EXPECT_NE(one_letter.find(": unknown option '-k'; expected "), std::string::npos) << one_letter;
    EXPECT_NE(one_letter.find("-q"), std::string::npos) << one_letter;
    const std::string one_dash = refused({"-threads", "3"});
    EXPECT_NE(one_dash.find(": unknown option '-threads'; did you mean '--threads'?"), std::string::npos) << one_dash;
}

/// Options whose value is a number, from --help-all.
Words number_options(const Tool& tool)
{
    Words names;
    std::istringstream lines(run({program(tool.name), "--help-all"}).out);
    for (std::string line; std::getline(lines, line);) {
        const size_t dashes = line.find("--");
        if (line.rfind("  -", 0) != 0 || dashes == std::string::npos) continue;
        std::istringstream words(line.substr(dashes));
        std::string name, kind;
        words >> name >> kind;
        for (const char* numeric : {"NUMBER", "N", "X,Y,Z", "R,G,B", "FLOAT", "INT", "UINT"})
            if (kind == numeric) names.push_back(name);
    }
    return names;
}

TEST_P(EveryTool, NoNumberMayBeAnythingElse)
{
    const Words options = number_options(tool());
    EXPECT_GE(options.size(), 2u);
    const Words bad{"nan", "1e400", "", "inf", "-inf", "1x"};
    for (size_t k = 0; k < options.size() * bad.size(); ++k) {
        const std::string &option = options[k / bad.size()], &value = bad[k % bad.size()];
        if (!full_size() && k % bad.size() != k / bad.size() % bad.size()) continue;  // CI size: one value an option
        const RunResult r = expect_refused(tool(), {program(tool().name), option, value}, 2);
        EXPECT_NE(r.err.find(option + ": '" + value + "'"), std::string::npos) << r.err;
        EXPECT_LT(r.err.size(), 300u) << r.err;
    }
}

TEST_P(EveryTool, APrintedConfigurationReproducesTheRun)
{
    Words command = tool().command(cloud(), out("a"));
    ASSERT_EQ(run(command).status, 0);
    command.push_back("--print-config");
    const RunResult printed = run(command);
    ASSERT_EQ(printed.status, 0) << printed.err;
    write_text(scratch / "c.toml", printed.out);
    Words again{program(tool().name), "--config", scratch / "c.toml"};
    if (!tool().extension.empty()) again.insert(again.end(), {"-o", out("b")});
    const RunResult second = run(again);
    EXPECT_EQ(second.status, 0) << second.err << printed.out;
    if (tool().extension == ".exr") {
        EXPECT_EQ(read_text(out("a")), read_text(out("b")));
    } else if (tool().extension == ".vdb") {
        const RunResult same = run({program("vdbdiff"), "--metadata", out("a"), out("b")});
        EXPECT_EQ(same.status, 0) << same.err;
    }
}

TEST_P(EveryTool, UnknownKeysAreRefusedByName)
{
    write_text(scratch / "c.toml", "no-such-key = 1\n");
    Words command = tool().command(cloud(), out("out"));
    command.insert(command.end(), {"--config", scratch / "c.toml"});
    EXPECT_NE(expect_refused(tool(), command, 2).err.find("'no-such-key'"), std::string::npos);
}

TEST_P(EveryTool, TheReportOfASuccessHasItsParts)
{
    Words command = tool().command(cloud(), out("out"));
    command.insert(command.end(), {"--json", scratch / "r.json", "-q"});
    const RunResult r = run(command);
    EXPECT_EQ(r.status, 0) << r.err;
    const auto report = nlohmann::json::parse(read_text(scratch / "r.json"));
    EXPECT_EQ(report["schema"], 1);
    EXPECT_EQ(report["tool"], tool().name);
    EXPECT_EQ(report["exit_status"], 0);
    EXPECT_FALSE(report.contains("error"));
    EXPECT_EQ(report["inputs"].size(), size_t(tool().reads) + tool().twice);
    EXPECT_GE(report["phases"].size(), 1u);
    EXPECT_GT(report["peak_memory_bytes"].get<double>(), 1e6);
    EXPECT_TRUE(report["parameters"].is_object());
    for (const auto& [key, value] : report.items()) EXPECT_FALSE(value.is_object() && value.empty()) << key;
}

TEST_P(EveryTool, ADryRunEstimatesAndWritesNothing)
{
    Words command = tool().command(cloud(), out("out"));
    command.insert(command.end(), {"--dry-run", "--json", "-"});
    const RunResult r = run(command);
    ASSERT_EQ(r.status, 0) << r.err;
    const auto report = nlohmann::json::parse(r.out);
    if (!tool().extension.empty()) {
        const auto estimate = report.value("estimate", nlohmann::json::object());
        EXPECT_GT(estimate.value("memory_bytes", 0.0), 0) << r.out;
        EXPECT_GT(estimate.value("seconds", 0.0), 0) << r.out;
    }
    EXPECT_EQ(scratch.list(), Words{"cloud.vdb"});
}

TEST_P(ReadingTool, InputsThatCannotBeReadAreStatusOneWithTheirPath)
{
    const std::string whole = read_text(cloud());
    ASSERT_GT(whole.size(), 2000u);
    write_text(scratch / "half.vdb", whole.substr(0, whole.size() / 2));
    write_text(scratch / "head.vdb", whole.substr(0, 40));
    write_text(scratch / "empty.vdb", "");
    write_text(scratch / "text.vdb", "This is no volume.\n");
    const Words before = scratch.list();
    for (const std::string& bad : {scratch / "none.vdb", scratch.path(), scratch / "half.vdb", scratch / "head.vdb",
                                   scratch / "empty.vdb", scratch / "text.vdb"}) {
        const RunResult r = expect_refused(tool(), tool().command(bad, out("out")), 1);
        EXPECT_NE(r.err.find(bad), std::string::npos) << r.err;
    }
    EXPECT_EQ(scratch.list(), before);
}

TEST_P(ReadingTool, ADensityThatIsNoNumberIsStatusOneWithItsCoordinate)
{
    if (tool().extension.empty()) GTEST_SKIP() << "compares or prints whatever is there";
    write_density_with_nan(scratch / "nan.vdb", {1, 2, 3});
    const RunResult r = expect_refused(tool(), tool().command(scratch / "nan.vdb", out("out")), 1);
    EXPECT_NE(r.err.find("density"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("1, 2, 3"), std::string::npos) << r.err;
    EXPECT_EQ(scratch.list(), Words{"nan.vdb"});
}

TEST_P(WritingTool, OutputsThatCannotBeWrittenAreStatusOne)
{
    const std::string input = cloud();
    const auto quietly = [&](const std::string& output) {
        Words words = tool().command(input, output);
        words.push_back("-q");
        return words;
    };
    for (const std::string& bad : {scratch / ("none/out" + tool().extension), scratch.path()})
        EXPECT_NE(expect_refused(tool(), quietly(bad), 1).err.find(bad), std::string::npos);
    if (tool().extension == ".vdb") expect_refused(tool(), quietly("/dev/full"), 1);
    RunOptions full;
    full.stdout_to = "/dev/full";
    if (tool().extension == ".vdb") {
        EXPECT_EQ(run(quietly("-"), full).status, 1);
    }
    EXPECT_EQ(scratch.list(), Words{"cloud.vdb"});
}

TEST_P(WritingTool, BinaryDataIsNotWrittenToATerminal)
{
    RunOptions terminal;
    terminal.terminal = true;
    const RunResult r = run(tool().command(cloud(), "-"), terminal);
    EXPECT_EQ(r.status, 2) << r.out;
    EXPECT_LT(r.out.size(), 300u);
}

TEST_P(WritingTool, AFileThatIsThereStaysWithNoClobber)
{
    write_text(out("out"), "mine");
    Words command = tool().command(cloud(), out("out"));
    command.push_back("--no-clobber");
    expect_refused(tool(), command, 1);
    EXPECT_EQ(read_text(out("out")), "mine");
}

TEST_P(WritingTool, ThreadsDoNotChangeTheResult)
{
    for (const char* threads : {"1", "2"}) {
        Words command = tool().command(cloud(), out(threads));
        command.insert(command.end(), {"--threads", threads});
        ASSERT_EQ(run(command).status, 0);
    }
    if (tool().extension == ".exr") {
        EXPECT_EQ(read_text(out("1")), read_text(out("2")));
    } else {
        EXPECT_EQ(run({program("vdbdiff"), "--metadata", out("1"), out("2")}).status, 0);
    }
}

}  // namespace
}  // namespace vdbcloud::test
