// The examples at the end of each program's help run as printed, one after the other, in an empty folder.
#include "apps/tools.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>

namespace vdbcloud::test {
namespace {

/// The commands after "Examples:", each below a line "  # purpose".
Words examples(const Tool& tool)
{
    std::istringstream help(run({program(tool.name), "--help"}).out);
    Words commands;
    bool within = false;
    for (std::string line; std::getline(help, line);) {
        if (within && line.rfind("  # ", 0) == 0)
            commands.emplace_back();
        else if (within)
            commands.back() += line + "\n";
        within = within || line == "Examples:";
    }
    return commands;
}

class Examples : public testing::TestWithParam<Tool> {};
INSTANTIATE_TEST_SUITE_P(Tools, Examples, testing::ValuesIn(tools()), [](const auto& p) { return p.param.name; });

TEST_P(Examples, OfTheHelpRunAsPrinted)
{
    const Scratch empty;
    const Words commands = examples(GetParam());
    EXPECT_EQ(commands.size(), 3u);
    RunOptions patient;
    patient.seconds = 300;
    patient.folder = empty.path();
    for (const std::string& command : commands) {
        EXPECT_NE(command.find(GetParam().name + " "), std::string::npos);
        const Words before = empty.list();
        const RunResult r = shell(command, patient);
        EXPECT_EQ(r.status, 0) << command << "\n" << r.err;
        if (command.find("-o ") != std::string::npos) {
            EXPECT_GT(empty.list().size(), before.size()) << command;
        }
    }
}

}  // namespace
}  // namespace vdbcloud::test
