// --rung: what it sets, what beats it, and where its table is shown.
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <map>
#include <sstream>

namespace vdbcloud::test {
namespace {

using Words = std::vector<std::string>;

/// The lines of --print-config as `key = value`, without comments.
std::map<std::string, std::string> configured(const std::string& tool, Words words)
{
    words.insert(words.begin(), program(tool));
    words.push_back("--print-config");
    const RunResult r = run(words);
    EXPECT_EQ(r.status, 0) << r.err;
    std::map<std::string, std::string> all;
    std::istringstream lines(r.out);
    for (std::string line; std::getline(lines, line);)
        if (const size_t equals = line.find(" = "); line[0] != '#' && equals != std::string::npos)
            all[line.substr(0, equals)] = line.substr(equals + 3);
    return all;
}

std::string table_of(const std::string& tool)
{
    const std::string help = run({program(tool), "--help"}).out;
    const size_t begin = help.find("\nRungs:\n"), end = help.find("\nExamples:\n");
    EXPECT_LT(begin, end);
    return begin < end ? help.substr(begin + 8, end - begin - 8) : "";
}

TEST(Rungs, ADocumentAndTheHelpOfEachProgramShowOneTable)
{
    const std::string table = table_of("render");
    EXPECT_EQ(table_of("illuminate"), table);
    EXPECT_EQ(table_of("p1solve"), table);
    const std::string document = read_text(VDBCLOUD_SOURCE "/docs/rungs.md");
    EXPECT_NE(document.find("```\n" + table + "```\n"), std::string::npos) << table;
}

TEST(Rungs, TheTableIsWhatProgramsSet)
{
    // Each value of the table, in the program that it names.
    std::istringstream lines(table_of("render"));
    std::string line, word;
    std::getline(lines, line);
    int compared = 0;
    while (std::getline(lines, line) && line.find("--") != std::string::npos) {
        std::istringstream words(line);
        std::string tool, option, value;
        words >> tool >> option;
        for (int rung = 0; words >> value; ++rung) {
            if (value == "-" || value == "none") continue;
            std::string set = configured(tool, {"--rung", std::to_string(rung)})[option.substr(2)];
            set.erase(std::remove(set.begin(), set.end(), '"'), set.end());
            EXPECT_EQ(set, value) << tool << ' ' << option << " on rung " << rung;
            ++compared;
        }
    }
    EXPECT_GT(compared, 30);
}

TEST(Rungs, AnOptionThatIsGivenBeatsTheRung)
{
    auto p1 = configured("p1solve", {"--rung", "3", "--degree", "1"});
    EXPECT_EQ(p1["iterations"], "5");
    EXPECT_EQ(p1["directions"], "64");
    EXPECT_EQ(p1["degree"], "1");
    // What has no effect beside an option that is given keeps its own default.
    p1 = configured("p1solve", {"--rung", "3", "--iterations", "0"});
    EXPECT_EQ(p1["directions"], configured("p1solve", {})["directions"]);
    auto picture = configured("render", {"--rung", "5", "--integrator", "cells"});
    EXPECT_EQ(picture["integrator"], "\"cells\"");
    EXPECT_EQ(picture.count("gather"), 0u);
    // A target ends a run of light paths, so that no number of samples stands in its way.
    EXPECT_EQ(configured("render", {"--rung", "6", "--noise", "0.1"}).count("samples"), 0u);
    EXPECT_EQ(configured("render", {"--rung", "6"})["samples"], "256");
}

TEST(Rungs, AFileOfOptionsKeepsARungAndWhatBeatIt)
{
    const Scratch scratch;
    const std::string file = scratch / "c.toml";
    for (const Words& words : {Words{"--rung", "4"}, {"--rung", "3", "--iterations", "0"}, {"--rung", "2"}}) {
        Words printing = words;
        printing.insert(printing.begin(), program("p1solve"));
        printing.push_back("--print-config");
        const std::string printed = run(printing).out;
        write_text(file, printed);
        EXPECT_EQ(run({program("p1solve"), "--config", file, "--print-config"}).out, printed);
    }
    // A file of defaults gives nothing, so a rung of the command line sets them.
    write_text(file, run({program("p1solve"), "--print-config"}).out);
    EXPECT_EQ(configured("p1solve", {"--config", file, "--rung", "3"})["iterations"], "5");
    write_text(file, "iterations = 7\n");
    EXPECT_EQ(configured("p1solve", {"--config", file, "--rung", "3"})["iterations"], "7");
}

TEST(Rungs, WhatIsRefusedBesideARungNamesTheRung)
{
    const std::pair<Words, std::string> all[] = {
        {{"p1solve", "in.vdb", "--rung", "0"},
         "p1solve: --rung 0 (light scattered once) needs no p1solve: hand its input to render --rung 0, or take --rung "
         "1 to 5\n"},
        {{"p1solve", "in.vdb", "--rung", "6"},
         "p1solve: --rung 6 (whole light paths, without bias) needs no p1solve: hand its input to render --rung 6, or "
         "take --rung 1 to 5\n"},
        {{"p1solve", "in.vdb", "--rung", "1", "--degree", "3"},
         "p1solve: --degree has no effect without --iterations above 0: add --iterations above 0, or leave out "
         "--degree (--rung 1 sets --iterations 0)\n"},
        {{"p1solve", "in.vdb", "--rung", "2", "--solver", "relaxation"},
         "p1solve: --iterations with --solver relaxation: expected multigrid (--rung 2 sets --iterations 3 "
         "--directions 32 --degree 1)\n"},
        {{"render", "in.vdb", "--rung", "5", "--shadow-rays"},
         "render: --shadow-rays has no effect with --integrator path: leave out one of them (--rung 5 sets "
         "--integrator path --gather 4 --samples 64)\n"},
        {{"render", "in.vdb", "--rung", "7"}, "render: --rung: '7': expected a number in [0, 6]\n"}};
    for (auto [words, sentence] : all) {
        const std::string tool = words.front();
        words.front() = program(tool);
        words.insert(words.end(), {"-o", "/dev/null"});
        const RunResult r = run(words);
        EXPECT_EQ(r.status, 2) << r.err;
        EXPECT_EQ(r.err, sentence);
    }
}

TEST(Rungs, TheReportNamesTheRungAndTheFileHoldsItsSettings)
{
    const Scratch scratch;
    RunOptions there;
    there.folder = scratch.path();
    const RunResult r =
        shell("fractalgen -q --size 12 -o c.vdb && illuminate -q c.vdb --rung 2 --sun 0,1,0 --json i.json -o l.vdb && "
              "p1solve -q l.vdb --rung 2 --degree 2 --g 0.5 --json p.json -o s.vdb && "
              "illuminate -q c.vdb --rays-per-voxel 2 --sun 0,1,0 -o same.vdb && vdbdiff -q l.vdb same.vdb",
              there);
    ASSERT_EQ(r.status, 0) << r.err;
    const auto report = nlohmann::json::parse(read_text(scratch / "p.json"));
    EXPECT_EQ(report["rung"]["number"], 2);
    EXPECT_EQ(report["rung"]["name"], "P1 closed by three sweeps");
    EXPECT_EQ(report["rung"]["options"], nlohmann::json({"iterations", "directions"}));
    EXPECT_EQ(report["parameters"]["iterations"], 3);
    EXPECT_EQ(report["parameters"]["degree"], 2);
    EXPECT_EQ(nlohmann::json::parse(read_text(scratch / "i.json"))["parameters"]["rays-per-voxel"], 2);
}

}  // namespace
}  // namespace vdbcloud::test
