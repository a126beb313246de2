// Tables of numbers as text.
#include "vdbcloud/file/table.h"

#include "support/run.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

namespace vdbcloud::test {
namespace {

class Tables : public testing::Test {
protected:
    Table read(const std::string& text, uint64_t most = 1000)
    {
        write_text(scratch / "table.txt", text);
        return read_table(scratch / "table.txt", most);
    }
    std::string refusal(const std::string& text, uint64_t most = 1000)
    {
        try {
            read(text, most);
        } catch (const std::exception& e) {
            const std::string what = e.what();
            return what.substr(what.find("table.txt") + 9);
        }
        return "read";
    }
    Scratch scratch;
};

TEST_F(Tables, HoldRowsOfNumbers)
{
    const Table t = read("# depths\n  0.000   1.5 -2\r\n\n! more\n3,+4.25e1;\t5");
    EXPECT_EQ(t.rows, 2u);
    EXPECT_EQ(t.columns, 3u);
    EXPECT_EQ(t.values, (std::vector<double>{0, 1.5, -2, 3, 42.5, 5}));
    EXPECT_EQ(t.at(1, 2), 5);
    EXPECT_EQ(read("\xef\xbb\xbf"
                   "1 2")
                  .values,
              (std::vector<double>{1, 2}))
        << "a byte order mark";
}

TEST_F(Tables, HoldNumbersThatGridsHold)
{
    EXPECT_EQ(read("1e30 -1e30").values, (std::vector<double>{1e30, -1e30}));
    EXPECT_EQ(refusal("1 1.1e30"), ": line 1: '1.1e30': expected a number of a size up to 1e+30");
    EXPECT_EQ(refusal("-1e39"), ": line 1: '-1e39': expected a number of a size up to 1e+30");
}

TEST_F(Tables, AreRefusedInASentence)
{
    EXPECT_EQ(refusal("1 2\n3\n"), ": line 2: 1 numbers: expected 2, as in the first row");
    EXPECT_EQ(refusal("1 2\n3 4x\n"), ": line 2: '4x': expected a finite number");
    for (const char* word : {"nan", "inf", "1e400", "0x10", "--1", "."})
        EXPECT_EQ(refusal(word), std::string(": line 1: '") + word + "': expected a finite number");
    EXPECT_EQ(refusal("# nothing\n\n"), ": holds no numbers: expected rows of numbers");
    EXPECT_EQ(refusal(std::string(400, '1') + "\n" + std::string(400, '2')).find(": line 1: '1111"), 0u);
    EXPECT_EQ(refusal("1 2 3\n4 5 6\n", 8), ": has more than 8 bytes: expected a smaller table");
    EXPECT_EQ(refusal(std::string("1 \0 2", 5)).substr(0, 9), ": line 1:");
    EXPECT_THROW(read_table("/dev/zero", 1 << 20), IoError) << "a line without end";
    EXPECT_THROW(read_table(scratch / "none.txt"), IoError);
    EXPECT_THROW(read_table(scratch.path()), IoError) << "a folder";
}

}  // namespace
}  // namespace vdbcloud::test
