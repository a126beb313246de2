// The light that reaches the voxels of one of several media, through all of them.
#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/optics/optical_depth.h"

#include "support/fields.h"
#include "support/moved.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;
using test::moved;

CrossedMedium crossed(const FloatGridPtr& density, const Vec3d& sigma_t)
{
    CrossedMedium one;
    one.density = density;
    one.medium.sigma_t_per_density = sigma_t;
    return one;
}

FloatGridPtr floats(const GridBasePtr& grid) { return openvdb::gridPtrCast<FloatGrid>(grid); }

/// A body whose density falls smoothly to 0 at a distance of 9 voxels.
FloatGridPtr puff()
{
    return box({20, 20, 20}, 1, [](Coord c) {
        const double r = (c.asVec3d() - Vec3d(9.5)).length() / 9;
        return r < 1 ? (1 - r * r) * (1 - r * r) : 0.0;
    });
}

double largest_difference(const FloatGrid& a, const FloatGrid& b)
{
    double most = 0;
    for (auto v = a.cbeginValueOn(); v; ++v)
        most = std::max(most, double(std::abs(*v - b.tree().getValue(v.getCoord()))));
    return most;
}

TEST(SeveralMedia, ASlabInTheShadowOfAnotherHasItsTransmittanceTimesTheirs)
{
    const double h = 0.5, tau = 0.9;
    const auto low = box({8, 16, 8}, h, [](Coord) { return 1.0; });
    // Twice as wide, so that all of the lower slab and its fringe lie in the shadow; 10 voxels thick.
    const auto high = moved(box({24, 10, 24}, h, [](Coord) { return 3.0; }), Vec3d(-4, 20, -4));
    const double sigma_high = tau / (10 * h * 3);
    const Light sun = make_sun(Vec3d(0, 1, 0));
    const auto alone = floats(transmittance_grid(*low, crossed(low, Vec3d(0.4)).medium, sun, {}));
    for (const size_t at : {size_t(0), size_t(1)}) {  // the order of the media does not matter
        std::vector<CrossedMedium> media{crossed(low, Vec3d(0.4)), crossed(high, Vec3d(sigma_high))};
        if (at == 1) std::swap(media[0], media[1]);
        const auto both = floats(transmittance_grid(media, at, sun, {}));
        EXPECT_EQ(both->activeVoxelCount(), alone->activeVoxelCount());
        EXPECT_EQ(both->transform(), low->transform());
        for (auto v = alone->cbeginValueOn(); v; ++v)
            EXPECT_NEAR(both->tree().getValue(v.getCoord()), std::exp(-tau) * *v, 3e-7) << v.getCoord();
        // The upper slab lies in nobody's shadow.
        const auto upper = floats(transmittance_grid(media, 1 - at, sun, {}));
        const auto upper_alone = floats(transmittance_grid(*high, crossed(high, Vec3d(sigma_high)).medium, sun, {}));
        EXPECT_EQ(largest_difference(*upper_alone, *upper), 0);
    }
}

TEST(SeveralMedia, OverlappingMediaShadeAsTheirSum)
{
    const auto a = box({24, 20, 28}, 1, [](Coord c) { return test::clumps(c, 3, 1.0); }),
               b = box({24, 20, 28}, 1, [](Coord c) { return test::clumps(c, 4, 2.0); });
    const auto sum = a->deepCopy();
    for (auto v = sum->beginValueOn(); v; ++v) v.setValue(0.2f * *v + 0.1f * b->tree().getValue(v.getCoord()));
    for (const Light& light :
         {make_sun(Vec3d(0.3, 1, 0.2)), make_sun(Vec3d(0.3, 1, 0.2), Vec3d(1), 20), make_lamp(Vec3d(30, 14, 9))}) {
        TransmittanceOptions o;
        o.disc_samples = 5;
        const auto one = floats(transmittance_grid(*sum, crossed(sum, Vec3d(1)).medium, light, o));
        const auto two = floats(transmittance_grid({crossed(a, Vec3d(0.2)), crossed(b, Vec3d(0.1))}, 0, light, o));
        EXPECT_LT(largest_difference(*two, *one), 2e-6) << light.name;  // depths are floats
        float least = 1;
        for (auto v = two->cbeginValueOn(); v; ++v) least = std::min(least, *v);
        EXPECT_LT(least, 0.3) << light.name;
    }
}

TEST(SeveralMedia, TheLatticeServesAnyShiftOfTheVoxels)
{
    const auto a = puff();
    const Light sun = make_sun(Vec3d(0.2, 1, -0.3));
    TransmittanceOptions exact;
    exact.fidelity = Fidelity::Exact;
    for (const Vec3d& shift : {Vec3d(0, 24, 0), Vec3d(-3, 29, 2), Vec3d(0.4, 21.7, -4.1)}) {
        const std::vector<CrossedMedium> media{crossed(a, Vec3d(0.1)), crossed(moved(a, shift), Vec3d(0.3))};
        const auto lattice = floats(transmittance_grid(media, 0, sun, {})),
                   rays = floats(transmittance_grid(media, 0, sun, exact));
        // Rays 1/3 voxel apart: (1/3)^2 / 8 times the curvature of the optical depth, 0.4 x 0.6 a voxel^2 along both
        // axes, times a transmittance of 0.6. Half the spacing has a quarter of that error.
        const double error = largest_difference(*lattice, *rays);
        EXPECT_LT(error, 4e-3) << shift;
        TransmittanceOptions fine;
        fine.rays_per_voxel = 6;
        EXPECT_LT(largest_difference(*floats(transmittance_grid(media, 0, sun, fine)), *rays), 0.35 * error) << shift;
        const auto alone = floats(transmittance_grid(*a, media[0].medium, sun, {}));
        EXPECT_GT(largest_difference(*lattice, *alone), 0.3) << shift;
    }
}

TEST(SeveralMedia, MediaOnOtherLatticesCastTheirExactShadow)
{
    const auto a = puff(), b = moved(puff(), Vec3d(16, 16, 1), 0.7, Vec3d(0.7, 1.3, 0.9));
    const BrickMap of_a(*a), of_b(*b);
    for (const int refine : {1, 2})
        for (const Light& light : {make_sun(Vec3d(0.2, 1, -0.3)), make_lamp(Vec3d(12, 45, 7))}) {
            TransmittanceOptions o;
            o.fidelity = Fidelity::Exact;
            o.refine = refine;
            const auto t = floats(transmittance_grid({crossed(a, Vec3d(0.1)), crossed(b, Vec3d(0.4))}, 0, light, o));
            EXPECT_NEAR(t->voxelSize()[0], 1.0 / refine, 1e-12);
            double shaded = 0;
            for (auto v = t->cbeginValueOn(); v; ++v) {
                const Vec3d x = t->indexToWorld(v.getCoord());
                const double of_other = 0.4 * depth_to_light(of_b, *light, x);
                EXPECT_NEAR(*v, std::exp(-0.1 * depth_to_light(of_a, *light, x) - of_other), 1e-6) << v.getCoord();
                shaded = std::max(shaded, of_other);
            }
            EXPECT_GT(shaded, 1) << light.name;
        }
}

TEST(SeveralMedia, OfADiscIsTheMeanOfProductsAndNotTheProductOfMeans)
{
    // Two opaque sheets over a point, each of which covers one half of the disc: none of the light passes if the halves
    // are different, half of it if they are the same one. The product of the two means is a quarter.
    const auto sheet = [](double y, int from, int to) {
        auto grid = FloatGrid::create(0.0f);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0));
        for (int x = from; x <= to; ++x)
            for (int z = -30; z <= 30; ++z) grid->tree().setValueOn(Coord(x, int(y), z), 1.0f);
        return grid;
    };
    auto point = FloatGrid::create(0.0f);
    point->tree().setValueOn(Coord(0, 0, 0), 1e-6f);
    const Light sun = make_sun(Vec3d(0, 1, 0), Vec3d(1), 20);
    TransmittanceOptions o;
    o.fidelity = Fidelity::Exact;
    o.disc_samples = 400;
    const auto left = sheet(40, -30, -1), right = sheet(60, 1, 30), left_again = sheet(60, -30, -1);
    const auto through = [&](const FloatGridPtr& p, const FloatGridPtr& q) {
        return floats(transmittance_grid({crossed(point, Vec3d(1)), crossed(p, Vec3d(1e4)), crossed(q, Vec3d(1e4))}, 0,
                                         sun, o))
            ->tree()
            .getValue(Coord(0, 0, 0));
    };
    // 400 points of a spiral give a half within 400^(-3/4); the sheets' edges are a voxel wide, 1/12 of the disc's
    // width.
    EXPECT_NEAR(through(left, left_again), 0.5, 0.06);
    EXPECT_NEAR(through(left, right), 0.0, 0.06);
}

TEST(SeveralMedia, AColouredMediumShadesAGreyOneInColour)
{
    const auto low = box({6, 6, 6}, 1, [](Coord) { return 1.0; }),
               high = moved(box({18, 4, 18}, 1, [](Coord) { return 1.0; }), Vec3d(-6, 20, -6));
    const auto t = openvdb::gridPtrCast<Vec3SGrid>(transmittance_grid(
        {crossed(low, Vec3d(0.1)), crossed(high, Vec3d(0, 0.25, 0.5))}, 0, make_sun(Vec3d(0, 1, 0)), {}));
    ASSERT_TRUE(t);
    const Vec3f v = t->tree().getValue(Coord(3, 2, 3));
    EXPECT_NEAR(v[0], std::exp(-0.35), 1e-6);
    EXPECT_NEAR(v[1], std::exp(-0.35 - 1), 1e-6);
    EXPECT_NEAR(v[2], std::exp(-0.35 - 2), 1e-6);
}

TEST(SeveralMedia, TakeTheGridOfOneAloneIfNoneShadesIt)
{
    const auto a = puff();
    const auto beside = moved(a, Vec3d(200, 0, 0)), above = moved(a, Vec3d(0, 30, 0)),
               turned = moved(a, Vec3d(0, 40, 0), 0.3);
    for (const Light& sun : {make_sun(Vec3d(0, 1, 0)), make_sun(Vec3d(0, 1, 0), Vec3d(1), 2)}) {
        const GridBasePtr own = transmittance_grid(*a, crossed(a, Vec3d(0.1)).medium, sun, {});
        const auto with = [&](const FloatGridPtr& other, const GridBasePtr& given) {
            return transmittance_grid({crossed(a, Vec3d(0.1)), crossed(other, Vec3d(0.1))}, 0, sun, {}, given);
        };
        EXPECT_EQ(with(beside, own), own);
        EXPECT_EQ(with(FloatGrid::create(0.0f), own), own);
        EXPECT_EQ(largest_difference(*floats(own), *floats(with(beside, nullptr))), 0);
        for (const auto& shading : {above, turned}) {
            const GridBasePtr shaded = with(shading, own);
            EXPECT_NE(shaded, own);
            EXPECT_GT(largest_difference(*floats(own), *floats(shaded)), 0.2);
            // No later stage may take it for the grid of one medium.
            EXPECT_EQ(get_text(*shaded, schema::density_digest, ""), "");
            EXPECT_EQ(shaded->getName(), "transmittance_sun");
            EXPECT_TRUE(read_light(*shaded, shaded->getName()));
        }
    }
}

TEST(SeveralMedia, CostTheirOwnVoxelsWhereverTheyLie)
{
    const auto a = puff(), far = moved(a, Vec3d(3e5, 2e6, 0));
    const Light sun = make_sun(Vec3d(3e5, 2e6, 1));
    const std::vector<CrossedMedium> media{crossed(a, Vec3d(0.1)), crossed(far, Vec3d(0.1))};
    const auto near = floats(transmittance_grid(media, 0, sun, {}));
    EXPECT_EQ(near->activeVoxelCount(), floats(transmittance_grid(*a, media[0].medium, sun, {}))->activeVoxelCount());
    EXPECT_LT(near->tree().getValue(Coord(10, 1, 10)), 0.5);
}

TEST(SeveralMedia, DoNotDependOnThreads)
{
    const auto a = puff();
    const std::vector<CrossedMedium> media{crossed(a, Vec3d(0.1)),
                                           crossed(moved(a, Vec3d(0.4, 21.7, -4.1)), Vec3d(0.3)),
                                           crossed(moved(a, Vec3d(3, 40, 0), 0.4), Vec3d(0.2))};
    const Light sun = make_sun(Vec3d(0.1, 1, 0.1));
    const auto many = floats(transmittance_grid(media, 0, sun, {}));
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(largest_difference(*many, *floats(transmittance_grid(media, 0, sun, {}))), 0);
}

}  // namespace
}  // namespace vdbcloud
