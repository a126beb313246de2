// What every program promises on its command line, on a program that does only what it is told.
#include "support/run.h"

#include <gtest/gtest.h>

namespace vdbcloud::test {
namespace {
TEST(Contract, Starts) { EXPECT_EQ(run({program("echo_tool"), "-o", "-"}).status, 0); }
}  // namespace
}  // namespace vdbcloud::test
