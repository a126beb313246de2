// Counts of events times unit costs, and the memory that the system leaves.
#include "vdbcloud/core/memory.h"
#include "vdbcloud/core/workload.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>
#include <vector>

namespace vdbcloud {
namespace {

TEST(Workload, EachRowOfTheTableHasANameACostAndAMeaning)
{
    std::set<std::string> names;
    EXPECT_GT(unit_costs().size(), 20u);
    for (const UnitCost& row : unit_costs()) {
        EXPECT_TRUE(names.insert(row.event).second) << row.event << " is there twice";
        EXPECT_GE(row.nanoseconds, 0) << row.event;
        EXPECT_LT(row.nanoseconds, 1e10) << row.event;
        EXPECT_GT(row.meaning.size(), 5u) << row.event;
    }
    EXPECT_FALSE(unit_cost_machine().empty());
}

TEST(Workload, SecondsAreTheSumOfCountsTimesCosts)
{
    const UnitCost &a = unit_costs()[0], &b = unit_costs()[1];
    Workload work, more;
    work.add(a.event, 3e9);
    work.add(a.event, 2e9);
    more.add(b.event, 4e9);
    work += more;
    EXPECT_NEAR(work.seconds(), 5 * a.nanoseconds + 4 * b.nanoseconds, 1e-9 * work.seconds());
    EXPECT_EQ(work.of(a.event), 5e9);
    EXPECT_EQ(work.of("no such event"), 0);
    EXPECT_EQ(Workload().seconds(), 0);
}

TEST(Workload, AnEventWithoutARowIsAFaultOfTheProgram)
{
    Workload work;
    EXPECT_THROW(work.add("no such event", 1), std::invalid_argument);
    work.add(unit_costs()[0].event, 0);
    EXPECT_TRUE(work.events().empty()) << "what does not occur is not listed";
}

TEST(Memory, HeldGrowsWithWhatIsTouched)
{
    // Pages of the array are resident once written; the allocator may add some of its own.
    constexpr size_t bytes = size_t(64) << 20;
    const double before = memory_held();
    ASSERT_GT(before, 1e6);
    const std::vector<char> array(bytes, 1);
    const double now = memory_held();
    EXPECT_NEAR(now - before, double(bytes), 0.1 * double(bytes)) << int(array[bytes / 2]);
    EXPECT_GE(most_memory_held(), 0.99 * now);
    const auto left = memory_left();
    ASSERT_TRUE(left);
    EXPECT_GT(left->bytes, 1e6);
    EXPECT_LT(left->bytes, 1e15);
    EXPECT_FALSE(left->limit.empty());
}

}  // namespace
}  // namespace vdbcloud
