// Opaque voxels in a sweep: the fast sweep against its definition, and closed forms.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include "support/voxel_field.h"
#include "sweep/swept_medium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace vdbcloud {
namespace {

using test::SweptMedium;

double noise(uint64_t seed, const Vec3i& p)
{
    return uniform(hash_bits(seed, uint64_t(p.x()), uint64_t(p.y()), uint64_t(p.z())));
}

/// Clumps with gaps; a part of the inactive voxels of its blocks is opaque, with elements of random normals that gather
/// light in voxels beside them.
struct Walled {
    Walled()
        : medium(test::voxel_field(Vec3i(28, 24, 24), Vec3d(0.5, 1.0, 0.7),
                                   [](const Vec3i& p) { return p.x() > 11 && p.x() < 16 ? 0.0 : noise(3, p) - 0.4; }))
    {
        medium.add_source([](const Vec3i& p) { return 1 + 0.5 * std::sin(0.3 * p.x() + 0.2 * p.y() - 0.4 * p.z()); });
        const Blocks& blocks = medium.index.blocks();
        for (uint32_t slot = 0; slot < blocks.count() * 512; ++slot) {
            const Vec3i at = blocks.voxel(slot);
            if (blocks.active(slot) || noise(5, at) > 0.4) continue;
            const auto count = uint32_t(3 * noise(6, at));
            walls.voxels.push_back({slot, uint32_t(walls.seen.size()), count});
            for (uint32_t k = 0; k < count; ++k) {
                walls.seen.push_back(uint32_t(walls.elements.size()));
                const Vec3d n(noise(7 + k, at) - 0.5, noise(17 + k, at) - 0.5, noise(27 + k, at) - 0.5);
                const size_t beside = blocks.slot(at + Vec3i(1, 0, 0));
                walls.elements.push_back(
                    {n.unit(), beside < blocks.count() * 512 ? uint32_t(beside) : SweepWalls::nowhere});
            }
        }
        walls.sort(blocks);
        light.walls = &walls;
        for (size_t e = 0; e < walls.elements.size(); ++e) {
            light.radiance.push_back(float(uniform(hash_bits(41, uint64_t(e)))));
            light.irradiance.push_back(-1);
        }
    }
    SweptMedium medium;
    SweepWalls walls;
    WallLight light;
};

void expect_close(const std::vector<float>& found, const std::vector<float>& expected, const char* what)
{
    ASSERT_EQ(found.size(), expected.size()) << what;
    double worst = 0, most = 0;
    for (size_t n = 0; n < found.size(); ++n) {
        worst = std::max(worst, double(std::abs(found[n] - expected[n])));
        most = std::max(most, double(std::abs(expected[n])));
    }
    EXPECT_GT(most, 0) << what;
    EXPECT_LE(worst, 1e-5 * most) << what;  // single precision over some 50 voxels
}

TEST(SweepWalls, FastSweepEqualsTheReference)
{
    const Walled world;
    ASSERT_GT(world.walls.voxels.size(), 500u);
    const SweepSet set = test::set_of(ordinates(OrdinateKind::Product, 32, 1, 1), 0, 2, 0.3);
    WallLight slow = world.light, fast = world.light;
    SweepResult slow_result, fast_result;
    reference_sweep(world.medium.index, world.medium.faces, set, world.medium.fields(), slow_result, nullptr, nullptr,
                    &slow);
    TransportSweep sweep(world.medium.index, world.medium.faces);
    sweep.run(set, world.medium.fields(), fast_result, nullptr, nullptr, &fast);
    for (size_t k = 0; k < slow_result.moments.size(); ++k)
        expect_close(fast_result.moments[k], slow_result.moments[k], "moments");
    std::vector<float> slow_current, fast_current;
    for (size_t f = 0; f < slow_result.tally.size(); ++f) {
        slow_current.push_back(slow_result.tally[f].current);
        fast_current.push_back(fast_result.tally[f].current);
    }
    expect_close(fast_current, slow_current, "currents");
    expect_close(fast.irradiance, slow.irradiance, "irradiance");
    // An element that gathers nothing keeps what it has.
    size_t kept = 0;
    for (size_t e = 0; e < world.walls.elements.size(); ++e)
        if (world.walls.elements[e].outside == SweepWalls::nowhere) {
            EXPECT_EQ(fast.irradiance[e], -1);
            ++kept;
        }
    EXPECT_GT(kept, 0u);
    // Walls matter: without them light is another.
    SweepResult open;
    sweep.run(set, world.medium.fields(), open);
    double change = 0;
    for (size_t n = 0; n < open.moments[0].size(); ++n)
        change = std::max(change, double(std::abs(open.moments[0][n] - fast_result.moments[0][n])));
    EXPECT_GT(change, 0.1);
    // Three channels at once have the values of each alone, bit by bit.
    std::vector<SweepResult> results(3);
    std::vector<WallLight> lights(3, world.light);
    for (float& value : lights[1].radiance) value *= 2;
    std::vector<SweepChannel> channels;
    for (size_t c = 0; c < 3; ++c)
        channels.push_back({&set, &world.medium.source, &results[c], nullptr, nullptr, &lights[c]});
    sweep.run(world.medium.sigma, false, channels);
    EXPECT_EQ(results[0].moments, fast_result.moments);
    EXPECT_EQ(lights[2].irradiance, fast.irradiance);
    EXPECT_NE(results[1].moments, fast_result.moments);
}

TEST(SweepWalls, ASideOfAThinWallHasItsOwnLight)
{
    // One layer of opaque voxels x = 8 with a bright element towards +x and a dark one towards -x.
    SweptMedium medium(
        test::voxel_field(Vec3i(24, 24, 24), Vec3d(1.0), [](const Vec3i& p) { return p.x() == 8 ? 0.0 : 1e-9; }));
    medium.add_source([](const Vec3i&) { return 0.0; });
    const Blocks& blocks = medium.index.blocks();
    SweepWalls walls;
    for (uint32_t slot = 0; slot < blocks.count() * 512; ++slot) {
        const Vec3i at = blocks.voxel(slot);
        if (at.x() != 8) continue;
        walls.voxels.push_back({slot, uint32_t(walls.seen.size()), 2});
        for (const int side : {1, -1}) {
            walls.seen.push_back(uint32_t(walls.elements.size()));
            walls.elements.push_back({Vec3d(side, 0, 0), uint32_t(blocks.slot(at + Vec3i(side, 0, 0)))});
        }
    }
    walls.sort(blocks);
    WallLight light{&walls, {}, {}};
    for (size_t e = 0; e < walls.elements.size(); ++e) light.radiance.push_back(e % 2 ? 0.0f : 5.0f);
    const SweepSet set = test::set_of(ordinates(OrdinateKind::Product, 128, 1, 0), 0, 0, 2.0);
    SweepResult result;
    TransportSweep(medium.index, medium.faces).run(set, medium.fields(), result, nullptr, nullptr, &light);
    // Beside the middle of the wall half of all directions come from it, but for those that pass its edge: a wall of 24
    // voxels seen from one voxel away hides all but 8 % of a half space.
    const double y00 = std::sqrt(4 * pi);
    const auto fluence = [&](int x) { return y00 * double(result.moments[0][blocks.slot(Vec3i(x, 12, 12))]); };
    EXPECT_NEAR(fluence(9), 2 * pi * (5 + 2), 0.1 * 2 * pi * 5);
    EXPECT_NEAR(fluence(7), 2 * pi * 2, 0.1 * 2 * pi * 2);
    // The light on either side is the sky's: pi L.
    const auto middle = size_t(std::find_if(walls.voxels.begin(), walls.voxels.end(), [&](const auto& voxel) {
                                   return blocks.voxel(voxel.slot) == Vec3i(8, 12, 12);
                               })->first);
    EXPECT_NEAR(light.irradiance[middle], 2 * pi, 1e-5 * 2 * pi);
    EXPECT_NEAR(light.irradiance[middle + 1], 2 * pi, 1e-5 * 2 * pi);
}

TEST(SweepWalls, KeepAFurnace)
{
    Walled world;
    std::fill(world.light.radiance.begin(), world.light.radiance.end(), 0.3f);
    // A voxel without elements is black; here each has one.
    for (SweepWalls::Voxel& voxel : world.walls.voxels)
        if (voxel.count == 0) voxel.count = 1;
    std::fill(world.medium.source[0].begin(), world.medium.source[0].end(), float(0.3 * std::sqrt(4 * pi)));
    world.walls.seen.push_back(0);
    const SweepSet set = test::set_of(ordinates(OrdinateKind::LevelSymmetric, 24, 1, 1), 0, 0, 0.3);
    SweepResult result;
    TransportSweep(world.medium.index, world.medium.faces)
        .run(set, world.medium.fields(), result, nullptr, nullptr, &world.light);
    const Blocks& blocks = world.medium.index.blocks();
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot)) {
            EXPECT_NEAR(result.moments[0][slot], 0.3 * std::sqrt(4 * pi), 1e-5);
        }
    std::set<uint32_t> opaque;
    for (const SweepWalls::Voxel& voxel : world.walls.voxels) opaque.insert(voxel.slot);
    size_t open = 0;
    for (size_t e = 0; e < world.walls.elements.size(); ++e) {
        const uint32_t outside = world.walls.elements[e].outside;
        if (outside == SweepWalls::nowhere || opaque.count(outside)) continue;
        EXPECT_NEAR(world.light.irradiance[e], 0.3 * pi, 1e-5);
        ++open;
    }
    EXPECT_GT(open, 100u);
}

}  // namespace
}  // namespace vdbcloud
