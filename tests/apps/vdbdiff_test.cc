// vdbdiff as a Makefile sees it: its status, and its report.
#include "support/grids.h"
#include "support/run.h"

#include "vdbcloud/file/io.h"

#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using namespace test;

class Vdbdiff : public testing::Test {
protected:
    void SetUp() override
    {
        const auto grid = ball("density"), other = ball("density");
        write_grid_file(folder_ / "a.vdb", file_of({grid}));
        other->tree().setValue(openvdb::Coord(1, 2, 3), grid->tree().getValue(openvdb::Coord(1, 2, 3)) + 0.125f);
        write_grid_file(folder_ / "b.vdb", file_of({other, ball("heat")}));
        write_text(folder_ / "broken.vdb", read_text(folder_ / "a.vdb").substr(0, 1000));
    }

    RunResult diff(std::vector<std::string> words, const RunOptions& options = {})
    {
        words.insert(words.begin(), program("vdbdiff"));
        return run(words, options);
    }

    Scratch folder_;
};

TEST_F(Vdbdiff, StatusIs0Within3Beyond1Unreadable2Usage)
{
    const std::string a = folder_ / "a.vdb", b = folder_ / "b.vdb";
    EXPECT_EQ(diff({a, a}).status, 0);
    const auto differing = diff({a, b, "--grid", "density"});
    EXPECT_EQ(differing.status, 3);
    EXPECT_NE(differing.err.find("largest difference 0.125 at [1, 2, 3]"), std::string::npos) << differing.err;
    EXPECT_EQ(diff({a, b, "--grid", "density", "--max", "0.125"}).status, 0);
    EXPECT_EQ(diff({a, b, "--grid", "density", "--max", "0.124"}).status, 3);
    EXPECT_EQ(diff({a, b, "--grid", "density", "--rms", "0.01"}).status, 0);
    EXPECT_EQ(diff({a, b, "--grid", "density", "--relative", "1e-6"}).status, 3);
    EXPECT_EQ(diff({a, b, "--max", "1"}).status, 3) << "heat is in one file alone";
    EXPECT_EQ(diff({a, folder_ / "missing.vdb"}).status, 1);
    EXPECT_EQ(diff({a, folder_ / "broken.vdb"}).status, 1);
    EXPECT_EQ(diff({a, b, "--grid", "nothing"}).status, 1);
    EXPECT_EQ(diff({a}).status, 2);
    EXPECT_EQ(diff({a, b, "--max", "-1"}).status, 2);
    EXPECT_EQ(diff({"-", "-"}).status, 2);
}

TEST_F(Vdbdiff, ReadsAPipeAndReports)
{
    RunOptions options;
    options.input = read_text(folder_ / "a.vdb");
    const auto result = diff({"-", folder_ / "b.vdb", "--json", "-"}, options);
    EXPECT_EQ(result.status, 3);
    const auto report = nlohmann::json::parse(result.out);
    EXPECT_EQ(report["exit_status"], 3);
    EXPECT_EQ(report["difference"]["grids"][0]["name"], "density");
    EXPECT_EQ(report["difference"]["grids"][0]["max"], 0.125);
    EXPECT_EQ(report["difference"]["only_b"][0], "heat");
    EXPECT_EQ(report["beyond"].size(), 2u);
}

}  // namespace
}  // namespace vdbcloud
