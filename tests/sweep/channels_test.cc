// Channels of one extinction that are swept together: each has the light of a sweep of its own, bit by bit.
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/transport_sweep.h"

#include "support/voxel_field.h"
#include "sweep/swept_medium.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using Medium = test::SweptMedium;

/// What a sweep of one channel finds.
struct Light {
    SweepResult result;
    PlaneLight planes;
    SweepGround ground;
};

void expect_equal(const Light& a, const Light& b)
{
    EXPECT_EQ(a.result.moments, b.result.moments);
    ASSERT_EQ(a.result.tally.size(), b.result.tally.size());
    for (size_t n = 0; n < a.result.tally.size(); ++n) {
        ASSERT_EQ(a.result.tally[n].current, b.result.tally[n].current);
        ASSERT_EQ(a.result.tally[n].fluence, b.result.tally[n].fluence);
        ASSERT_EQ(a.result.tally[n].second, b.result.tally[n].second);
    }
    EXPECT_EQ(a.planes.from_medium, b.planes.from_medium);
    EXPECT_EQ(a.planes.from_sky, b.planes.from_sky);
    EXPECT_EQ(a.planes.medium_along, b.planes.medium_along);
    EXPECT_EQ(a.planes.sky_along, b.planes.sky_along);
    EXPECT_EQ(a.planes.sky_in, b.planes.sky_in);
    EXPECT_EQ(a.planes.ground_in, b.planes.ground_in);
    EXPECT_EQ(a.ground.irradiance, b.ground.irradiance);
}

SweepGround ground_under(const Medium& m, int seed)
{
    const ActiveBox box(m.index.blocks());
    GroundPatch patch;
    patch.face = 2;
    patch.plane = box.first[1] - 1;
    patch.first = {box.first[0] - 3, box.first[2] - 6};
    patch.count = {box.size(0) + 8, box.size(2) + 13};
    SweepGround ground{2, 0.6, {}, patch, {}};
    for (size_t n = 0; n < patch.cells(); ++n)
        ground.direct.push_back(float(uniform(hash_bits(uint64_t(seed), uint64_t(n))) - 0.5));
    return ground;
}

/// `channels` swept together and one by one, on more and fewer threads.
void expect_channels_alike(bool emission, bool over_ground, size_t channels, bool periodic)
{
    // Directions cross planes of each axis.
    Medium m(test::voxel_field(Vec3i(44, 24, 32), Vec3d(1.0, 0.8, 1.2),
                               [](const Vec3i& p) { return test::clumps(p, 11, 0.5); }),
             {false, false, periodic});
    const SweepSet shared = test::set_of(ordinates(OrdinateKind::Product, 64, 1), 1, 2, 0);
    std::vector<SweepSet> sets(channels, shared);
    std::vector<std::vector<std::vector<float>>> sources;
    std::vector<Light> together(channels);
    for (size_t c = 0; c < channels; ++c) {
        m.source.clear();
        for (int k = 0; k < 4; ++k)
            m.add_source([&](const Vec3i& p) {
                const double own = uniform(hash_bits(10 * c + uint64_t(k), p.x(), p.y(), p.z()));
                return k == 0 ? 0.5 + own : 0.2 * own;
            });
        sources.push_back(m.source);
        for (size_t n = 0; n < shared.count(); ++n) sets[c].inflow[n] = float(0.1 * double(c) + 0.002 * double(n));
        if (over_ground) together[c].ground = ground_under(m, int(c));
    }
    std::vector<Light> alone = together;
    TransportSweep sweep(m.index, m.faces);
    std::vector<SweepChannel> all;
    for (size_t c = 0; c < channels; ++c) {
        Light& to = together[c];
        // The second channel does without planes.
        all.push_back(
            {&sets[c], &sources[c], &to.result, c == 1 ? nullptr : &to.planes, over_ground ? &to.ground : nullptr});
    }
    sweep.run(m.sigma, emission, all);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    for (size_t c = 0; c < channels; ++c) {
        Light& to = alone[c];
        sweep.run(sets[c], {&m.sigma, &sources[c], emission}, to.result, c == 1 ? nullptr : &to.planes,
                  over_ground ? &to.ground : nullptr);
        expect_equal(together[c], to);
        EXPECT_EQ(to.result.moments == alone[0].result.moments, c == 0);
    }
    sweep.run(m.sigma, emission, all);  // over what was there, and from what it remembers of the sky
    for (size_t c = 0; c < channels; ++c) expect_equal(together[c], alone[c]);
}

TEST(SweepChannels, HaveTheLightOfASweepOfTheirOwn)
{
    for (const size_t channels : {2, 3, 4}) expect_channels_alike(false, false, channels, false);
}

TEST(SweepChannels, HaveTheEmissionOfASweepOfTheirOwn) { expect_channels_alike(true, false, 3, false); }

TEST(SweepChannels, HaveTheGroundOfASweepOfTheirOwn) { expect_channels_alike(false, true, 3, false); }

TEST(SweepChannels, HaveTheLightOfASweepOfTheirOwnInAMediumThatRepeats)
{
    expect_channels_alike(false, false, 3, true);
}

}  // namespace
}  // namespace vdbcloud
