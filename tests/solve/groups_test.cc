// Groups of unknowns, the operators on them and the direct solve, against dense linear algebra in double precision.
#include "graphs.h"
#include "problems.h"
#include "vdbcloud/solve/aggregation.h"
#include "vdbcloud/solve/dense_factor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

namespace vdbcloud {
namespace {

using namespace test;

/// P^T A P x, P constant on groups and 0 for group -1.
Vector galerkin(const Operator& a, const std::vector<int32_t>& group, const Vector& x)
{
    Vector fine(group.size(), 0.0), coarse(x.size(), 0.0);
    for (size_t i = 0; i < group.size(); ++i)
        if (group[i] >= 0) fine[i] = x[size_t(group[i])];
    const Vector y = a(fine);
    for (size_t i = 0; i < group.size(); ++i)
        if (group[i] >= 0) coarse[size_t(group[i])] += y[i];
    return coarse;
}

/// Each row has one link to a column, and what links i to j links j to i, to the rounding of float.
void expect_symmetric(const Graph& graph)
{
    std::map<std::pair<int32_t, int32_t>, double> links;
    for (size_t i = 0; i < graph.size(); ++i)
        for (uint32_t k = graph.begin[i]; k < graph.begin[i + 1]; ++k)
            ASSERT_TRUE(links.insert({{int32_t(i), graph.column[k]}, graph.c[k]}).second)
                << i << ' ' << graph.column[k];
    for (const auto& [ends, c] : links) {
        const auto back = links.find({ends.second, ends.first});
        ASSERT_NE(back, links.end());
        ASSERT_NEAR(back->second / c, 1, 2e-7);
    }
}

TEST(Graph, CollapsesToTheGalerkinOperator)
{
    const Graph fine = random_graph(300, 1, 0.2);
    std::vector<int32_t> group(fine.size());
    for (size_t i = 0; i < group.size(); ++i) group[i] = int32_t(hash_bits(4, i) % 41) - 1;  // -1 .. 39
    const Graph coarse = collapsed(fine, group, 40);
    ASSERT_EQ(coarse.size(), 40u);
    expect_symmetric(coarse);
    const Vector x = random_vector(40, 5), got = product(coarse, x);
    const Vector expected = galerkin([&](const Vector& v) { return product(fine, v); }, group, x);
    for (size_t g = 0; g < 40; ++g) EXPECT_NEAR(got[g], expected[g], 1e-5) << g;  // sums of floats up to 30
}

TEST(VoxelGroups, CollapseToTheGalerkinOperator)
{
    const auto blocks = masked(Vec3i(24, 16, 16), [](const Vec3i& p) { return noise(1, p) < 0.8; });
    const Problem problem(
        blocks, [](const Vec3i& p) { return std::pow(10.0, 3 * noise(2, p)); }, 0.5,
        [](const Vec3i& p) { return noise(3, p) < 0.1 ? 1e4 : 0.01; });
    const VoxelGroups groups = group_voxels(problem.stencil);
    const Graph coarse = collapsed(problem.stencil, groups);
    ASSERT_EQ(coarse.size(), groups.count());
    EXPECT_LT(3 * coarse.size(), blocks.active_count() * 2);
    expect_symmetric(coarse);
    std::vector<int32_t> group(blocks.slots(), -1);
    size_t without = 0;
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        group[slot] = groups(slot);
        without += blocks.active(slot) && group[slot] < 0;
    }
    EXPECT_GT(without, 100u);  // held by their extra
    const Vector x = random_vector(coarse.size(), 5), got = product(coarse, x);
    const Vector expected = galerkin(
        [&](const Vector& v) {
            Vector y(v.size(), 0.0);
            apply(problem.stencil, v, y);
            return y;
        },
        group, x);
    for (size_t g = 0; g < coarse.size(); ++g)
        EXPECT_NEAR(got[g], expected[g], 1e-5 * (coarse.linked(g) + coarse.extra[g])) << g;
}

/// Groups in a box of 8^3 whose links are 1 along x and `other` along y and z.
size_t groups_of_box(float other, float extra)
{
    const auto blocks = box_blocks(Vec3i(8));
    Stencil a(blocks);
    for (size_t slot = 0; slot < 512; ++slot) {
        for (int axis = 0; axis < 3; ++axis)
            if (blocks.active(blocks.neighbour(slot, 2 * axis + 1))) a.face[axis][slot] = axis == 0 ? 1 : other;
        a.extra[slot] = extra;
    }
    return group_voxels(a).count();
}

TEST(VoxelGroups, JoinAcrossLinksOfAtLeastTwoFifthsOfTheStrongest)
{
    EXPECT_EQ(groups_of_box(1, 0), 64u);  // cells of 2 x 2 x 2
    EXPECT_EQ(groups_of_box(0.41f, 0), 64u);
    EXPECT_EQ(groups_of_box(0.39f, 0), 256u);  // pairs along x
}

TEST(VoxelGroups, LeaveOutVoxelsWhoseExtraIsAThirdOfTheirLinks)
{
    EXPECT_EQ(groups_of_box(1, 0.99f), 64u);  // 3 to 6 links: a third is 1 to 2
    const size_t some = groups_of_box(1, 1.01f);
    EXPECT_LE(some, 64u);
    EXPECT_EQ(groups_of_box(1, 2.01f), 0u);
    // At 1.5 only voxels of 5 or 6 links take part: 6^3 inside, 6 x 36 on faces; every cell still has some.
    EXPECT_EQ(groups_of_box(1, 1.5f), 64u);
    EXPECT_EQ(groups_of_box(1, 1.99f), 64u);  // the 6^3 inside
}

TEST(GraphGroups, PairUnknownsUpToAConditionNumberOfNine)
{
    // Two unknowns linked by 1, each linked by w to an unknown that its extra holds: the condition number is 1 + w.
    for (const auto& [w, groups] : {std::pair(7.9f, 1u), {8.1f, 2u}}) {
        Graph graph;
        std::vector<std::pair<int32_t, float>> links{{1, 1.0f}, {2, w}};
        add_row(graph, links, 0);
        links = {{0, 1.0f}, {3, w}};
        add_row(graph, links, 0);
        links = {{0, w}};
        add_row(graph, links, 100);
        links = {{1, w}};
        add_row(graph, links, 100);
        std::vector<int32_t> group;
        const Graph coarse = grouped(graph, group);
        EXPECT_EQ(coarse.size(), groups) << w;
        EXPECT_EQ(group[2], -1);
        EXPECT_EQ(group[3], -1);
        float held = 0;
        for (float e : coarse.extra) held += e;
        EXPECT_FLOAT_EQ(held, 2 * w);  // links to held unknowns hold the groups
    }
}

TEST(DenseFactor, SolvesASystem)
{
    const Graph graph = random_graph(60, 1, 0.1);
    const Vector u = random_vector(60, 2), b = product(graph, u);
    DenseFactor factor(graph);
    std::vector<float> x(60);
    factor.solve({b.begin(), b.end()}, x);
    for (size_t i = 0; i < 60; ++i) EXPECT_NEAR(x[i], u[i], 1e-4);  // b in floats, condition number about 100
}

TEST(DenseFactor, HoldsTheLastUnknownOfEachSingularPartAtZero)
{
    const size_t parts = 3, n = 60;
    const Graph graph = random_graph(n, parts, 0);
    const Vector u = random_vector(n, 2), b = product(graph, u);
    DenseFactor factor(graph);
    std::vector<float> x(n);
    factor.solve({b.begin(), b.end()}, x);
    for (size_t i = 0; i < n; ++i) EXPECT_NEAR(x[i], u[i] - u[n - parts + i % parts], 1e-4) << i;
}

}  // namespace
}  // namespace vdbcloud
