// Where conjugate gradients start, against the projection onto the fields.
#include "problems.h"
#include "vdbcloud/solve/guess.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vdbcloud {
namespace {

using namespace test;
using Vector = std::vector<double>;

std::vector<float> floats(const Vector& v) { return {v.begin(), v.end()}; }

TEST(Guess, LeavesAnErrorWithoutAPartAlongAnyField)
{
    const auto blocks = masked(Vec3i(24, 16, 24), [](const Vec3i& p) { return noise(1, p) < 0.8; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.1 + noise(2, p); }, 0.3, constant(0.01));
    const Vector b = field(blocks, [](const Vec3i& p) { return noise(3, p); });
    const Vector start = field(blocks, [](const Vec3i& p) { return noise(4, p); });
    const auto first = floats(field(blocks, [](const Vec3i& p) { return noise(5, p) - 0.4; }));
    const auto second = floats(field(blocks, [](const Vec3i& p) { return std::sin(0.3 * p.x()); }));
    for (const bool has_start : {false, true}) {
        Vector x = has_start ? start : Vector(), image(blocks.slots(), 0.0);
        improve_guess(problem.stencil, b, {&first, &second}, x);
        apply(problem.stencil, x, image);
        const auto along = [&](const auto& v) {
            double sum = 0, whole = 0;
            for (size_t slot = 0; slot < b.size(); ++slot) {
                sum += v[slot] * (b[slot] - image[slot]);
                whole += std::abs(v[slot] * b[slot]);
            }
            return sum / whole;
        };
        EXPECT_NEAR(along(first), 0, 1e-12) << has_start;
        EXPECT_NEAR(along(second), 0, 1e-12) << has_start;
        if (!has_start) continue;
        EXPECT_NEAR(along(start), 0, 1e-12);
    }
}

TEST(Guess, TakesAFieldThatAddsNothingOnceAndNoneBeyondDouble)
{
    const auto blocks = masked(Vec3i(16), [](const Vec3i& p) { return noise(1, p) < 0.8; });
    const Problem problem(blocks, constant(1), 0.3, constant(0.01));
    const Vector b = field(blocks, constant(1));
    const auto one = floats(field(blocks, [](const Vec3i& p) { return noise(5, p); }));
    Vector alone, twice;
    improve_guess(problem.stencil, b, {&one}, alone);
    improve_guess(problem.stencil, b, {&one, &one}, twice);
    for (size_t slot = 0; slot < b.size(); ++slot) ASSERT_NEAR(twice[slot], alone[slot], 1e-9);
    Vector x(blocks.slots(), 0.0);
    x[0] = std::numeric_limits<double>::infinity();
    const Vector before = x;
    improve_guess(problem.stencil, b, {&one}, x);
    EXPECT_EQ(x, before);
}

}  // namespace
}  // namespace vdbcloud
