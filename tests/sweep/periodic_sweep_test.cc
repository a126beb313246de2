// The fast sweep of media that repeat along one or two axes, against its definition.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include "support/size.h"
#include "support/voxel_field.h"
#include "sweep/swept_medium.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace vdbcloud {
namespace {

using Medium = test::SweptMedium;
using test::set_of;

constexpr double missing = 0.5;  // share of blocks

/// A medium of `n` voxels, of period n along two axes: voxels that are never 0 hold the corners of the period.
Medium medium(const Vec3i& n, const Vec3d& h, int across, uint64_t seed)
{
    std::array<bool, 3> periodic{true, true, true};
    periodic[size_t(across)] = false;
    Medium m(test::voxel_field(n, h,
                               [&](const Vec3i& p) {
                                   bool corner = true;
                                   for (int a = 0; a < 3; ++a)
                                       corner =
                                           corner && (a == across ? p[a] == n[a] / 2 : p[a] == 0 || p[a] == n[a] - 1);
                                   return corner ? 0.5 : test::clumps(p, seed, missing);
                               }),
             periodic);
    m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
    for (int k = 1; k < 4; ++k)
        m.add_source([k](const Vec3i& p) {
            return 0.2 * uniform(hash_bits(k, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
        });
    return m;
}

double largest(const std::vector<float>& of)
{
    double most = 0;
    for (const float x : of) most = std::max(most, double(std::abs(x)));
    return most;
}

/// Equal to `share` of the largest value.
void expect_close(const std::vector<float>& found, const std::vector<float>& expected, double share, const char* what)
{
    ASSERT_EQ(found.size(), expected.size()) << what;
    double worst = 0;
    for (size_t n = 0; n < found.size(); ++n) worst = std::max(worst, double(std::abs(found[n] - expected[n])));
    EXPECT_LE(worst, share * largest(expected)) << what;
}

struct Swept {
    SweepResult result;
    PlaneLight planes;
    SweepGround ground;
    std::vector<float> current, fluence, second;

    void split()
    {
        for (const FaceTally& t : result.tally) {
            current.push_back(t.current);
            fluence.push_back(t.fluence);
            second.push_back(t.second);
        }
    }
};

/// By the reference and by the fast sweep, with planes and, if `albedo` is 0 or above, a ground at `face`.
void expect_equal(const Medium& m, const SweepSet& set, double albedo, int face)
{
    Swept slow, fast;
    const ActiveBox box(m.index.blocks());
    for (Swept* of : {&slow, &fast}) {
        of->ground.face = face;
        of->ground.albedo = albedo;
        for (size_t n = 0; n < box.cells(face); ++n)
            of->ground.direct.push_back(float(uniform(hash_bits(9, uint64_t(n)))));
    }
    const bool ground = albedo >= 0;
    reference_sweep(m.index, m.faces, set, m.fields(), slow.result, &slow.planes, ground ? &slow.ground : nullptr);
    TransportSweep(m.index, m.faces).run(set, m.fields(), fast.result, &fast.planes, ground ? &fast.ground : nullptr);
    // Single precision over some 50 voxels.
    const double rounding = 1e-5;
    for (size_t k = 0; k < slow.result.moments.size(); ++k)
        expect_close(fast.result.moments[k], slow.result.moments[k], rounding, "moments");
    EXPECT_GT(largest(slow.result.moments[0]), 1);
    slow.split();
    fast.split();
    expect_close(fast.current, slow.current, rounding, "current");
    expect_close(fast.fluence, slow.fluence, rounding, "fluence");
    expect_close(fast.second, slow.second, rounding, "second");
    EXPECT_GT(largest(slow.current), 0.1);
    for (size_t f = 0; f < 6; ++f) {
        EXPECT_EQ(slow.planes.from_medium[f].empty(), m.index.blocks().period()[int(f / 2)] != 0);
        expect_close(fast.planes.from_medium[f], slow.planes.from_medium[f], rounding, "from_medium");
        expect_close(fast.planes.from_sky[f], slow.planes.from_sky[f], rounding, "from_sky");
        EXPECT_EQ(fast.planes.sky_in[f], slow.planes.sky_in[f]);
        EXPECT_EQ(fast.planes.of_unit_radiance[f], slow.planes.of_unit_radiance[f]);
    }
    if (ground) {
        expect_close(fast.ground.irradiance, slow.ground.irradiance, rounding, "ground");
        EXPECT_GT(largest(slow.ground.irradiance), 0.1);
    }
}

TEST(PeriodicSweep, EqualsTheReferenceAlongAnyAxis)
{
    for (int across = 0; across < 3; ++across) {
        Vec3i n(16, 16, 16);
        n[across] = 21;
        n[(across + 1) % 3] = 24;
        const Medium m = medium(n, Vec3d(0.5, 1.0, 1.7), across, 11 + uint64_t(across));
        const SweepSet set = set_of(ordinates(OrdinateKind::Product, test::sized(32, 128), 1, across), 1, 2, 0.3);
        expect_equal(m, set, -1, 2 * across);
    }
}

TEST(PeriodicSweep, EqualsTheReferenceOfMediaThatRepeatAlongOneAxis)
{
    // Blocks are missing, also at both ends of the axes that end.
    for (int along = 0; along < 3; ++along) {
        std::array<bool, 3> periodic{false, false, false};
        periodic[size_t(along)] = true;
        Vec3i n(21, 18, 27);
        n[along] = 16;
        Medium m(test::voxel_field(n, Vec3d(0.5, 1.0, 1.7),
                                   [&](const Vec3i& p) {
                                       bool end = p[along] == 0 || p[along] == 15;
                                       for (int a = 0; a < 3; ++a) end = end && (a == along || p[a] == 9);
                                       return end ? 0.5 : test::clumps(p, 21 + uint64_t(along), missing);
                                   }),
                 periodic);
        m.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
        for (int k = 1; k < 4; ++k)
            m.add_source([k](const Vec3i& p) {
                return 0.2 * uniform(hash_bits(k, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
            });
        expect_equal(m, set_of(ordinates(OrdinateKind::Product, test::sized(32, 128), 1, along), 1, 2, 0.3), -1, 0);
    }
}

TEST(PeriodicSweep, OfARowOfBlocksThatRepeatsEqualsTheReferenceAlongAxesAndDiagonals)
{
    Medium m(test::voxel_field(Vec3i(8, 9, 6), Vec3d(1.0), [](const Vec3i& p) { return p.x() == 3 ? 0.0 : 0.3; }),
             {true, false, false});
    m.add_source([](const Vec3i& p) { return 1 + 0.1 * p.y(); });
    SweepSet set;
    set.source_terms = set.moment_terms = 1;
    for (int n = 0; n < 27; ++n) {
        const Vec3d s(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
        if (s[1] == 0 && s[2] == 0) continue;
        set.direction.push_back(s.unit());
        set.weight.push_back(1.0f);
        set.inflow.push_back(float(n));
        set.source_basis.push_back(1.0f);
        set.moment_basis.push_back(float(n % 4 - 1));
    }
    expect_equal(m, set, -1, 0);
    set.direction[0] = Vec3d(1, 0, 0);
    SweepResult r;
    EXPECT_THROW(TransportSweep(m.index, m.faces).run(set, m.fields(), r), InputError);
    SweepGround ground;
    set.direction[0] = Vec3d(0, 1, 0);
    ground.face = 2;
    EXPECT_THROW(TransportSweep(m.index, m.faces).run(set, m.fields(), r, nullptr, &ground), InputError);
}

TEST(PeriodicSweep, EqualsTheReferenceOverAGround)
{
    for (const int face : {2, 3}) {
        const Medium m = medium(Vec3i(16, 21, 24), Vec3d(1.0), 1, 5);
        for (const double albedo : {0.0, 0.7}) {
            if (albedo == 0 && face == 3) continue;
            expect_equal(m, set_of(ordinates(OrdinateKind::Product, test::sized(32, 128), 1, 1, true), 1, 2, 0.3),
                         albedo, face);
        }
    }
}

TEST(PeriodicSweep, EqualsTheReferenceOfOneBlockThatRepeats)
{
    // Its copies shade each other; rays of a tile meet different copies. Directions near the horizon cross many.
    Medium m = medium(Vec3i(8, 21, 8), Vec3d(1.0), 1, 3);
    const SweepSet set = set_of(ordinates(OrdinateKind::Product, 128, 1, 1, true), 1, 1, 0.3);
    expect_equal(m, set, 0.4, 2);
    m.emission = true;
    expect_equal(m, set, 0.4, 2);
}

TEST(PeriodicSweep, EqualsTheReferenceAlongAxesAndDiagonals)
{
    const Medium m = medium(Vec3i(16, 21, 24), Vec3d(1.0), 1, 2);
    SweepSet set;
    set.source_terms = 1;
    set.moment_terms = 1;
    for (int n = 0; n < 27; ++n) {
        const Vec3d s(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
        if (s[1] == 0) continue;
        set.direction.push_back(s.unit());
        set.weight.push_back(1.0f);
        set.inflow.push_back(float(n));
        set.source_basis.push_back(1.0f);
        set.moment_basis.push_back(float(n % 4 - 1));
    }
    Medium one = m;
    one.source.resize(1);
    SweepResult slow, fast;
    reference_sweep(one.index, one.faces, set, one.fields(), slow);
    TransportSweep(one.index, one.faces).run(set, one.fields(), fast);
    expect_close(fast.moments[0], slow.moments[0], 1e-5, "moments");
    EXPECT_GT(largest(slow.moments[0]), 1);
}

TEST(PeriodicSweep, DoesNotDependOnTheNumberOfThreads)
{
    const Medium m = medium(Vec3i(72, 11, 64), Vec3d(1.0), 1, 7);
    const SweepSet set = set_of(ordinates(OrdinateKind::Product, 16, 1), 1, 1, 0.3);
    TransportSweep sweep(m.index, m.faces);
    SweepResult many, single;
    sweep.run(set, m.fields(), many);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    single.moments.assign(4, std::vector<float>(m.index.blocks().slots(), 7.0f));  // over what was there
    sweep.run(set, m.fields(), single);
    EXPECT_TRUE(many.moments == single.moments);
    for (size_t f = 0; f < many.tally.size(); ++f) ASSERT_EQ(many.tally[f].current, single.tally[f].current);
}

TEST(PeriodicSweep, KeepsTheWhiteFurnace)
{
    // Radiance 1 comes in and is emitted everywhere; over a white ground without beams, too.
    Medium m = medium(Vec3i(16, 21, 24), Vec3d(0.3, 1.0, 2.0), 1, 2);
    m.source.clear();
    m.add_source([](const Vec3i&) { return std::sqrt(4 * 3.14159265358979323846); });
    SweepSet set = set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 1, 1);
    SweepGround ground;
    ground.face = 2;
    ground.albedo = 1;
    ground.direct.assign(16 * 24, 0.0f);
    SweepResult r;
    TransportSweep(m.index, m.faces).run(set, m.fields(), r, nullptr, &ground);
    const double full = std::sqrt(4 * 3.14159265358979323846);
    const Blocks& blocks = m.index.blocks();
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot) {
        if (!blocks.active(slot)) {
            EXPECT_EQ(r.moments[0][slot], 0);
            continue;
        }
        EXPECT_NEAR(r.moments[0][slot] / full, 1, 1e-5);
        EXPECT_NEAR(r.moments[2][slot] / full, 0, 1e-5);
    }
    for (const float e : ground.irradiance) EXPECT_NEAR(e / 3.14159265, 1, 1e-5);
}

}  // namespace
}  // namespace vdbcloud
