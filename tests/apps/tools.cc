#include "apps/tools.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace vdbcloud::test {

namespace {

template<typename F>
std::vector<Tool> only(F keep)
{
    std::vector<Tool> kept;
    for (const Tool& tool : tools())
        if (keep(tool)) kept.push_back(tool);
    return kept;
}

}  // namespace

Words Tool::command(const std::string& input, const std::string& output) const
{
    Words words{program(name)};
    words.insert(words.end(), quick.begin(), quick.end());
    if (reads) words.push_back(input);
    if (twice) words.push_back(input);
    if (!output.empty() && !extension.empty()) words.insert(words.end(), {"-o", output});
    return words;
}

std::vector<Tool> tools()
{
    const std::vector<Tool> all = {
        {"fractalgen", {"--size", "12"}, ".vdb", false},
        {"cloudsim", {"--preset", "smoke", "--cells", "8", "--minutes", "0.2"}, ".vdb", false},
        {"vdbimport", {VDBCLOUD_SOURCE "/data/tables/step_cloud.txt", "--cell", "15.625,15.625,250"}, ".vdb", false},
        {"illuminate", {}, ".vdb", true, false, true},
        {"p1solve", {}, ".vdb", true, false, true},
        {"render", {"--resolution", "16"}, ".exr", true, false, true},
        {"vdbdiff", {}, "", true, true},
        {"vdbprobe", {"--grid", "density", "--at", "0,0,0"}, "", true, false, false, true},
    };
    std::vector<Tool> built;
    for (const Tool& tool : all)
        if (std::filesystem::exists(program(tool.name))) built.push_back(tool);
    return built;
}

std::vector<Tool> reading_tools()
{
    return only([](const Tool& tool) { return tool.reads; });
}

std::vector<Tool> writing_tools()
{
    return only([](const Tool& tool) { return !tool.extension.empty(); });
}

RunResult expect_refused(const Tool& tool, const Words& command, int status)
{
    const RunResult r = run(command);
    std::string line;
    for (const std::string& word : command) line += word + " ";
    EXPECT_EQ(r.status, status) << line << "\n" << r.err;
    EXPECT_EQ(r.out, "") << line;
    EXPECT_EQ(r.err.rfind(tool.name + ": ", 0), 0u) << line << "\n" << r.err;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << line << "\n" << r.err;
    return r;
}

void make_lit_cloud(const std::string& path, const Words& fractalgen_options)
{
    std::string line = "fractalgen -q --size 12 -o -";
    for (const std::string& word : fractalgen_options) line += " " + word;
    const RunResult r = shell(line + " | illuminate -q --sun 0.3,1,0.2 - -o '" + path + "'");
    ASSERT_EQ(r.status, 0) << r.err;
}

}  // namespace vdbcloud::test
