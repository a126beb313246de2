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

TEST(Vdbimport, ADryRunRefusesWhatTheRunRefuses)
{
    const Scratch scratch;
    const std::string box = scratch / "box.txt", out = scratch / "out.vdb";
    const auto refused = [&](const std::string& row, const std::string& cell, const std::string& expected) {
        write_text(box, row + "\n");
        for (const char* dry : {"", "--dry-run"}) {
            std::vector<std::string> words{program("vdbimport"), box, "--boxes", "--cell", cell, "-o", out, "-q"};
            if (*dry) words.emplace_back(dry);
            const RunResult r = run(words);
            EXPECT_EQ(r.status, 1) << row << dry << r.err;
            EXPECT_NE(r.err.find(expected), std::string::npos) << row << dry << r.err;
        }
    };
    refused("0 0 0 2000 2000 2000 1", "1,1,1", "expected at most 2^28 voxels");
    refused("1e12 0 0 1.1e12 1 1 1", "1,1,1", "expected corners within 1e9 voxels");
}

TEST(Vdbimport, CellsThatNoGridHasAreRefused)
{
    const Scratch scratch;
    write_text(scratch / "box.txt", "0 0 0 1e-5 1e-5 1e-5 10\n");
    write_text(scratch / "depth.txt", "5 8\n");
    for (const std::string& input : {std::string("box.txt --boxes"), std::string("depth.txt")}) {
        RunOptions there;
        there.folder = scratch.path();
        const RunResult r = shell("vdbimport " + input + " --cell 1e-6,1e-6,1e-6 -o out.vdb", there);
        EXPECT_EQ(r.status, 1) << r.err;
        EXPECT_NE(r.err.find("voxels of 1e-06 x 1e-06 x 1e-06: expected a volume of"), std::string::npos) << r.err;
    }
}

}  // namespace
}  // namespace vdbcloud::test
