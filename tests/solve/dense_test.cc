// Small dense systems.
#include "vdbcloud/solve/dense.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

TEST(Dense, ASemidefiniteFactorHoldsDependentUnknownsAtZero)
{
    // Rows 1 and 3 are equal: of the two unknowns with the pivot 2, one carries the sum.
    const std::vector<double> a{2, 0, 2, 0, 3, 0, 2, 0, 2};
    const std::vector<double> x = SemidefiniteFactor(a, 3, 1e-10).solve({4, 6, 4});
    EXPECT_NEAR(x[0] + x[2], 2, 1e-12);
    EXPECT_NEAR(x[0] * x[2], 0, 1e-12);
    EXPECT_NEAR(x[1], 2, 1e-12);
}

TEST(Dense, NoUnknownsHaveNoValues)
{
    EXPECT_TRUE(SemidefiniteFactor({}, 0, 1e-10).solve({}).empty());
    EXPECT_TRUE(solve_dense({}, {}).empty());
}

TEST(Dense, ARegularMatrixMayNeedRowsExchanged)
{
    const std::vector<double> x = solve_dense({0, 2, 1, 1}, {6, 5});
    EXPECT_NEAR(x[0], 2, 1e-12);
    EXPECT_NEAR(x[1], 3, 1e-12);
}

}  // namespace
}  // namespace vdbcloud
