// The fast sweep over a patch of endless ground, against its definition and closed forms.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include "support/voxel_field.h"
#include "sweep/swept_medium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

using Medium = test::SweptMedium;

constexpr double below = 0.4;  // radiance of the endless ground

/// Two clumps of blocks with a gap between them.
Medium medium(const Vec3i& lowest)
{
    Medium m(test::voxel_field(Vec3i(40, 24, 24), Vec3d(0.5, 1.0, 0.7), [&](const Vec3i& p) {
        const Vec3i q = p - lowest;
        if (q.x() < 0 || q.y() < 0 || q.z() < 0 || (q.x() > 11 && q.x() < 24)) return 0.0;
        return uniform(hash_bits(3, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z()))) - 0.3;
    }));
    m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
    return m;
}

SweepSet set_over(int face, double sky)
{
    SweepSet set = test::set_of(ordinates(OrdinateKind::Product, 16, 1, face / 2), 0, 2, sky);
    for (size_t m = 0; m < set.count(); ++m)
        if (set.direction[m][face / 2] * (face % 2 ? -1 : 1) > 0) set.inflow[m] = float(below);
    return set;
}

SweepGround ground_under(const Medium& m, int face, double albedo, int edge)
{
    const ActiveBox box(m.index.blocks());
    const auto [u, v] = ActiveBox::axes(face / 2);
    GroundPatch patch;
    patch.face = face;
    patch.plane = face % 2 ? box.last[face / 2] + 1 : box.first[face / 2] - 1;
    patch.edge = edge;
    patch.first = {box.first[u] - 11, box.first[v] - 6};
    patch.count = {(box.size(u) + 30) / edge, (box.size(v) + 13) / edge};
    SweepGround ground{face, albedo, {}, patch, {}};
    for (size_t n = 0; n < patch.cells(); ++n) ground.direct.push_back(float(uniform(hash_bits(9, uint64_t(n))) - 0.5));
    return ground;
}

double largest(const std::vector<float>& of)
{
    double most = 0;
    for (const float x : of) most = std::max(most, double(std::abs(x)));
    return most;
}

void expect_close(const std::vector<float>& found, const std::vector<float>& expected, const char* what)
{
    ASSERT_EQ(found.size(), expected.size()) << what;
    double worst = 0;
    for (size_t n = 0; n < found.size(); ++n) worst = std::max(worst, double(std::abs(found[n] - expected[n])));
    EXPECT_LE(worst, 1e-5 * largest(expected)) << what;  // single precision over some 50 voxels
}

TEST(GroundPatch, FastSweepEqualsTheReference)
{
    // The plane of the ground lies in a block's first voxels or between blocks; cells of one voxel and of several.
    for (const auto& [face, edge, base] : {std::tuple(2, 1, 0), {2, 3, 5}, {3, 1, 5}, {0, 1, 3}}) {
        const Medium m = medium(Vec3i(base, base, base));
        const SweepSet set = set_over(face, 0.3);
        SweepGround slow = ground_under(m, face, 0.7, edge), fast = slow;
        SweepResult slow_result, fast_result;
        PlaneLight slow_planes, fast_planes;
        reference_sweep(m.index, m.faces, set, m.fields(), slow_result, &slow_planes, &slow);
        TransportSweep(m.index, m.faces).run(set, m.fields(), fast_result, &fast_planes, &fast);
        for (size_t k = 0; k < slow_result.moments.size(); ++k)
            expect_close(fast_result.moments[k], slow_result.moments[k], "moments");
        expect_close(fast.irradiance, slow.irradiance, "irradiance");
        EXPECT_GT(largest(fast.irradiance), 0.1);
        for (size_t f = 0; f < 6; ++f) {
            expect_close(fast_planes.from_medium[f], slow_planes.from_medium[f], "from_medium");
            expect_close(fast_planes.from_sky[f], slow_planes.from_sky[f], "from_sky");
            EXPECT_EQ(fast_planes.sky_in[f], slow_planes.sky_in[f]);
            EXPECT_NEAR(fast_planes.ground_in[f], slow_planes.ground_in[f], 1e-5 * slow_planes.ground_in[size_t(face)]);
        }
        // Without cells, planes are sampled as coarsely as the patch is.
        PlaneLight sums;
        sums.by_cell = false;
        TransportSweep(m.index, m.faces).run(set, m.fields(), fast_result, &sums, &fast);
        for (size_t f = 0; f < 6; ++f)
            for (size_t n = 0; n < set.count(); ++n) {
                const double whole = slow_planes.medium_along[f][n] + slow_planes.sky_along[f][n];
                EXPECT_NEAR(sums.medium_along[f][n], slow_planes.medium_along[f][n], 1e-5 * whole) << f << ' ' << n;
                EXPECT_NEAR(sums.sky_along[f][n], slow_planes.sky_along[f][n], (edge > 1 ? 0.05 : 1e-5) * whole)
                    << f << ' ' << n;
            }
        // Up through the lower plane the ground alone sends light; through the upper plane nothing of it comes in.
        EXPECT_EQ(fast_planes.sky_in[size_t(face)], 0);
        EXPECT_GT(fast_planes.ground_in[size_t(face)], 0);
        EXPECT_EQ(fast_planes.ground_in[size_t(face ^ 1)], 0);
    }
}

TEST(GroundPatch, LightOfOneCellCrossesTheVoidToTheVoxelsThatSeeIt)
{
    // A medium without extinction, whose blocks begin 3 voxels below the ground: L at a voxel is the inflow, and on
    // rays from the cell the cell's radiance, too. Interpolation from plane to plane spreads it, about the same middle.
    Medium m(test::voxel_field(Vec3i(40, 24, 24), Vec3d(1.0), [](const Vec3i& p) { return p.y() < 19 ? 0.0 : 1e-12; }));
    m.add_source([](const Vec3i&) { return 0.0; });
    const Vec3d up(0, 1, 0), aslant = Vec3d(1, 2, 0).unit();
    SweepSet set = test::one_by_one({up, aslant, -up});
    set.inflow = {float(below), float(below), 0.0f};
    SweepGround ground = ground_under(m, 2, 0.5, 1);
    std::fill(ground.direct.begin(), ground.direct.end(), 0.0f);
    const GroundPatch& patch = *ground.patch;
    for (size_t cell = 0; cell < patch.cells(); ++cell)
        if (patch.middle(cell) == Vec3i(10, 18, 7)) ground.direct[cell] = 1.0f;
    SweepResult r;
    TransportSweep(m.index, m.faces).run(set, m.fields(), r, nullptr, &ground);
    const auto at = [&](int k, const Vec3i& p) { return r.moments[size_t(k)][m.index.blocks().slot(p)]; };
    EXPECT_NEAR(at(0, Vec3i(10, 22, 7)), below + 0.5 / pi, 1e-6);
    EXPECT_NEAR(at(0, Vec3i(11, 22, 7)), below, 1e-6);
    EXPECT_NEAR(at(0, Vec3i(10, 22, 8)), below, 1e-6);
    EXPECT_NEAR(at(2, Vec3i(10, 22, 7)), 0, 1e-6);
    double sum = 0, middle = 0;
    for (int x = 0; x < 40; ++x) {
        const double light = at(1, Vec3i(x, 22, 7)) - double(float(below));
        sum += light;
        middle += x * light;
        EXPECT_NEAR(at(1, Vec3i(x, 22, 8)), below, 1e-6);
    }
    EXPECT_NEAR(sum, 0.5 / pi, 1e-5);
    EXPECT_NEAR(middle / sum, 10 + (22 - 18) / 2, 1e-3);
}

TEST(GroundPatch, KeepsTheWhiteFurnace)
{
    Medium m = medium(Vec3i(5, 5, 5));
    m.source.clear();
    m.add_source([](const Vec3i&) { return std::sqrt(4 * pi); });
    SweepSet set = set_over(2, 1);
    std::fill(set.inflow.begin(), set.inflow.end(), 1.0f);
    SweepGround ground = ground_under(m, 2, 1, 1);
    std::fill(ground.direct.begin(), ground.direct.end(), 0.0f);
    SweepResult r;
    TransportSweep(m.index, m.faces).run(set, m.fields(), r, nullptr, &ground);
    const Blocks& blocks = m.index.blocks();
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) {
            EXPECT_NEAR(r.moments[0][slot] / std::sqrt(4 * pi), 1, 1e-5);
        }
    EXPECT_LT(largest(ground.irradiance), 1e-5);
}

TEST(GroundPatch, InterpolatesToNothingBeyondItsCells)
{
    const GroundPatch patch{2, -1, {4, 8}, {2, 3}, 2};
    const std::vector<float> values{1, 2, 3, 4, 5, 6};
    EXPECT_EQ(patch.middle(4), Vec3i(6, -1, 10));
    EXPECT_EQ(patch.interpolate(values, {4.0, 10.0}), 2);
    EXPECT_EQ(patch.interpolate(values, {5.0, 9.0}), 3);
    EXPECT_EQ(patch.interpolate(values, {7.0, 12.0}), 3);
    EXPECT_EQ(patch.interpolate(values, {3.0, 8.0}), 0.5);
    EXPECT_EQ(patch.interpolate(values, {8.0, 8.0}), 0);
    EXPECT_EQ(patch.interpolate(values, {4.0, 6.0}), 0);
}

TEST(GroundPatch, GroundsOfTheOtherKindAreRefused)
{
    const Medium m = medium(Vec3i(0, 0, 0));
    SweepGround without = ground_under(m, 2, 0.5, 1);
    without.patch.reset();
    SweepResult r;
    TransportSweep open(m.index, m.faces);
    EXPECT_THROW(open.run(set_over(2, 0), m.fields(), r, nullptr, &without), InputError);
    Medium layer(test::voxel_field(Vec3i(8, 8, 8), Vec3d(1.0), [](const Vec3i&) { return 1.0; }), {true, false, true});
    layer.add_source([](const Vec3i&) { return 1.0; });
    SweepGround patch = ground_under(layer, 2, 0.5, 1);
    TransportSweep repeats(layer.index, layer.faces);
    EXPECT_THROW(repeats.run(set_over(2, 0), layer.fields(), r, nullptr, &patch), InputError);
}

}  // namespace
}  // namespace vdbcloud
