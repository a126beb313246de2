// vdbimport's estimate of memory, for tables whose voxels fill little of the blocks that hold them.
#include "support/run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace vdbcloud::test {
namespace {

nlohmann::json report_of(std::vector<std::string> words)
{
    words.insert(words.begin(), program("vdbimport"));
    words.insert(words.end(), {"-q", "--json", "-"});
    const RunResult r = run(words);
    EXPECT_EQ(r.status, 0) << r.err;
    return nlohmann::json::parse(r.out);
}

/// Memory of a run beyond that of its dry run: said over taken. Pages and the system's own tables make up the rest, a
/// few MB of the 80 to 200 that these tables take.
void expect_estimate(const std::vector<std::string>& words)
{
    std::vector<std::string> dry = words;
    dry.emplace_back("--dry-run");
    const nlohmann::json said = report_of(dry), taken = report_of(words);
    const double held = said["peak_memory_bytes"], peak = taken["peak_memory_bytes"],
                 estimate = said["estimate"]["memory_bytes"];
    EXPECT_GT(peak - held, 4e7) << "too small a case";
    EXPECT_NEAR((estimate - held) / (peak - held), 1, 0.15) << estimate << " of " << peak;
}

TEST(Vdbimport, EstimatesATallColumn)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    const Scratch scratch;
    write_text(scratch / "depth.txt", "5 0\n0 0\n");
    write_text(scratch / "thickness.txt", "250000.5 1e9\n1e9 1e9\n");
    expect_estimate({scratch / "depth.txt", "--thickness", scratch / "thickness.txt", "--cell", "1,1,1", "-o",
                     scratch / "out.vdb"});
}

TEST(Vdbimport, EstimatesASection)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    const Scratch scratch;
    std::string layers;
    for (int k = 0; k < 120000; ++k) layers += "1\n";
    write_text(scratch / "section.txt", layers);
    expect_estimate({scratch / "section.txt", "--across", "2", "--cell", "1,1,1", "-o", scratch / "out.vdb"});
}

TEST(Vdbimport, EstimatesSheetsOfBoxes)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    const Scratch scratch;
    for (const char* emission : {"", " 0.25"}) {
        write_text(scratch / "boxes.txt", std::string("1 2 3 1501 4 1403 0.5") + emission + "\n");
        expect_estimate({scratch / "boxes.txt", "--boxes", "--cell", "1,2,1", "-o", scratch / "out.vdb"});
    }
}

}  // namespace
}  // namespace vdbcloud::test
