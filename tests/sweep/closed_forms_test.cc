// Sweeps against numbers known in closed form: inflow by direction, emission, tallies of faces, layers across each
// axis, and what is seen through the void.
#include "support/voxel_field.h"
#include "swept_medium.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sweep/void_rays.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using Medium = test::SweptMedium;
using test::one_by_one;

Vec3d random_direction(uint64_t seed)
{
    const double z = 2 * uniform(hash_bits(seed, 1)) - 1, a = 2 * M_PI * uniform(hash_bits(seed, 2));
    return {std::sqrt(1 - z * z) * std::cos(a), std::sqrt(1 - z * z) * std::sin(a), z};
}

enum class Which { Blocks, Reference };

SweepResult run(const Medium& m, const SweepSet& set, Which which)
{
    SweepResult result;
    if (which == Which::Reference)
        reference_sweep(m.index, m.faces, set, m.fields(), result);
    else
        TransportSweep(m.index, m.faces).run(set, m.fields(), result);
    return result;
}

TEST(Sweeps, AttenuateTheInflowOfEachDirectionAndAddItsEmission)
{
    // Along the six axis directions a uniform box is a row of voxels: L = inflow e^-tau + q (1 - e^-tau), exactly.
    const Vec3i n(19, 11, 14);
    const Vec3d h(0.5, 1, 1.7);
    const double sigma = 0.3;
    Medium m(test::voxel_field(n, h, [&](const Vec3i&) { return sigma; }));
    m.add_source([](const Vec3i&) { return 0.7; });
    SweepSet set = one_by_one({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}});
    for (size_t d = 0; d < 6; ++d) {
        set.inflow[d] = float(d + 1);
        set.weight[d] = 0.5f + 0.25f * float(d);
        set.source_basis[d] = 1 + 0.5f * float(d);
    }
    const auto radiance = [&](size_t d, double voxels) {
        const double e = std::exp(-sigma * voxels * h[int(d / 2)]);
        return set.inflow[d] * e + 0.7 * set.source_basis[d] * (1 - e);
    };
    /// Voxels that light of direction d crosses from outside to the centre of voxel p.
    const auto depth = [&](size_t d, const Vec3i& p) {
        const int a = int(d / 2);
        return (d % 2 ? n[a] - 1 - p[a] : p[a]) + 0.5;
    };
    for (const Which which : {Which::Blocks, Which::Reference}) {
        const SweepResult result = run(m, set, which);
        for (size_t slot = 0; slot < m.index.blocks().count() * 512; ++slot) {
            if (!m.index.blocks().active(slot)) continue;
            for (size_t d = 0; d < 6; ++d)
                ASSERT_NEAR(result.moments[d][slot],
                            set.weight[d] * radiance(d, depth(d, m.index.blocks().voxel(slot))), 1e-5);
        }
        ASSERT_EQ(m.faces.size(), 2u * (19 * 11 + 11 * 14 + 14 * 19));
        for (size_t f = 0; f < m.faces.size(); ++f) {
            const Vec3i p = m.index.blocks().voxel(m.faces[f].slot);
            const int axis = m.faces[f].face / 2, outward = m.faces[f].face % 2 ? 1 : -1;
            double current = 0, fluence = 0, second = 0;
            for (size_t d = 0; d < 6; ++d) {
                const double cosine = int(d / 2) == axis ? (d % 2 ? -1 : 1) * outward : 0;
                // Outward: through the whole box. Inward: none of it. Along the face: the voxel's own depth.
                const double voxels = cosine > 0 ? n[axis] : cosine < 0 ? 0 : depth(d, p);
                const double weighted = set.weight[d] * radiance(d, voxels);
                current += cosine * weighted;
                fluence += weighted;
                second += (cosine * cosine - 1.0 / 3) * weighted;
            }
            ASSERT_NEAR(result.tally[f].current, current, 3e-5) << f;
            ASSERT_NEAR(result.tally[f].fluence, fluence, 3e-5) << f;
            ASSERT_NEAR(result.tally[f].second, second, 3e-5) << f;
        }
    }
}

TEST(ReferenceSweep, StepIsThatOfExtinctionAndSourceLinearInLength)
{
    // Two layers, light along the axis: from the first centre to the second sigma and q go linearly from (s0, 1) to
    // (s1, 0), so L1 is their integral. With r = 2 (s1 - s0) / (s1 + s0) the step's weight of q0 is off by r^2 tau^2 /
    // 240 and terms of tau^3, by 0.11 at most at any tau, and between 0 and the whole. q linear in optical depth would
    // be off by r tau / 12.
    for (const double ratio : {0.0, 0.1, 1.0, 10.0, 1e6})
        for (const double tau : {0.01, 0.1, 0.4, 1.0, 3.0, 10.0, 60.0}) {
            const double s0 = 2 * tau / (1 + ratio), s1 = ratio * s0;
            double exact = 0;
            const int steps = 20000;
            for (int k = 0; k < steps; ++k) {
                const double at = (k + 0.5) / steps, left = 1 - at;
                exact += (s0 + at * (s1 - s0)) * left * std::exp(-left * (s0 + s1 + at * (s1 - s0)) / 2) / steps;
            }
            Medium m(test::voxel_field(Vec3i(8, 2, 8), Vec3d(1.0),
                                       [&](const Vec3i& p) { return p.y() == 0 ? s0 : std::max(s1, 1e-30); }),
                     {true, false, true});
            m.add_source([&](const Vec3i& p) { return p.y() == 0 ? 1.0 : 0.0; });
            SweepSet set = one_by_one({Vec3d(0, 1, 0)});
            set.inflow = {1.0f};  // what enters the first centre is 1, as q0
            const SweepResult result = run(m, set, Which::Reference);
            const double weight = result.moments[0][m.index.blocks().slot(Vec3i(3, 1, 3))] - std::exp(-tau);
            const double bound = std::min(0.11, tau * tau / 60 + 0.2 * tau * tau * tau);
            EXPECT_NEAR(weight, exact, bound + 1e-7) << ratio << ' ' << tau;
            EXPECT_GE(weight, -1e-7);
            EXPECT_LE(weight, 1 - std::exp(-tau) + 1e-7);
            const double in_depth = -std::expm1(-tau) / tau - std::exp(-tau);
            if (tau < 0.5 && ratio != 1) {
                EXPECT_GT(std::abs(in_depth - exact), 2 * bound) << ratio << ' ' << tau;
            }
        }
}

TEST(ReferenceSweep, IntegratesLayersOfAnyExtinctionAcrossEachAxis)
{
    // Layers repeat along two axes; sigma and q are linear in length from centre to centre (transport_sweep.h):
    //   tau = (s0 + s1) / 2 h / mu,  L1 = L0 e^-tau + q1 (1 - e^-tau) + (q0 - q1) w,
    //   w = (1 - e^-tau) / tau - e^-tau - (s1 - s0) h / mu / (12 + 6 tau + 2 tau^2).
    const Vec3d h(0.5, 1, 1.7);
    for (int axis = 0; axis < 3; ++axis) {
        Vec3i n(8);
        n[axis] = 19;
        std::array<bool, 3> periodic{true, true, true};
        periodic[size_t(axis)] = false;
        const auto sigma = [](int j) { return std::pow(10.0, 3 * uniform(hash_bits(3, uint64_t(j))) - 1.5); };
        const auto q = [](int j) { return 0.2 + uniform(hash_bits(4, uint64_t(j))); };
        Medium m(test::voxel_field(n, h, [&](const Vec3i& p) { return sigma(p[axis]); }), periodic);
        m.add_source([&](const Vec3i& p) { return q(p[axis]); });
        std::vector<Vec3d> directions;
        for (uint64_t s = 0; s < 12; ++s) directions.push_back(random_direction(s));
        SweepSet set = one_by_one(directions);
        for (size_t d = 0; d < directions.size(); ++d) set.inflow[d] = 0.5f + 0.25f * float(d);
        const SweepResult result = run(m, set, Which::Reference);
        for (size_t d = 0; d < directions.size(); ++d) {
            const double mu = directions[d][axis];
            double s0 = 0, q0 = 0, L = set.inflow[d];
            for (int k = 0; k < 19; ++k) {
                const int j = mu > 0 ? k : 18 - k;
                const double s1 = sigma(j), q1 = float(q(j)), tau = (s0 + s1) / 2 * h[axis] / std::abs(mu);
                if (k == 0) q0 = q1;
                const double e = std::exp(-tau);
                const double lean = (s1 - s0) * h[axis] / std::abs(mu) / (12 + 6 * tau + 2 * tau * tau);
                L = L * e + q1 * (1 - e) + (q0 - q1) * ((1 - e) / tau - e - lean);
                s0 = s1;
                q0 = q1;
                Vec3i p(3, 4, 5);
                p[axis] = j;
                ASSERT_NEAR(result.moments[d][m.index.blocks().slot(p)], L, 2e-6) << axis << ' ' << d << ' ' << j;
            }
            // Out of the last layer after half a voxel of it; into the first as it comes from outside.
            const double e = std::exp(-s0 * h[axis] / 2 / std::abs(mu)), out = L * e + q0 * (1 - e);
            SweepSet alone = one_by_one({directions[d]});
            alone.inflow = {set.inflow[d]};
            const SweepResult single = run(m, alone, Which::Reference);
            for (size_t f = 0; f < m.faces.size(); ++f) {
                const double cosine = (m.faces[f].face % 2 ? 1 : -1) * mu;
                ASSERT_NEAR(single.tally[f].current, cosine * (cosine > 0 ? out : set.inflow[d]), 2e-6);
                ASSERT_NEAR(single.tally[f].second, (cosine * cosine - 1.0 / 3) * (cosine > 0 ? out : set.inflow[d]),
                            2e-6);
            }
        }
    }
}

TEST(TransportSweep, SeesThroughTheVoidWhatLiesUpstream)
{
    // A glowing opaque cube of 40 voxels and small transparent probes about it, far and near. A probe sees 1 where the
    // line upstream passes through the cube, the sky's own radiance where it passes by; planes in the probe's block
    // spread a beam by at most 4 voxels to each side, which the margin of 8 leaves out.
    const int edge = 40;
    std::vector<Vec3i> probes;
    std::vector<std::pair<Vec3i, Vec3i>> boxes{{Vec3i(0), Vec3i(edge - 1)}};
    for (uint64_t k = 0; k < 24; ++k) {
        const Vec3d at = Vec3d(edge / 2.0) + (60 + 20 * double(k * k)) * random_direction(k);
        probes.emplace_back(int(at.x()), int(at.y()), int(at.z()));
        boxes.emplace_back(probes.back(), probes.back());
    }
    const auto grid = test::voxel_clouds(boxes, Vec3d(1.0), 1e-6);
    Medium m(grid);
    const Blocks& blocks = m.index.blocks();
    const Vec3i shift = m.index.origin();
    const auto in_cube = [&](const Vec3i& p) {
        const Vec3i q = p + shift;
        return q.x() >= 0 && q.y() >= 0 && q.z() >= 0 && q.x() < edge && q.y() < edge && q.z() < edge;
    };
    for (size_t slot = 0; slot < blocks.count() * 512; ++slot)
        if (blocks.active(slot) && in_cube(blocks.voxel(slot))) m.sigma[slot] = 50;
    m.add_source([&](const Vec3i& p) { return in_cube(p) ? 1.0 : 0.0; });
    std::vector<Vec3d> directions;
    for (uint64_t k = 0; k < 48; ++k) {
        const Vec3d aim(Vec3d(edge / 2.0) + (k % 3 ? 5 : 30) * random_direction(100 + k));
        const Vec3i& p = probes[k % probes.size()];
        directions.push_back((Vec3d(p.x(), p.y(), p.z()) - aim).unit());
    }
    SweepSet set = one_by_one(directions);
    for (size_t d = 0; d < directions.size(); ++d) set.inflow[d] = 2 + 0.125f * float(d);
    const SweepResult result = run(m, set, Which::Blocks);
    /// Whether the line upstream of p meets the cube grown by `by`.
    const auto meets = [&](const Vec3i& p, const Vec3d& s, double by) {
        double in = 0, out = 1e30;
        for (int a = 0; a < 3; ++a) {
            const double t0 = (p[a] - (-0.5 - by)) / s[a], t1 = (p[a] - (edge - 0.5 + by)) / s[a];
            in = std::max(in, std::min(t0, t1));
            out = std::min(out, std::max(t0, t1));
        }
        return in < out;
    };
    int cube = 0, sky = 0;
    for (const Vec3i& p : probes)
        for (size_t d = 0; d < directions.size(); ++d) {
            const float seen = result.moments[d][blocks.slot(p - shift)];
            if (meets(p, directions[d], -8)) {
                ++cube;
                EXPECT_NEAR(seen, 1, 1e-4) << p << ' ' << d;
            } else if (!meets(p, directions[d], 8)) {
                ++sky;
                EXPECT_NEAR(seen, set.inflow[d], 1e-4) << p << ' ' << d;
            }
        }
    EXPECT_GT(cube, 20);
    EXPECT_GT(sky, 800);
}

TEST(TransportSweep, CountsRaysThroughEdgesOfBlocksOnce)
{
    // Light along diagonals from a glowing cube meets edges and corners of cubes near (2 blocks) and far (25 blocks).
    // Radiance is a mean of the source, 1, and the dark sky: at the middle of the far cubes 1 - e^-tau of the cube that
    // glows, tau = 0.2 x 16 sqrt(2) or sqrt(3), times e^-tau of half a cube; a ray that counted twice would double it.
    for (int gap : {16, 200})
        for (const Vec3i& way : {Vec3i(1, 1, 0), Vec3i(0, 1, 1), Vec3i(1, 0, 1), Vec3i(1, 1, 1)}) {
            const Vec3i far = (16 + gap) * way;
            Medium m(test::voxel_clouds({{Vec3i(0), Vec3i(15)}, {far, far + Vec3i(15)}}, Vec3d(1.0), 0.2));
            m.add_source([&](const Vec3i& p) { return std::max({p.x(), p.y(), p.z()}) < 16 ? 1.0 : 0.0; });
            const Vec3d s = Vec3d(way.x(), way.y(), way.z()).unit();
            const SweepSet set = one_by_one({s});
            const SweepResult fast = run(m, set, Which::Blocks), slow = run(m, set, Which::Reference);
            const size_t middle = m.index.blocks().slot(far + Vec3i(7));
            EXPECT_NEAR(fast.moments[0][middle], slow.moments[0][middle], 1e-5) << way << gap;
            const double length = Vec3d(way.x(), way.y(), way.z()).length();
            EXPECT_NEAR(fast.moments[0][middle], (1 - std::exp(-0.2 * 16 * length)) * std::exp(-0.2 * 7.5 * length),
                        1e-4)
                << way << gap;
        }
}

/// A tenth of the blocks of a box of n^3 that begins at `near` along x, and one block that is `reach` blocks away along
/// x; 0: none.
Blocks scattered_blocks(int n, int reach, const Vec3i& period, int near = 0)
{
    std::vector<Block> blocks;
    for (int x = 0; x < n; ++x)
        for (int y = 0; y < n; ++y)
            for (int z = 0; z < n; ++z)
                if (uniform(hash_bits(8, uint64_t(x), uint64_t(y), uint64_t(z))) < 0.1) {
                    blocks.push_back({Vec3i(near + x, y, z), {}});
                    blocks.back().mask.fill(~uint64_t(0));
                }
    if (reach != 0) {
        blocks.push_back({Vec3i(near + reach, 3, 2), {}});
        blocks.back().mask.fill(~uint64_t(0));
    }
    return Blocks(std::move(blocks), period);
}

/// The nearest block upstream of a point by looking at all of them and their images; -1: none.
int nearest_block(const Blocks& blocks, const Vec3d& point, const Vec3d& step, double& t)
{
    int found = -1;
    t = 1e30;
    Vec3i images(0);
    for (int a = 0; a < 3; ++a) images[a] = blocks.period()[a] ? 6 : 0;
    for (size_t b = 0; b < blocks.count(); ++b)
        for (int i = -images[0]; i <= images[0]; ++i)
            for (int j = -images[1]; j <= images[1]; ++j)
                for (int k = -images[2]; k <= images[2]; ++k) {
                    const Vec3i at = blocks.at(b) + Vec3i(i, j, k) * blocks.period();
                    double in = -1e30, out = 1e30;
                    for (int a = 0; a < 3; ++a) {
                        const double t0 = (point[a] - (8 * at[a] - 0.5)) / step[a];
                        const double t1 = (point[a] - (8 * at[a] + 7.5)) / step[a];
                        in = std::max(in, std::min(t0, t1));
                        out = std::min(out, std::max(t0, t1));
                    }
                    if (in >= out || in < 0 || in >= t) continue;
                    t = in;
                    found = int(b);
                }
    return found;
}

void check_void_rays(const Blocks& blocks, int n, int reach, int fewest_hits, int near = 0)
{
    const VoidRays rays(blocks);
    int hits = 0, skies = 0;
    for (uint64_t k = 0; k < 600; ++k) {
        Vec3d point, step = random_direction(k);
        for (int a = 0; a < 3; ++a) {
            // Points also where no tile of the table is; a third of them aim along the line of the far block.
            point[a] = 8 * n * (1.5 * uniform(hash_bits(k, uint64_t(a), 5)) - 0.25);
            step[a] *= a == 0 && k % 3 == 0 && reach ? reach : 1 + a;
        }
        point[0] += 8 * near;
        const Vec3i at(int(std::floor((point[0] + 0.5) / 8)), int(std::floor((point[1] + 0.5) / 8)),
                       int(std::floor((point[2] + 0.5) / 8)));
        if (rays.find(at) >= 0) continue;
        double t;
        const int expected = nearest_block(blocks, point, step, t);
        const VoidRays::Hit hit = rays.trace(point, step);
        if (expected < 0 && blocks.period() != Vec3i(0) && hit.block >= 0) continue;  // beyond the images looked at
        ASSERT_EQ(hit.block, expected) << k;
        if (expected < 0) {
            ++skies;
            continue;
        }
        ++hits;
        int on_faces = 0;
        for (int a = 0; a < 3; ++a) {
            double in = point[a] - t * step[a] - 8 * blocks.at(size_t(expected))[a];
            if (blocks.period()[a]) in -= 8 * blocks.period()[a] * std::floor((in + 0.5001) / (8 * blocks.period()[a]));
            ASSERT_NEAR(hit.at[a], in, 1e-5) << k;
            if (!(hit.axes >> a & 1)) continue;
            ++on_faces;
            ASSERT_NEAR(hit.at[a], step[a] > 0 ? 7.5 : -0.5, 1e-9);
        }
        ASSERT_GE(on_faces, 1);
    }
    EXPECT_GT(hits, fewest_hits);
    if (blocks.period() == Vec3i(0)) {
        EXPECT_GT(skies, 100);
    }
}

TEST(VoidRays, FindTheNearestBlockUpstreamAndWhereItIsEntered)
{
    check_void_rays(scattered_blocks(20, 0, Vec3i(0)), 20, 0, 150);
    check_void_rays(scattered_blocks(12, 3000, Vec3i(0)), 12, 3000, 100);
}

/// Rays cross cells of 256^3 blocks in one step where they are empty: the cell 256..511 on the way from 520 to 0, no
/// more.
TEST(VoidRays, FindABlockBehindAnEmptyCellOfTheTable)
{
    const Blocks blocks = scattered_blocks(12, -520, Vec3i(0), 520);
    check_void_rays(blocks, 12, -520, 100, 520);
    // Straight at the block, from the near end of the others.
    const VoidRays rays(blocks);
    const VoidRays::Hit hit = rays.trace(Vec3d(8 * 515 + 3, 8 * 3 + 3.2, 8 * 2 + 4.1), Vec3d(1, 1e-6, 1e-6));
    ASSERT_GE(hit.block, 0);
    EXPECT_EQ(blocks.at(size_t(hit.block)), Vec3i(0, 3, 2));
}

/// Blocks of one voxel each.
Blocks single_blocks(const std::vector<Vec3i>& places)
{
    std::vector<Block> list;
    for (const Vec3i& at : places) list.push_back({at, {1, 0, 0, 0, 0, 0, 0, 0}});
    return Blocks(list);
}

TEST(VoidRays, TellBlocksApartThatLieARangeOfKeysApart)
{
    // 2^28 voxels and more between blocks at equal places of their tiles.
    const std::vector<Vec3i> places{Vec3i(-(1 << 26), 5, 5), Vec3i(0, 5, 5), Vec3i(1 << 25, 5, 5),
                                    Vec3i(1 << 26, 5, 5)};
    const Blocks blocks = single_blocks(places);
    const VoidRays rays(blocks);
    for (int n = 0; n < 4; ++n) {
        EXPECT_EQ(rays.find(places[size_t(n)]), n);
        EXPECT_EQ(rays.find(places[size_t(n)] + Vec3i(0, 0, 1 << 25)), -1);
        // From halfway, light that travels towards lower x comes from this block.
        if (n == 0) continue;
        const double between = 4.0 * places[size_t(n - 1)][0] + 4.0 * places[size_t(n)][0];
        const VoidRays::Hit hit = rays.trace(Vec3d(between, 43, 43), Vec3d(-1, 0, 0));
        EXPECT_EQ(hit.block, n);
        EXPECT_EQ(hit.axes, 1);
        EXPECT_EQ(rays.trace(Vec3d(between, 43, 43), Vec3d(1, 0, 0)).block, n - 1);
        EXPECT_EQ(rays.trace(Vec3d(between, 43, 43), Vec3d(0, 1, 0)).block, -1);
    }
}

TEST(VoidRays, TakeMemoryByTheBlockWhereverItLies)
{
    const auto bytes = [](int apart) {
        std::vector<Vec3i> places;
        for (int n = 0; n < 1000; ++n) places.push_back(Vec3i(n % 10, n / 10 % 10, n / 100) * apart);
        return double(VoidRays(single_blocks(places)).bytes()) / 1000;
    };
    EXPECT_GT(bytes(75), bytes(1));
    EXPECT_LT(bytes(75), 1500) << "each in a tile of its own";
    EXPECT_LT(bytes(10000000), 1500) << "and each in an empty cell of its own, of all but the largest sizes";
}

TEST(VoidRays, WrapAlongPeriodicAxes)
{
    check_void_rays(scattered_blocks(12, 0, Vec3i(12, 0, 12)), 12, 0, 300);
    check_void_rays(scattered_blocks(12, 0, Vec3i(0, 12, 0)), 12, 0, 200);
}

}  // namespace
}  // namespace vdbcloud
