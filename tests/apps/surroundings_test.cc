// What a program finds around it when it starts: closed descriptors, little memory, no folder for temporary files. A
// failure of the system is never blamed on the input.
#include "apps/tools.h"

#include "support/size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud::test {
namespace {

const auto by_name = [](const auto& p) { return p.param.name; };

class Surroundings : public testing::TestWithParam<Tool> {
protected:
    const Tool& tool() const { return GetParam(); }
    std::string line(const std::string& output) const
    {
        std::string text;
        for (const std::string& word : tool().command(scratch / "cloud.vdb", output.empty() ? "" : scratch / output))
            text += "'" + word + "' ";
        return text;
    }
    void SetUp() override { make_lit_cloud(scratch / "cloud.vdb"); }
    Scratch scratch;
};
INSTANTIATE_TEST_SUITE_P(Tools, Surroundings, testing::ValuesIn(tools()), by_name);

TEST_P(Surroundings, ClosedDescriptorsChangeNoResult)
{
    const std::string name = tool().extension.empty() ? "" : "out" + tool().extension;
    const RunResult plain = shell(line(name) + "-q");
    ASSERT_EQ(plain.status, 0) << plain.err;
    const std::string expected = name.empty() ? "" : read_text(scratch / name);
    const bool slow = tool().name == "render" || tool().name == "cloudsim";  // start with 240 libraries
    for (const char* closed : {"<&- >&- 2>&-", "<&-", "2>&-", ">&-"}) {
        if (slow && !full_size() && closed != std::string("<&- >&- 2>&-")) break;
        const bool output = std::string(closed).find(" >&-") != std::string::npos || closed == std::string(">&-");
        const RunResult r = shell(line(name) + "-q " + closed);
        if (name.empty()) {  // the result is text on standard output
            EXPECT_EQ(r.status, output && tool().prints ? 1 : 0) << closed << "\n" << r.err;
            if (!output) {
                EXPECT_EQ(r.out, plain.out) << closed;
            }
            if (closed == std::string(">&-") && tool().prints) {
                EXPECT_NE(r.err.find("standard output"), std::string::npos) << closed << r.err;
            }
            continue;
        }
        EXPECT_EQ(r.status, 0) << closed << "\n" << r.err;
        EXPECT_TRUE(read_text(scratch / name) == expected) << closed;
    }
    if (name.empty()) return;
    for (const char* target : {"-o - -q >&-", "--json - -q >&-"}) {
        std::string command = line(std::string(target).rfind("-o", 0) == 0 ? "" : name) + target;
        const RunResult r = shell(command);
        EXPECT_EQ(r.status, 1) << r.err;
        EXPECT_NE(r.err.find(": standard output is closed"), std::string::npos) << r.err;
    }
    if (tool().reads) {
        const RunResult r = shell(tool().name == "render" ? "'" + program("render") + "' - -o x.exr <&-"
                                                          : "'" + program(tool().name) + "' - -o x.vdb <&-");
        EXPECT_EQ(r.status, 1);
        EXPECT_NE(r.err.find("it is closed"), std::string::npos) << r.err;
    }
}

TEST_P(Surroundings, WithoutEnoughMemoryTheSentenceBlamesTheMemory)
{
    if (sanitized) GTEST_SKIP() << "a sanitizer takes memory of its own";
    // From far too little (the libraries map some 100 MB before main) to plenty. The lowest steps must fail, the
    // highest succeed, and nothing but these two endings may occur: no signal, no other status, no blame for the input.
    const std::string name = tool().extension.empty() ? "" : "out" + tool().extension;
    const int steps = sized(5, 40);
    int failed = 0, done = 0;
    for (int k = 0; k < steps; ++k) {
        const double megabytes = 70 * std::pow(4000.0 / 70, k / double(steps - 1));
        const RunResult r =
            shell("ulimit -v " + std::to_string(int(megabytes * 1024)) + "; " + line(name) + "-q --threads 2");
        if (r.status == 127) {  // the loader itself found no room
            ++failed;
            continue;
        }
        EXPECT_TRUE(r.status == 0 || r.status == 1) << megabytes << " MB: " << r.status << "\n" << r.err;
        if (r.status == 0) {
            ++done;
            continue;
        }
        ++failed;
        EXPECT_NE(r.err.find("memory"), std::string::npos) << megabytes << " MB\n" << r.err;
        EXPECT_EQ(r.err.find("malformed"), std::string::npos) << megabytes << " MB\n" << r.err;
        EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
        EXPECT_EQ(scratch.list(), Words{"cloud.vdb"}) << megabytes;
    }
    EXPECT_GE(done, 1);
    EXPECT_GE(failed, 1);
}

TEST(ClosedDescriptors, NoMessageGoesIntoAFileThatIsOpen)
{
    // Without a standard error the log of frames would get its number, and the lines for people with it.
    const Scratch scratch;
    const RunResult r = shell("'" + program("cloudsim") + "' --preset smoke --cells 4 --minutes 0.2 --every 6s -o '" +
                              scratch / "a.vdb' --log '" + scratch / "log' 2>&-");
    ASSERT_EQ(r.status, 0);
    const std::string log = read_text(scratch / "log");
    EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), std::count(log.begin(), log.end(), '{'));
    EXPECT_GE(std::count(log.begin(), log.end(), '{'), 3);
    EXPECT_EQ(log.find("cloudsim: "), std::string::npos) << log;
}

/// A program with an input that ends nowhere or claims to be larger than it is: status 1 in little time and memory.
TEST(Bounds, NoInputIsReadWithoutABound)
{
    const Scratch scratch;
    // A PNG of 69 bytes with 100000 x 100000 pixels in its header, and an image of 3 x 2 that is good.
    const std::string head("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\x86\xa0\0\1\x86\xa0\x08\0\0\0\0", 29);
    write_text(scratch / "huge.png", head + std::string(40, '\0'));
    write_text(scratch / "huge.pgm", "P5\n16000 16000\n255\nabc");
    write_text(scratch / "good.pgm", "P5\n3 2\n255\nabcdef");
    const std::string cloudsim =
        "'" + program("cloudsim") + "' -q --preset smoke --cells 4 --minutes 0.1 -o '" + scratch / "a.vdb' ";
    const struct {
        std::string line;
        int status;
        const char* said;
    } table[] = {
        {cloudsim + "--sounding /dev/zero", 1, "has more than"},
        {cloudsim + "--init /dev/zero", 1, "not a .vdb"},
        {cloudsim + "--heat-flux 1 --floor-map /dev/zero", 1, "no regular file"},
        {cloudsim + "--heat-flux 1 --floor-map '" + scratch / "huge.png'", 1, "huge.png"},
        {cloudsim + "--heat-flux 1 --floor-map '" + scratch / "huge.pgm'", 1,
         "it claims 16000 x 16000 pixels in 22 bytes"},
        {cloudsim + "--heat-flux 1 --floor-map '" + scratch / "good.pgm'", 0, ""},
        {"'" + program("exrmerge") + "' /dev/zero -o '" + scratch / "a.exr'", 1, "no regular file"},
        {"'" + program("vdbimport") + "' /dev/zero --cell 1,1,1 -o '" + scratch / "a.vdb'", 1, "has more than"},
        {"'" + program("vdbprobe") + "' /dev/zero --grid a --at 0,0,0", 1, "not a .vdb"},
        {"'" + program("render") + "' /dev/zero -o '" + scratch / "a.exr'", 1, "not a .vdb"}};
    RunOptions limits;
    limits.memory = uint64_t(3) << 30;
    limits.seconds = 20;
    for (const auto& [line, status, said] : table) {
        const RunResult r = shell(line, limits);
        EXPECT_EQ(r.status, status) << line << "\n" << r.err;
        EXPECT_FALSE(r.timed_out) << line;
        EXPECT_NE(r.err.find(said), std::string::npos) << line << "\n" << r.err;
    }
}

}  // namespace
}  // namespace vdbcloud::test
