// Several media as one: extinction, scattering and emission of the joined medium are the sums of those of its parts.
#include "vdbcloud/optics/joined_medium.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"

#include "support/fields.h"
#include "support/grids.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using test::box;
using test::sentence;

Medium medium(const Vec3d& sigma_t, const Vec3d& albedo = Vec3d(1), double g = 0)
{
    Medium m;
    m.sigma_t_per_density = sigma_t;
    m.albedo = albedo;
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

/// A clumpy body of 20^3 voxels of edge h, a third of them empty.
FloatGridPtr body(uint64_t seed, double h = 1)
{
    const auto grid = box({20, 20, 20}, h, [&](Coord ijk) { return test::clumps(ijk, seed, 1.0); });
    for (auto v = grid->beginValueOn(); v; ++v)
        if (*v == 0) v.setValueOff();
    return grid;
}

/// `grid` with its transform followed by a turn, a scaling of its axes and a move.
FloatGridPtr placed(const FloatGridPtr& grid, const Vec3d& scale, double angle, const Vec3d& move)
{
    const auto out = grid->deepCopy();
    const auto transform = grid->transform().copy();
    transform->preScale(scale);
    transform->postRotate(angle, openvdb::math::Z_AXIS);
    transform->postRotate(0.6 * angle, openvdb::math::X_AXIS);
    transform->postTranslate(move);
    out->setTransform(transform);
    return out;
}

double voxel_volume(const GridBase& grid) { return std::abs(grid.transform().baseMap()->determinant()); }

/// Integral of the extinction over space [world unit^2], red.
double optical_mass(const FloatGrid& density, const Medium& m)
{
    double sum = 0;
    for (auto v = density.cbeginValueOn(); v; ++v) sum += double(*v) * double(v.getVoxelCount());
    return m.sigma_t_per_density[0] * voxel_volume(density) * sum;
}

/// Integral of the scattering coefficient over space, of one channel, voxel by voxel.
double scattering_mass(const FloatGrid& density, const Medium& m, const Vec3SGrid* colour, int c)
{
    double sum = 0;
    for (auto v = density.cbeginValueOn(); v; ++v) {
        const double tint = colour ? colour->tree().getValue(v.getCoord())[c] : 1.0;
        sum += std::min(1.0, m.albedo[c] * tint) * double(*v) * double(v.getVoxelCount());
    }
    return m.sigma_t_per_density[c] * voxel_volume(density) * sum;
}

Vec3SGridPtr colour_like(const FloatGrid& density, uint64_t seed)
{
    auto grid = Vec3SGrid::create(Vec3f(1.0f));
    grid->setTransform(density.transform().copy());
    for (auto v = density.cbeginValueOn(); v; ++v) {
        const auto bits = hash_bits(seed, uint64_t(v.getCoord()[0]), uint64_t(v.getCoord()[1] * 64 + v.getCoord()[2]));
        grid->tree().setValueOn(v.getCoord(), Vec3f(float(uniform(bits)), 0.5f, float(uniform(bits + 1))));
    }
    return grid;
}

TEST(JoinedMedium, DensityIsTheSumVoxelByVoxel)
{
    const auto a = body(1), b = body(2);
    const JoinedMedium joined =
        joined_medium({{"a", a, medium(Vec3d(3)), nullptr, nullptr}, {"b", b, medium(Vec3d(3)), nullptr, nullptr}});
    EXPECT_EQ(joined.colour, nullptr);
    EXPECT_EQ(joined.emission, nullptr);
    EXPECT_TRUE(joined.resampled.empty());
    EXPECT_EQ(joined.medium.sigma_t_per_density, Vec3d(3));
    int both = 0, one = 0;
    for (const Coord& ijk : CoordBBox(Coord(-2), Coord(22))) {
        const bool in_a = a->tree().isValueOn(ijk), in_b = b->tree().isValueOn(ijk);
        EXPECT_EQ(joined.density->tree().isValueOn(ijk), in_a || in_b) << ijk;
        EXPECT_EQ(joined.density->tree().getValue(ijk), a->tree().getValue(ijk) + b->tree().getValue(ijk)) << ijk;
        both += in_a && in_b;
        one += in_a != in_b;
    }
    EXPECT_GT(both, 500);
    EXPECT_GT(one, 500);
}

TEST(JoinedMedium, ExtinctionsAddWhateverTheUnitOfEachDensity)
{
    const auto a = body(1), b = body(2);
    const Medium ma = medium(Vec3d(0.5, 1, 2)), mb = medium(Vec3d(3.5, 7, 14));
    const JoinedMedium joined = joined_medium({{"a", a, ma, nullptr, nullptr}, {"b", b, mb, nullptr, nullptr}});
    for (auto v = joined.density->cbeginValueOn(); v; ++v)
        for (int c = 0; c < 3; ++c) {
            const double sum = ma.sigma_t_per_density[c] * a->tree().getValue(v.getCoord()) +
                               mb.sigma_t_per_density[c] * b->tree().getValue(v.getCoord());
            EXPECT_NEAR(joined.medium.sigma_t_per_density[c] * *v, sum, 2e-7 * sum);  // floats: two roundings
        }
}

TEST(JoinedMedium, InactiveValuesAndBackgroundsDoNotCount)
{
    const auto a = FloatGrid::create(5.0f), b = FloatGrid::create(0.0f);
    a->tree().setValueOn(Coord(1, 2, 3), 2.0f);
    b->tree().setValueOn(Coord(1, 2, 4), 3.0f);
    b->tree().setValueOff(Coord(1, 2, 3), 7.0f);
    const JoinedMedium joined =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, nullptr}, {"b", b, medium(Vec3d(1)), nullptr, nullptr}});
    EXPECT_EQ(joined.density->activeVoxelCount(), 2u);
    EXPECT_EQ(joined.density->background(), 0.0f);
    EXPECT_EQ(joined.density->tree().getValue(Coord(1, 2, 3)), 2.0f);
    EXPECT_EQ(joined.density->tree().getValue(Coord(1, 2, 4)), 3.0f);
    EXPECT_EQ(joined.density->tree().getValue(Coord(1, 2, 5)), 0.0f);
}

TEST(JoinedMedium, CostsTilesAndLeavesWhereverThePartsLie)
{
    const auto a = FloatGrid::create(0.0f), b = FloatGrid::create(0.0f), far = body(3);
    a->tree().fill(CoordBBox(Coord(0), Coord(127)), 1.0f);
    b->tree().fill(CoordBBox(Coord(0), Coord(127)), 2.0f);
    for (auto* grid : {a.get(), b.get()}) grid->setTransform(far->transform().copy());
    const auto moved = placed(far, Vec3d(1), 0, Vec3d(1e6, -3e5, 2e5));
    const JoinedMedium joined = joined_medium({{"a", a, medium(Vec3d(1)), nullptr, nullptr},
                                               {"b", b, medium(Vec3d(1)), nullptr, nullptr},
                                               {"far", moved, medium(Vec3d(1)), nullptr, nullptr}});
    EXPECT_TRUE(joined.resampled.empty());
    EXPECT_EQ(joined.density->tree().activeTileCount(), a->tree().activeTileCount());
    EXPECT_LE(joined.density->tree().leafCount(), moved->tree().leafCount());  // one has no active voxel
    EXPECT_EQ(joined.density->activeVoxelCount(), 128u * 128 * 128 + moved->activeVoxelCount());
    EXPECT_EQ(joined.density->tree().getValue(Coord(17, 100, 3)), 3.0f);
    EXPECT_EQ(joined.density->tree().getValue(Coord(1000005, -299993, 200005)), moved->tree().getValue(Coord(5, 7, 5)));
}

TEST(JoinedMedium, MovesByWholeVoxelsAreExact)
{
    const auto a = body(1, 0.1), b = placed(body(2, 0.1), Vec3d(1), 0, Vec3d(0.3, -1.1, 0.8));
    const JoinedMedium joined =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, nullptr}, {"b", b, medium(Vec3d(1)), nullptr, nullptr}});
    EXPECT_TRUE(joined.resampled.empty());
    for (auto v = joined.density->cbeginValueOn(); v; ++v)
        EXPECT_EQ(*v, a->tree().getValue(v.getCoord()) + b->tree().getValue(v.getCoord().offsetBy(-3, 11, -8)));
}

TEST(JoinedMedium, ScatteringIsTheSumVoxelByVoxel)
{
    const auto a = body(1), b = body(2), c = body(4);
    const Medium ma = medium(Vec3d(1), Vec3d(0.9, 0.5, 0.2)), mb = medium(Vec3d(2), Vec3d(0.3, 0.8, 0)),
                 mc = medium(Vec3d(0.25), Vec3d(0.1));
    const auto ca = colour_like(*a, 5), cc = colour_like(*c, 6);
    const JoinedMedium joined =
        joined_medium({{"a", a, ma, ca, nullptr}, {"b", b, mb, nullptr, nullptr}, {"c", c, mc, cc, nullptr}});
    ASSERT_TRUE(joined.colour);
    EXPECT_EQ(joined.medium.albedo, Vec3d(0.9, 0.8, 0.2));
    for (auto v = joined.density->cbeginValueOn(); v; ++v) {
        const Coord ijk = v.getCoord();
        if (*v == 0) continue;
        for (int k = 0; k < 3; ++k) {
            const double sum = 1.0 * ma.albedo[k] * ca->tree().getValue(ijk)[k] * a->tree().getValue(ijk) +
                               2.0 * mb.albedo[k] * b->tree().getValue(ijk) +
                               0.25 * mc.albedo[k] * cc->tree().getValue(ijk)[k] * c->tree().getValue(ijk);
            const double ours = double(*v) * joined.medium.albedo[k] * joined.colour->tree().getValue(ijk)[k];
            EXPECT_NEAR(ours, sum, 1e-6 * *v) << ijk << k;
        }
    }
}

TEST(JoinedMedium, ColourReachesOneVoxelBeyondTheDensity)
{
    // Two white cubes of other albedos, far apart: within the trilinear fringe of each, the albedo is its own.
    const auto a = box({4, 4, 4}, 1, [](Coord) { return 1.0; }), b = placed(a, Vec3d(1), 0, Vec3d(20, 0, 0));
    const JoinedMedium joined = joined_medium({{"a", a, medium(Vec3d(1), Vec3d(0.8)), nullptr, nullptr},
                                               {"b", b, medium(Vec3d(1), Vec3d(0.2)), nullptr, nullptr}});
    ASSERT_TRUE(joined.colour);
    EXPECT_EQ(joined.colour->activeVoxelCount(), 2 * 6u * 6 * 6);
    for (const int x : {-1, 0, 3, 4}) {
        EXPECT_EQ(joined.colour->tree().getValue(Coord(x, -1, 4)), Vec3f(1.0f));
        EXPECT_NEAR(joined.colour->tree().getValue(Coord(20 + x, -1, 4))[1], 0.25f, 1e-7);
    }
}

TEST(JoinedMedium, AlbedosAboveOneAreClampedAsInPictures)
{
    const auto a = box({4, 4, 4}, 1, [](Coord) { return 1.0; });
    auto colour = Vec3SGrid::create(Vec3f(1.0f));
    colour->tree().fill(CoordBBox(Coord(-2), Coord(5)), Vec3f(1.5f, 0.5f, 1.0f));
    const JoinedMedium joined = joined_medium({{"a", a, medium(Vec3d(1), Vec3d(0.8)), colour, nullptr},
                                               {"b", a, medium(Vec3d(1), Vec3d(0.4)), nullptr, nullptr}});
    const Vec3d albedo = joined.medium.albedo * Vec3d(joined.colour->tree().getValue(Coord(1, 2, 3)));
    EXPECT_NEAR(albedo[0], (1 + 0.4) / 2, 1e-7);
    EXPECT_NEAR(albedo[1], (0.4 + 0.4) / 2, 1e-7);
    EXPECT_NEAR(albedo[2], (0.8 + 0.4) / 2, 1e-7);
}

TEST(JoinedMedium, ResamplingKeepsOpticalMassAndScattering)
{
    const auto a = body(1, 0.5);
    for (const double angle : {0.0, 0.7})
        for (const Vec3d& scale : {Vec3d(2), Vec3d(3, 1.5, 2), Vec3d(1)}) {
            if (angle == 0 && scale == Vec3d(1)) continue;
            const auto b = placed(body(2, 0.5), scale, angle, Vec3d(0.17, 2.3, -1.9));
            const Medium ma = medium(Vec3d(4), Vec3d(0.9)), mb = medium(Vec3d(1), Vec3d(0.6, 0.9, 0.3));
            const JoinedMedium joined = joined_medium({{"a", a, ma, nullptr, nullptr}, {"b", b, mb, nullptr, nullptr}});
            EXPECT_EQ(joined.density->transform(), a->transform());
            EXPECT_NEAR(optical_mass(*joined.density, joined.medium) / (optical_mass(*a, ma) + optical_mass(*b, mb)), 1,
                        2e-6)
                << scale << angle;  // sums of 1e4 floats
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(scattering_mass(*joined.density, joined.medium, joined.colour.get(), c) /
                                (scattering_mass(*a, ma, nullptr, c) + scattering_mass(*b, mb, nullptr, c)),
                            1, 2e-6)
                    << scale << angle << c;
            ASSERT_EQ(joined.resampled.size(), 1u);
            EXPECT_EQ(joined.resampled[0].name, "b");
            // A clumpy field, whose values change by a half from voxel to voxel: sampling errs by some percent at most.
            EXPECT_NEAR(joined.resampled[0].correction, 1, 0.05);
            EXPECT_NE(joined.resampled[0].correction, 1);
        }
}

TEST(JoinedMedium, ResampledDensityIsTheInterpolantOfThePart)
{
    // A linear ramp is its own interpolant, on any lattice, away from its ends; b is turned and twice as coarse.
    const auto a = box({16, 16, 16}, 0.5, [](Coord) { return 0.5; });
    const auto b = placed(box({10, 10, 10}, 0.5, [](Coord ijk) { return 1 + 0.1 * ijk[0] + 0.03 * ijk[2]; }), Vec3d(2),
                          0.7, Vec3d(2, -1, 0.3));
    const JoinedMedium joined =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, nullptr}, {"b", b, medium(Vec3d(1)), nullptr, nullptr}});
    int inside = 0;
    for (auto v = joined.density->cbeginValueOn(); v; ++v) {
        const Vec3d p = b->transform().worldToIndex(joined.density->indexToWorld(v.getCoord()));
        if (p[0] < 0 || p[1] < 0 || p[2] < 0 || p[0] > 9 || p[1] > 9 || p[2] > 9) continue;
        const double expected = joined.resampled.at(0).correction * (1 + 0.1 * p[0] + 0.03 * p[2]) +
                                (a->tree().isValueOn(v.getCoord()) ? 0.5 : 0);
        EXPECT_NEAR(*v, expected, 1e-6 * expected) << v.getCoord();
        ++inside;
    }
    EXPECT_NEAR(inside, 9 * 9 * 9 * 8, 300) << "every voxel within b has a value";
    EXPECT_NEAR(joined.resampled.at(0).correction, 1, 2e-3);
}

TEST(JoinedMedium, AShiftOfHalfAVoxelIsInterpolated)
{
    const auto a = FloatGrid::create(0.0f), b = FloatGrid::create(0.0f);
    a->tree().setValueOn(Coord(0, 0, 0), 3.0f);
    b->tree().setValueOn(Coord(0, 0, 0), 1.0f);
    const auto joined =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, nullptr},
                       {"b", placed(b, Vec3d(1), 0, Vec3d(0.5, 0, 0)), medium(Vec3d(1)), nullptr, nullptr}});
    EXPECT_EQ(joined.density->activeVoxelCount(), 2u);
    EXPECT_EQ(joined.density->tree().getValue(Coord(0, 0, 0)), 3.5f);
    EXPECT_EQ(joined.density->tree().getValue(Coord(1, 0, 0)), 0.5f);
}

TEST(JoinedMedium, EmissionIsTheSumAndKeepsItsPower)
{
    const auto a = body(1), b = body(2);
    const auto glow = [](const FloatGrid& like, const Vec3f& colour) {
        auto grid = Vec3SGrid::create(Vec3f(0.0f));
        grid->setName("emission");
        grid->setTransform(like.transform().copy());
        for (auto v = like.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), *v * colour);
        return grid;
    };
    const auto power = [](const Vec3SGrid& grid) {
        Vec3d sum(0.0);
        for (auto v = grid.cbeginValueOn(); v; ++v) sum += Vec3d(*v);
        return voxel_volume(grid) * sum;
    };
    const auto ea = glow(*a, Vec3f(1, 2, 4)), eb = glow(*b, Vec3f(3, 0, 1));
    const JoinedMedium same =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, ea}, {"b", b, medium(Vec3d(1)), nullptr, eb}});
    ASSERT_TRUE(same.emission);
    EXPECT_EQ(same.emission->getName(), "emission");
    for (auto v = same.emission->cbeginValueOn(); v; ++v)
        EXPECT_EQ(*v, ea->tree().getValue(v.getCoord()) + eb->tree().getValue(v.getCoord()));

    const auto turned = placed(b, Vec3d(1.5), 0.4, Vec3d(3, 1, 0));
    const auto et = glow(*turned, Vec3f(3, 0, 1));
    const JoinedMedium other =
        joined_medium({{"a", a, medium(Vec3d(1)), nullptr, ea}, {"b", turned, medium(Vec3d(1)), nullptr, et}});
    const Vec3d sum = power(*ea) + power(*et), ours = power(*other.emission);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(ours[c] / sum[c], 1, 2e-6);
}

TEST(JoinedMedium, DoesNotDependOnTheOrderOfThePartsOrOnThreads)
{
    const auto a = body(1), b = placed(body(2), Vec3d(1.5, 2, 1), 0.5, Vec3d(2, 3, 1)), c = body(5);
    std::vector<MediumPart> parts{{"a", a, medium(Vec3d(2), Vec3d(0.9)), colour_like(*a, 2), nullptr},
                                  {"b", b, medium(Vec3d(1), Vec3d(0.7)), nullptr, nullptr},
                                  {"c", c, medium(Vec3d(3), Vec3d(0.5)), nullptr, nullptr}};
    const JoinedMedium first = joined_medium(parts);
    {
        const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const JoinedMedium serial = joined_medium(parts);
        EXPECT_EQ(grid_digest(*serial.density), grid_digest(*first.density));
        for (auto v = first.colour->cbeginValueOn(); v; ++v)
            ASSERT_EQ(*v, serial.colour->tree().getValue(v.getCoord()));
    }
    std::reverse(parts.begin(), parts.end());
    const JoinedMedium last = joined_medium(parts);
    EXPECT_EQ(last.density->activeVoxelCount(), first.density->activeVoxelCount());
    for (auto v = first.density->cbeginValueOn(); v; ++v) {
        const double ours = first.medium.sigma_t_per_density[0] * *v,
                     theirs = last.medium.sigma_t_per_density[0] * last.density->tree().getValue(v.getCoord());
        EXPECT_NEAR(ours, theirs, 1e-6 * ours);
        for (int k = 0; k < 3 && *v > 0; ++k)
            EXPECT_NEAR(first.colour->tree().getValue(v.getCoord())[k], last.colour->tree().getValue(v.getCoord())[k],
                        1e-5);
    }
}

TEST(JoinedMedium, PartsWithoutDensityGiveTheirEmissionAlone)
{
    const auto a = body(1), empty = FloatGrid::create(0.0f);
    auto glow = Vec3SGrid::create(Vec3f(0.0f));
    glow->tree().setValueOn(Coord(40, 0, 0), Vec3f(1.0f));
    const JoinedMedium joined = joined_medium({{"fire", empty, medium(Vec3d(7, 1, 2), Vec3d(0.3), 0.2), nullptr, glow},
                                               {"a", a, medium(Vec3d(2), Vec3d(0.9), 0.8), nullptr, nullptr}});
    EXPECT_EQ(joined.lead, 1u);
    EXPECT_EQ(joined.medium.sigma_t_per_density, Vec3d(2));
    EXPECT_EQ(joined.medium.albedo, Vec3d(0.9));
    EXPECT_EQ(joined.medium.phase, PhaseFunction::henyey_greenstein(0.8));
    EXPECT_EQ(joined.colour, nullptr);
    EXPECT_EQ(joined.emission->tree().getValue(Coord(40, 0, 0)), Vec3f(1.0f));
    EXPECT_EQ(grid_digest(*joined.density), grid_digest(*a));
}

TEST(JoinedMedium, RefusesWhatOneMediumCannotHoldByTheNamesOfBoth)
{
    const auto a = body(1), b = body(2);
    const auto refused = [&](const MediumPart& p, const MediumPart& q) {
        const std::string text = sentence<UsageError>([&] { joined_medium({p, q}); });
        EXPECT_NE(text.find(p.name), std::string::npos) << text;
        EXPECT_NE(text.find(q.name), std::string::npos) << text;
        return text;
    };
    const auto part = [](const char* name, const FloatGridPtr& grid, const Medium& m) {
        return MediumPart{name, grid, m, nullptr, nullptr};
    };
    const std::string colours =
        refused(part("one.vdb", a, medium(Vec3d(1, 2, 3))), part("two.vdb", b, medium(Vec3d(1))));
    EXPECT_NE(colours.find("--extinction"), std::string::npos) << colours;
    EXPECT_NE(refused(part("one.vdb", a, medium(Vec3d(1, 0, 3))), part("two.vdb", b, medium(Vec3d(1, 1, 3)))), "");
    const std::string phases =
        refused(part("one.vdb", a, medium(Vec3d(1))), part("two.vdb", b, medium(Vec3d(1), Vec3d(0.5), 0.3)));
    EXPECT_NE(phases.find("--phase"), std::string::npos) << phases;
    // Soot that absorbs only has no phase function to speak of.
    EXPECT_NO_THROW(
        joined_medium({part("one", a, medium(Vec3d(1), Vec3d(1), 0.8)), part("two", b, medium(Vec3d(1), Vec3d(0)))}));
    EXPECT_EQ(
        joined_medium({part("two", b, medium(Vec3d(1), Vec3d(0))), part("one", a, medium(Vec3d(1), Vec3d(1), 0.8))})
            .medium.phase,
        PhaseFunction::henyey_greenstein(0.8));
    // Each lattice is finer along one axis.
    const auto flat = placed(a, Vec3d(2, 0.4, 1), 0, Vec3d(0.0));
    const std::string text = sentence<UsageError>([&] {
        joined_medium({part("one", flat, medium(Vec3d(1))), part("two", b, medium(Vec3d(1)))});
    });
    EXPECT_NE(text.find("two"), std::string::npos) << text;
    EXPECT_NE(text.find("render"), std::string::npos) << text;
}

TEST(JoinedMedium, RefusesVoxelsThatHoldTooManyOfTheFinest)
{
    const auto coarse = box({2, 2, 2}, 1, [](Coord) { return 1.0; });
    const auto refused = [&](double ratio, const Vec3d& away) {
        const auto fine = placed(box({2, 2, 2}, 1 / ratio, [](Coord) { return 1.0; }), Vec3d(1), 0, away);
        return sentence<UsageError>([&] {
            joined_medium({{"coarse.vdb", coarse, medium(Vec3d(1)), nullptr, nullptr},
                           {"fine.vdb", fine, medium(Vec3d(1)), nullptr, nullptr}});
        });
    };
    // Eight bricks of 8^3 voxels hold the interpolant: 8 (8 x 10 + 2)^3 samples, 8 (8 x 64 + 2)^3 and so on.
    EXPECT_EQ(refused(10, Vec3d(0.0)), "");
    for (const double ratio : {64.0, 1e3, 1e4}) {
        const std::string text = refused(ratio, Vec3d(0.0));
        EXPECT_EQ(text.find("coarse.vdb: "), 0u) << text;
        EXPECT_NE(text.find("2^28"), std::string::npos) << text;
    }
    // An index is a whole number of 32 bits.
    EXPECT_EQ(refused(10, Vec3d(1e7, 0, 0)), "");
    const std::string far = refused(10, Vec3d(2e8, 0, 0));
    EXPECT_EQ(far.find("coarse.vdb: lies more than 2^30 voxels"), 0u) << far;
}

}  // namespace
}  // namespace vdbcloud
