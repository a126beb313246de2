// Damaged files: whatever the bytes, a program ends in time with status 0, 1, 2 or 3, says why in one line, and leaves
// nothing behind.
#include "apps/tools.h"

#include "support/size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

namespace vdbcloud::test {
namespace {

using Random = std::mt19937_64;  // its numbers are the same everywhere, unlike the standard's distributions

size_t below(Random& random, size_t n) { return n ? random() % n : 0; }

/// Where to damage: mostly among headers and metadata, which lie first.
size_t place(Random& random, const std::string& bytes)
{
    const size_t head = std::min<size_t>(bytes.size(), 4096);
    return random() % 10 < 6 ? below(random, head) : below(random, bytes.size());
}

template<typename T>
void put(std::string& bytes, size_t at, T value)
{
    std::memcpy(bytes.data() + at, &value, std::min(sizeof value, bytes.size() - at));
}

std::string mutant(Random& random, const std::string& seed, const std::string& other)
{
    static const int64_t odd[] = {0,         1,        -1,         127,          255,          256,
                                  65535,     65536,    0x7fffffff, 0x80000000ll, 0xffffffffll, int64_t(1) << 40,
                                  INT64_MAX, INT64_MIN};
    static const float strange[] = {0.0f, -1.0f, 1e38f, -1e38f, 1e-40f, HUGE_VALF, -HUGE_VALF, NAN};
    std::string bytes = seed;
    const size_t at = place(random, bytes), length = 1 + below(random, 64);
    switch (random() % 12) {
    case 0: bytes[at] ^= char(1 << (random() % 8)); break;
    case 1:
        for (int k = 0; k < 8; ++k) bytes[place(random, bytes)] ^= char(1 << (random() % 8));
        break;
    case 2: bytes[at] = char(random()); break;
    case 3: bytes.resize(at); break;
    case 4: put(bytes, at, int32_t(odd[random() % std::size(odd)])); break;
    case 5: put(bytes, at, odd[random() % std::size(odd)]); break;
    case 6: put(bytes, at, strange[random() % std::size(strange)]); break;
    case 7: std::fill_n(bytes.begin() + long(at), std::min(length, bytes.size() - at), '\0'); break;
    case 8: bytes.insert(at, bytes.substr(at, length)); break;
    case 9: bytes.erase(at, length); break;
    case 10: bytes.insert(at, std::string(length, char(random()))); break;
    default: bytes = bytes.substr(0, at) + other.substr(std::min(at, other.size())); break;
    }
    return bytes;
}

class Mutants : public testing::TestWithParam<Tool> {};
INSTANTIATE_TEST_SUITE_P(Tools, Mutants, testing::ValuesIn(reading_tools()),
                         [](const auto& p) { return p.param.name; });

TEST_P(Mutants, EndInTimeWithOneLine)
{
    const Tool& tool = GetParam();
    const Scratch scratch;
    std::vector<std::string> seeds;
    for (const char* codec : {"blosc", "zip", "none"}) {
        make_lit_cloud(scratch / "seed.vdb", {"--compression", codec});
        seeds.push_back(read_text(scratch / "seed.vdb"));
        ASSERT_GT(seeds.back().size(), 1000u);
    }
    const int count = sized(300 / int(reading_tools().size()), 300);
    int refused = 0;
    for (int k = 0; k < count; ++k) {
        Random random(1984 + k);
        const std::string path = scratch / "seed.vdb", output = scratch / ("out" + tool.extension);
        write_text(path, mutant(random, seeds[k % 3], seeds[(k + 1) % 3]));
        Words command = tool.command(path, output);
        command.push_back("-q");
        RunOptions limits;
        limits.seconds = 60;
        limits.memory = uint64_t(8) << 30;
        const RunResult r = run(command, limits);
        const std::string what = tool.name + ", mutant " + std::to_string(k) + ": " + r.err.substr(0, 1000);
        EXPECT_FALSE(r.timed_out) << what;
        EXPECT_LE(r.status, 3) << what;
        if (!tool.prints || r.status != 0) {
            EXPECT_EQ(r.out, "") << what;
        }
        EXPECT_LT(r.err.size(), 5000u) << what;
        if (r.status != 0) {
            ++refused;
            const size_t last = r.err.rfind(tool.name + ": ");  // warnings may come before
            ASSERT_NE(last, std::string::npos) << what;
            EXPECT_EQ(r.err.find('\n', last), r.err.size() - 1) << what;
        }
        std::remove(output.c_str());
        EXPECT_EQ(scratch.list(), Words{"seed.vdb"}) << what;
    }
    EXPECT_GT(refused, count / 10);  // or nothing was damaged
    EXPECT_LT(refused, count);
}

}  // namespace
}  // namespace vdbcloud::test
