// Smoothers, transfers, the cycle, conjugate gradients and the relaxation, each against its definition in double
// precision.
#include "graphs.h"
#include "problems.h"
#include "vdbcloud/solve/aggregation.h"
#include "vdbcloud/solve/finest_level.h"
#include "vdbcloud/solve/graph_level.h"
#include "vdbcloud/solve/relaxation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using namespace test;

/// The error polynomial of the smoother, p(A) = 1 - 2 M + 4/5 M^2 with M = D^-1 A: Chebyshev's of the fourth kind and
/// degree 2 on [0, 2], p(l) = W_2(1 - l) / 5, W_2(x) = 4 x^2 + 2 x - 1.
Vector smoothed_error(const Operator& jacobi_scaled, const Vector& error)
{
    const Vector once = jacobi_scaled(error), twice = jacobi_scaled(once);
    Vector out(error.size());
    for (size_t i = 0; i < out.size(); ++i) out[i] = error[i] - 2 * once[i] + 0.8 * twice[i];
    return out;
}

Operator jacobi_scaled(const Graph& a)
{
    return [&a](const Vector& x) {
        Vector y = product(a, x);
        for (size_t i = 0; i < y.size(); ++i) y[i] /= a.linked(i) + a.extra[i];
        return y;
    };
}

Operator jacobi_scaled(const Stencil& a)
{
    return [&a](const Vector& x) {
        const Blocks& blocks = *a.blocks;
        Vector y(x.size(), 0.0);
        apply(a, x, y);
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            double diagonal = a.extra[slot];
            for (int face = 0; face < 6 && blocks.active(slot); ++face)
                diagonal += a.face[face / 2][face % 2 ? slot : blocks.neighbour(slot, face)];
            y[slot] = diagonal > 0 ? y[slot] / diagonal : 0;
        }
        return y;
    };
}

/// The first values of a vector that may be longer.
void put(const Vector& from, std::vector<float>& to) { std::copy(from.begin(), from.end(), to.begin()); }

TEST(GraphLevel, AddsTheGroupsCorrectionAndSmoothsWithTheChebyshevPolynomialOfTheFourthKind)
{
    const Graph graph = random_graph(401, 1, 0.1);  // the last batch of eight rows has one
    GraphLevel level(graph);
    ASSERT_EQ(level.size(), graph.size());
    const Vector u = random_vector(graph.size(), 6), b = product(graph, u);
    put(b, level.b);
    std::vector<int32_t> group;
    const size_t groups = grouped(graph, group).size();
    ASSERT_EQ(level.make_groups(graph).size(), groups);
    ASSERT_GT(groups, 10u);
    ASSERT_LT(3 * groups, graph.size());
    // The coarse right-hand side is the residual of 0, summed over groups.
    std::vector<float> coarse_b(groups), correction(groups);
    level.descend(coarse_b);
    Vector sums(groups, 0.0), error = u;
    for (size_t g = 0; g < groups; ++g) correction[g] = float(0.1 * uniform(hash_bits(11, g)));
    for (size_t i = 0; i < u.size(); ++i) {
        if (group[i] < 0) continue;
        sums[size_t(group[i])] += b[i];
        error[i] -= correction[size_t(group[i])];
    }
    for (size_t g = 0; g < groups; ++g) EXPECT_NEAR(coarse_b[g], sums[g], 1e-5);
    level.ascend(correction);
    const Vector after = smoothed_error(jacobi_scaled(graph), error);
    for (size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(level.x[i], u[i] - after[i], 1e-6);
    // Without a coarser level: the polynomial twice, from 0.
    level.smooth_alone();
    const Vector twice = smoothed_error(jacobi_scaled(graph), smoothed_error(jacobi_scaled(graph), u));
    for (size_t i = 0; i < u.size(); ++i) EXPECT_NEAR(level.x[i], u[i] - twice[i], 1e-6);
}

TEST(GraphLevel, KeepsTheProductsOfTheKrylovSteps)
{
    const Graph graph = random_graph(1301, 1, 0.1);  // more than two ranges of batches, the last of which is not full
    GraphLevel level(graph);
    const Vector b = random_vector(graph.size(), 8), x = random_vector(graph.size(), 9), ax = product(graph, x),
                 image = random_vector(graph.size(), 10);
    put(b, level.b);
    put(x, level.x);
    put(image, level.image);
    double x_ax = 0, x_b = 0, b_b = 0, x_image = 0, left = 0;
    for (size_t i = 0; i < x.size(); ++i) {
        x_ax += x[i] * ax[i];
        x_b += x[i] * b[i];
        b_b += b[i] * b[i];
        x_image += x[i] * image[i];
        left += std::pow(b[i] - 0.5 * image[i], 2);
    }
    const auto sums = level.apply(level.other);
    EXPECT_NEAR(sums.x_ax, x_ax, 1e-5 * x_ax);
    EXPECT_NEAR(sums.x_b, x_b, 1e-5 * b_b);
    EXPECT_NEAR(sums.b_b, b_b, 1e-5 * b_b);
    EXPECT_NEAR(sums.x_image, x_image, 1e-5 * b_b);
    for (size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(level.other[i], ax[i], 1e-5);
    EXPECT_NEAR(level.advance(0.5f), left, 1e-5 * left);
    level.search.assign(level.search.size(), 2.0f);
    level.scale(3, 0.5f);
    for (size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(level.x[i], 6 + 0.5 * x[i], 1e-5);
    level.scale(3, 0);
    for (size_t i = 0; i < x.size(); ++i) EXPECT_EQ(level.x[i], 6);
}

TEST(FinestLevel, SmoothsWithTheChebyshevPolynomialAndSumsTheResidualOverGroups)
{
    const auto blocks = masked(Vec3i(24, 16, 24), [](const Vec3i& p) { return noise(1, p) < 0.8; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.1 + noise(2, p); }, 0.02, constant(0.001));
    const Stencil& a = problem.stencil;
    const Vector u = field(blocks, [](const Vec3i& p) { return noise(3, p) - 0.5; });
    Vector b(blocks.slots(), 0.0), residual(blocks.slots(), 0.0);
    apply(a, u, b);
    FinestLevel level(a);
    level.make_fields();
    std::vector<float> coarse_b(level.groups().count(), -7.0f);
    level.descend(b, coarse_b);
    const Vector left = smoothed_error(jacobi_scaled(a), u);
    apply(a, left, residual);
    Vector sums(coarse_b.size(), 0.0);
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) continue;
        ASSERT_NEAR(level.x()[slot], u[slot] - left[slot], 1e-6);
        if (level.groups()(slot) >= 0) sums[size_t(level.groups()(slot))] += residual[slot];
    }
    for (size_t g = 0; g < sums.size(); ++g) ASSERT_NEAR(coarse_b[g], sums[g], 1e-5);
    // Each group its own correction, then the same polynomial.
    std::vector<float> correction(coarse_b.size());
    for (size_t g = 0; g < correction.size(); ++g) correction[g] = float(0.1 * uniform(hash_bits(11, g)));
    const double x_b = level.ascend(b, correction);
    Vector error = left;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot) && level.groups()(slot) >= 0) error[slot] -= correction[size_t(level.groups()(slot))];
    const Vector after = smoothed_error(jacobi_scaled(a), error);
    double zr = 0;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) continue;
        ASSERT_NEAR(level.x()[slot], u[slot] - after[slot], 1e-6);
        zr += (u[slot] - after[slot]) * b[slot];
    }
    EXPECT_NEAR(x_b, zr, 1e-5 * std::abs(zr));
}

TEST(Multigrid, ReducesTheErrorToAThirdInOneCycle)
{
    // z approximates A^-1 r: after one cycle the error u - z in the energy norm, for smooth and for rough u.
    const int n = 32;
    const auto ball = masked(Vec3i(n), [](const Vec3i& p) {
        return (Vec3d(p.x(), p.y(), p.z()) - Vec3d((n - 1) / 2.0)).length() < n / 2.0;
    });
    const Problem problem(ball, constant(16.0 / n), 0.5, constant(1e-4));
    for (int rough : {0, 1}) {
        const Vector u = field(ball, [&](const Vec3i& p) { return rough ? noise(3, p) - 0.5 : std::cos(0.1 * p.x()); });
        Vector r(ball.slots(), 0.0), image(ball.slots(), 0.0), left = u;
        const double before = apply(problem.stencil, u, r);
        Multigrid multigrid(problem.stencil);
        const double z_r = multigrid.cycle(r);
        double zr = 0;
        for (size_t slot = 0; slot < ball.count() * 512; ++slot) {
            if (!ball.active(slot)) continue;
            zr += multigrid.z()[slot] * r[slot];
            left[slot] -= multigrid.z()[slot];
        }
        EXPECT_NEAR(z_r, zr, 1e-6 * zr);
        const double after = apply(problem.stencil, left, image);
        EXPECT_LT(std::sqrt(after / before), 1.0 / 3) << rough;
    }
}

TEST(Multigrid, TakesTheHierarchyOfALesserExtra)
{
    // The links of a hierarchy do not depend on extra: with more absorption, the same in one place and much more in
    // another, it is about as good as one of its own, and with none it is its own.
    const auto blocks = masked(Vec3i(40, 40, 32), [](const Vec3i& p) { return noise(1, p) < 0.85; });
    const auto k = [](const Vec3i& p) { return std::pow(10.0, 2 * noise(4, p)); };
    const auto absorbs = [](double by) { return [by](const Vec3i& p) { return 1e-3 + by * noise(6, p); }; };
    const Problem first(blocks, k, 0.5, absorbs(0));
    const Multigrid hierarchy(first.stencil);
    for (const double by : {0.0, 0.05, 5.0}) {
        const Problem problem(blocks, k, 0.5, absorbs(by));
        const Vector u = field(blocks, [](const Vec3i& p) { return std::sin(0.2 * p.x()) + noise(7, p); });
        Vector b(blocks.slots(), 0.0);
        apply(problem.stencil, u, b);
        Multigrid own(problem.stencil), taken(problem.stencil, hierarchy);
        EXPECT_LT(taken.bytes(), own.bytes() / 2);
        Vector rest = b, x, x_own;
        SolveOptions options;
        options.tolerance = 1e-9;
        const auto result = conjugate_gradient(problem.stencil, taken, rest, x, options);
        rest = b;
        const auto of_own = conjugate_gradient(problem.stencil, own, rest, x_own, options);
        EXPECT_TRUE(result.converged);
        EXPECT_LE(result.iterations, of_own.iterations + (by > 0 ? 2 : 0)) << by;
        for (size_t slot = 0; slot < x.size(); ++slot) ASSERT_NEAR(x[slot], u[slot], 1e-6) << by;
    }
}

TEST(ConjugateGradient, EstimatesTheErrorInTheEnergyNorm)
{
    const auto blocks = masked(Vec3i(32, 32, 24), [](const Vec3i& p) { return noise(1, p) < 0.85; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return std::pow(10.0, 2 * noise(4, p)); }, 0.5, constant(1e-3));
    const Vector u = field(blocks, [](const Vec3i& p) { return std::sin(0.2 * p.x()) + noise(7, p); });
    Vector b(blocks.slots(), 0.0), image(blocks.slots(), 0.0);
    const double energy = apply(problem.stencil, u, b);
    for (int iterations : {2, 4, 6}) {
        Multigrid multigrid(problem.stencil);
        Vector rest = b, x, left = u;
        SolveOptions options;
        options.max_iterations = iterations;
        options.tolerance = 1e-12;
        const auto result = conjugate_gradient(problem.stencil, multigrid, rest, x, options);
        ASSERT_EQ(result.iterations, iterations);
        for (size_t slot = 0; slot < left.size(); ++slot) left[slot] -= x[slot];
        const double error = std::sqrt(apply(problem.stencil, left, image) / energy);
        // z r = e A B A e, B the cycle: within the bounds of B A, which one cycle's reduction by a third or more gives.
        EXPECT_GT(result.error / error, 0.6) << iterations;
        EXPECT_LT(result.error / error, 1.3) << iterations;
        // What is returned in b is the residual b - A x, and the result's is its norm.
        double norm = 0;
        for (size_t slot = 0; slot < image.size(); ++slot) {
            ASSERT_NEAR(rest[slot], image[slot], 1e-9);
            norm += image[slot] * image[slot];
        }
        EXPECT_NEAR(result.residual, std::sqrt(norm / dot(blocks, b.data(), b.data())), 1e-9);
    }
}

TEST(ConjugateGradient, AnExactSolutionHasNoError)
{
    // Voxels without neighbours: the first step finds all of them, in numbers without rounding.
    const auto blocks = masked(Vec3i(8, 8, 8), [](const Vec3i& p) { return (p.x() | p.y() | p.z()) % 2 == 0; });
    const Problem problem(blocks, constant(1), 0, constant(2));
    Multigrid multigrid(problem.stencil);
    Vector b = field(blocks, constant(4)), x;
    const auto result = conjugate_gradient(problem.stencil, multigrid, b, x);
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.iterations, 1);
    EXPECT_EQ(result.residual, 0);
    EXPECT_EQ(result.error, 0);
    EXPECT_EQ(x[blocks.slot(Vec3i(2, 4, 6))], 2);
}

TEST(ConjugateGradient, HasEqualDigitsForSourcesOfAnySize)
{
    // Times a power of two, beyond the range of the single precision in which the cycle works.
    const auto blocks = masked(Vec3i(16, 16, 16), [](const Vec3i& p) { return noise(1, p) < 0.85; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.1 + noise(4, p); }, 0.5, constant(1e-3));
    Multigrid multigrid(problem.stencil);
    const Vector source = field(blocks, [](const Vec3i& p) { return noise(7, p) - 0.3; });
    const auto times = [](const Vector& of, double factor) {
        Vector v = of;
        for (double& value : v) value *= factor;
        return v;
    };
    for (const bool guessed : {false, true}) {
        const Vector guess = guessed ? times(source, 0.1) : Vector();
        Vector b = source, x = guess;
        const auto result = conjugate_gradient(problem.stencil, multigrid, b, x);
        EXPECT_GT(result.iterations, 3);
        for (const int exponent : {-900, -300, -160, 130, 300, 900}) {
            const double factor = std::ldexp(1.0, exponent);
            Vector rest = times(source, factor), far = times(guess, factor);
            const auto same = conjugate_gradient(problem.stencil, multigrid, rest, far);
            EXPECT_EQ(same.history, result.history) << exponent;
            EXPECT_EQ(same.error, result.error) << exponent;
            EXPECT_EQ(far, times(x, factor)) << exponent;
            EXPECT_EQ(rest, times(b, factor)) << exponent;
        }
    }
}

TEST(ConjugateGradient, StartsFromTheGuessItIsGiven)
{
    const auto blocks = masked(Vec3i(16, 16, 16), [](const Vec3i& p) { return noise(1, p) < 0.85; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return 0.1 + noise(4, p); }, 0.5, constant(1e-3));
    const Vector u = field(blocks, [](const Vec3i& p) { return noise(7, p); });
    Vector b(blocks.slots(), 0.0);
    apply(problem.stencil, u, b);
    Multigrid multigrid(problem.stencil);
    Vector rest = b, x = u;
    auto result = conjugate_gradient(problem.stencil, multigrid, rest, x);
    EXPECT_EQ(result.iterations, 0);
    EXPECT_TRUE(result.converged);
    for (double& v : x) v *= 0.9;  // the residual is a tenth of b
    rest = b;
    result = conjugate_gradient(problem.stencil, multigrid, rest, x);
    EXPECT_NEAR(result.history[0], 0.1, 1e-9);
    EXPECT_TRUE(result.converged);
    for (size_t slot = 0; slot < u.size(); ++slot) EXPECT_NEAR(x[slot], u[slot], 1e-5);
}

TEST(Relaxation, FollowsTheRecurrenceOfRedBlackSweeps)
{
    // A periodic box of uniform coefficients and absorption a, solution 1, start 0: the error is one number on red
    // voxels and one on black ones. In a half sweep e_red = (1 - w) e_red + w m e_black, m = 6 / (6 + a).
    const auto blocks = box_blocks(Vec3i(16, 8, 24), {true, true, true});
    const double a = 0.25, m = 6 / (6 + a);
    const Problem problem(blocks, constant(1), 0, constant(a));
    for (double factor : {1.0, 1.4, 0.7}) {
        Vector b = field(blocks, constant(a)), x;
        SolveOptions options;
        options.max_iterations = 7;
        const auto result = relax(problem.stencil, factor, b, x, options);
        EXPECT_EQ(result.iterations, 7);
        EXPECT_FALSE(result.converged);
        double red = 1, black = 1;
        for (int sweep = 0; sweep < 7; ++sweep) {
            red = (1 - factor) * red + factor * m * black;
            black = (1 - factor) * black + factor * m * red;
        }
        for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
            const Vec3i p = blocks.voxel(slot);
            ASSERT_NEAR(x[slot], 1 - ((p.x() + p.y() + p.z()) % 2 ? black : red), 1e-6) << factor;
        }
        // The residual is A e: (6 + a) e - 6 e of the other colour, relative to b = a.
        const double r = (6 + a) * red - 6 * black, k = (6 + a) * black - 6 * red;
        EXPECT_NEAR(result.residual, std::sqrt((r * r + k * k) / 2) / a, 1e-5);
    }
}

}  // namespace
}  // namespace vdbcloud
