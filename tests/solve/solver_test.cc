// The solver on problems whose answer is known: applied naively, manufactured, or constant by construction.
#include "vdbcloud/solve/relaxation.h"

#include "problems.h"
#include "support/size.h"
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/fractal/noise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace vdbcloud {
namespace {

using test::constant;
using test::Field;
using test::field;
using test::masked;
using test::noise;
using test::Problem;

/// Solves for x = 1, b = A 1 = extra. Returns what happened and the largest error.
struct Outcome {
    SolveResult solve;
    double error;
};
Outcome solve_for_one(const Blocks& blocks, const Problem& problem, double tolerance = 1e-6)
{
    Multigrid multigrid(problem.stencil);
    std::vector<double> b(problem.stencil.extra.begin(), problem.stencil.extra.end()), x;
    SolveOptions options;
    options.tolerance = tolerance;
    Outcome outcome{conjugate_gradient(problem.stencil, multigrid, b, x, options), 0};
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) outcome.error = std::max(outcome.error, std::abs(x[slot] - 1));
    return outcome;
}

TEST(Stencil, AppliesItsDefinition)
{
    const auto blocks = masked(Vec3i(24, 16, 24), [](const Vec3i& p) { return noise(1, p) < 0.7; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.1 + noise(2, p); }, 0.3, constant(0.01));
    const auto x = field(blocks, [](const Vec3i& p) { return noise(3, p); });
    std::vector<double> y(blocks.slots(), 0.0);
    const double xy = apply(problem.stencil, x, y);
    double expected_xy = 0;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) continue;
        double expected = problem.stencil.extra[slot] * x[slot];
        for (int face = 0; face < 6; ++face) {
            const size_t to = blocks.neighbour(slot, face);
            const double c = problem.stencil.face[face / 2][face % 2 ? slot : to];
            if (blocks.active(to)) expected += c * (x[slot] - x[to]);
        }
        EXPECT_NEAR(y[slot], expected, 1e-12);
        expected_xy += expected * x[slot];
    }
    EXPECT_NEAR(xy, expected_xy, 1e-9);
}

/// Largest error of -laplace u + u = f with u = cos(pi x) cos(2 pi y) cos(pi z) on the unit cube, no flux through its
/// walls.
double manufactured_error(int n)
{
    const auto blocks = box_blocks(Vec3i(n, n, n));
    const double h = 1.0 / n;
    const auto u = [&](const Vec3i& p) {
        return std::cos(pi * (p.x() + 0.5) * h) * std::cos(2 * pi * (p.y() + 0.5) * h) *
               std::cos(pi * (p.z() + 0.5) * h);
    };
    const Problem problem(blocks, constant(1), 0, constant(h * h));
    Multigrid multigrid(problem.stencil);
    auto b = field(blocks, [&](const Vec3i& p) { return (6 * pi * pi + 1) * u(p) * h * h; });
    std::vector<double> x;
    SolveOptions options;
    options.tolerance = 1e-9;
    EXPECT_TRUE(conjugate_gradient(problem.stencil, multigrid, b, x, options).converged);
    const auto exact = field(blocks, u);
    double error = 0;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) error = std::max(error, std::abs(x[slot] - exact[slot]));
    return error;
}

TEST(ConjugateGradient, ConvergesAtSecondOrderToAManufacturedSolution)
{
    const double coarse = manufactured_error(16), fine = manufactured_error(32);
    EXPECT_LT(fine, 0.02);
    EXPECT_GT(std::log2(coarse / fine), 1.9);
}

TEST(ConjugateGradient, TakesTenIterationsAtMostOnABallOfAnySize)
{
    int fewest = 1000, most = 0;
    for (int n : {16, 32, 64}) {
        const auto ball = masked(Vec3i(n, n, n), [n](const Vec3i& p) {
            return (Vec3d(p.x(), p.y(), p.z()) - Vec3d((n - 1) / 2.0)).length() < n / 2.0;
        });
        const Problem problem(ball, constant(16.0 / n), 0.5, constant(1e-4));
        const auto outcome = solve_for_one(ball, problem);
        EXPECT_TRUE(outcome.solve.converged);
        EXPECT_LT(outcome.error, 1e-5);
        fewest = std::min(fewest, outcome.solve.iterations);
        most = std::max(most, outcome.solve.iterations);
    }
    EXPECT_LE(most, 10);
    EXPECT_LE(most, 1.5 * fewest + 1);
}

TEST(ConjugateGradient, TakesSixteenIterationsAtMostOnCloudsOfAnySize)
{
    // Resistances in proportion to a fractal density that falls to 0 at its edges as the distance cubed.
    int fewest = 1000, most = 0;
    for (int n : {64, test::full_size() ? 160 : 96}) {
        Spectrum spectrum;
        spectrum.seed = 5;
        spectrum.beta = 4.2;
        const auto noise_field = synthesize(Vec3i(n, n, n), Vec3d(1), spectrum);
        const auto density = [&](const Vec3i& p) {
            return std::pow(std::clamp(3 * (double(noise_field(p.x(), p.y(), p.z())) - 0.3), 0.0, 1.0), 3);
        };
        const auto cloud = masked(Vec3i(n, n, n), [&](const Vec3i& p) { return density(p) > 0; });
        const Problem problem(
            cloud, [&](const Vec3i& p) { return n / (60 * std::max(1e-10, density(p))); }, 0.5, constant(1e-4));
        Multigrid multigrid(problem.stencil);
        auto b = field(cloud, density);
        std::vector<double> x;
        const auto solve = conjugate_gradient(problem.stencil, multigrid, b, x);
        EXPECT_TRUE(solve.converged) << n;
        EXPECT_LT(solve.error, 1e-6) << n;
        fewest = std::min(fewest, solve.iterations);
        most = std::max(most, solve.iterations);
        const auto sizes = multigrid.sizes();  // every level is a third of the one before, or less
        for (size_t level = 1; level < sizes.size(); ++level)
            EXPECT_LT(3 * sizes[level], sizes[level - 1]) << n << ' ' << level;
    }
    EXPECT_LE(most, 16);
    EXPECT_LE(most, 1.5 * fewest);
}

TEST(ConjugateGradient, SolvesAcrossJumpsOfAMillionInThirtyIterations)
{
    const int n = 32;
    const auto blocks = box_blocks(Vec3i(n, n, n));
    const std::pair<const char*, Field> cases[] = {
        {"layers", [](const Vec3i& p) { return p.y() / 3 % 2 ? 3e4 : 0.03; }},
        {"inclusion", [](const Vec3i& p) { return (p - Vec3i(16, 16, 16)).length() < 9 ? 0.03 : 3e4; }},
        {"hole", [](const Vec3i& p) { return (p - Vec3i(16, 16, 16)).length() < 9 ? 3e4 : 0.03; }},
        {"salt and pepper", [](const Vec3i& p) { return noise(5, p) < 0.5 ? 3e4 : 0.03; }},
    };
    for (const auto& [name, k] : cases) {
        const auto outcome = solve_for_one(blocks, Problem(blocks, k, 0.5, constant(0)));
        EXPECT_TRUE(outcome.solve.converged) << name << ' ' << outcome.solve.residual;
        EXPECT_LT(outcome.error, 1e-4) << name;
        EXPECT_LT(outcome.solve.iterations, 30) << name;
    }
}

TEST(ConjugateGradient, FindsAConstantWhereCoefficientsAreABillionTimesTheBoundary)
{
    const auto blocks = box_blocks(Vec3i(24, 24, 24));
    const auto outcome = solve_for_one(blocks, Problem(blocks, constant(1e8), 0.5, constant(0)));
    EXPECT_TRUE(outcome.solve.converged);
    EXPECT_LT(outcome.error, 1e-6);
}

TEST(ConjugateGradient, SolvesASingularProblemWithMeanZero)
{
    const auto blocks = masked(Vec3i(16, 16, 16), [](const Vec3i& p) { return p.x() < 13 && p.y() < 11; });
    const Problem problem(blocks, constant(1), 0, constant(0));
    Multigrid multigrid(problem.stencil);
    auto b = field(blocks, [](const Vec3i& p) { return p.x() - 6.0; });
    std::vector<double> x;
    const auto result = conjugate_gradient(problem.stencil, multigrid, b, x);
    EXPECT_TRUE(result.converged);
    EXPECT_NEAR(sum(blocks, x.data()), 0, 1e-6);
    // -u'' = x - 6 along x alone, no flux at the ends: the difference across a face is the sum of b below it.
    for (int i = 0; i < 12; ++i) {
        const double below = (i + 1) * (i / 2.0 - 6);
        for (int j : {0, 7, 8, 10})
            EXPECT_NEAR(x[blocks.slot(Vec3i(i, j, 3))] - x[blocks.slot(Vec3i(i + 1, j, 3))], below, 1e-4) << i;
    }
}

TEST(ConjugateGradient, SolvesEigenvectorsOnPeriodicAxesOfThreeBlocks)
{
    const int n = 24;
    const double c = 0.2;
    const auto blocks = box_blocks(Vec3i(n, 16, 8), {true, false, true});
    const Problem problem(blocks, constant(1), 0, constant(c));
    Multigrid multigrid(problem.stencil);
    // An eigenvector: eigenvalue 2 - 2 cos(2 pi / n) + c.
    const double eigenvalue = 2 - 2 * std::cos(2 * pi / n) + problem.stencil.extra[0];
    auto b = field(blocks, [&](const Vec3i& p) { return std::sin(2 * pi * p.x() / n + 0.3); });
    const auto exact = b;
    std::vector<double> x;
    const auto result = conjugate_gradient(problem.stencil, multigrid, b, x);
    EXPECT_TRUE(result.converged);
    EXPECT_LT(result.iterations, 20);
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) EXPECT_NEAR(x[slot], exact[slot] / eigenvalue, 1e-4);
}

TEST(ConjugateGradient, HasEqualBitsForOneAndThreeThreads)
{
    const auto blocks = masked(Vec3i(48, 48, 48),
                               [](const Vec3i& p) { return noise(9, Vec3i(p.x() / 5, p.y() / 5, p.z() / 5)) < 0.6; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return std::pow(10.0, 2 * noise(4, p)); }, 0.5, constant(1e-3));
    const auto solve = [&](int threads) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
        Multigrid multigrid(problem.stencil);
        auto b = field(blocks, [](const Vec3i& p) { return noise(8, p); });
        std::vector<double> x;
        EXPECT_TRUE(conjugate_gradient(problem.stencil, multigrid, b, x).converged);
        return x;
    };
    EXPECT_EQ(solve(1), solve(3));
}

TEST(Relaxation, AgreesWithConjugateGradients)
{
    const auto blocks = masked(Vec3i(16, 16, 16), [](const Vec3i& p) { return noise(2, p) < 0.8; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.2 + noise(4, p); }, 0.3, constant(0.01));
    SolveOptions options;
    options.tolerance = 1e-8;
    options.max_iterations = 2000;
    Multigrid multigrid(problem.stencil);
    auto b = field(blocks, [](const Vec3i& p) { return noise(8, p); });
    auto b2 = b;
    std::vector<double> x, y;
    EXPECT_TRUE(conjugate_gradient(problem.stencil, multigrid, b, x, options).converged);
    const auto result = relax(problem.stencil, 1.7, b2, y, options);
    EXPECT_TRUE(result.converged);
    EXPECT_GT(result.iterations, 20);
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) EXPECT_NEAR(x[slot], y[slot], 1e-5);
}

TEST(ConjugateGradient, ReportsThatItHasNotConverged)
{
    const auto blocks = box_blocks(Vec3i(32, 32, 32));
    const Problem problem(blocks, constant(1), 0.1, constant(0));
    Multigrid multigrid(problem.stencil);
    auto b = field(blocks, [](const Vec3i& p) { return noise(6, p); });
    std::vector<double> x;
    SolveOptions options;
    options.max_iterations = 2;
    const auto result = conjugate_gradient(problem.stencil, multigrid, b, x, options);
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.iterations, 2);
    EXPECT_EQ(result.history.size(), 3u);
}

TEST(ConjugateGradient, ThrowsCancelledWhenProgressReturnsFalse)
{
    const auto blocks = box_blocks(Vec3i(16, 16, 16));
    const Problem problem(blocks, constant(1), 0.1, constant(0));
    Multigrid multigrid(problem.stencil);
    auto b = field(blocks, constant(1));
    std::vector<double> x;
    SolveOptions options;
    options.progress = [](double) { return false; };
    EXPECT_THROW(conjugate_gradient(problem.stencil, multigrid, b, x, options), Cancelled);
}

}  // namespace
}  // namespace vdbcloud
