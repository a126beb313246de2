// Pass one against rays of its own for each voxel, which are exact, and against closed forms.
#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"

#include "support/fields.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

Medium grey(double sigma_t)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    return m;
}

Light sun(const Vec3d& to) { return make_sun(to); }

FloatGridPtr floats(const GridBasePtr& grid) { return openvdb::gridPtrCast<openvdb::FloatGrid>(grid); }

struct Difference {
    double mean = 0, max = 0;
    int64_t count = 0;
};

Difference compare(const FloatGrid& a, const FloatGrid& b)
{
    Difference d;
    auto other = b.getConstAccessor();
    for (auto v = a.cbeginValueOn(); v; ++v) {
        const double e = std::abs(*v - other.getValue(v.getCoord()));
        d.mean += e;
        d.max = std::max(d.max, e);
        ++d.count;
    }
    d.mean /= double(d.count);
    return d;
}

TEST(TransmittanceGrid, OnTheLatticeIsExactWhereDensityIsUniformAcrossTheLight)
{
    // A slab that fills the lattice, light along an axis: nothing to interpolate, so both agree to rounding (float).
    const auto slab = box({40, 24, 40}, 0.5, [](Coord ijk) { return 0.2 + 0.01 * ijk[1]; });
    const Vec3d axes[] = {{0, 1, 0}, {0, -1, 0}};
    for (const Vec3d& to : axes) {
        const auto lattice = floats(transmittance_grid(*slab, grey(0.7), sun(to), {}));
        const auto exact = floats(transmittance_grid(*slab, grey(0.7), sun(to), {Fidelity::Exact}));
        EXPECT_LT(compare(*lattice, *exact).max, 2e-7) << to;
        EXPECT_LT(exact->tree().getValue(Coord(20, to[1] > 0 ? 0 : 23, 20)), 0.2);
    }
}

TEST(TransmittanceGrid, OfASlabIsTheExponentialOfItsDepth)
{
    const double h = 0.5, sigma = 0.7;
    const auto slab = box({9, 32, 9}, h, [](Coord) { return 1.0; });
    const auto t = floats(transmittance_grid(*slab, grey(sigma), sun({0, 1, 0}), {}));
    for (int j = 0; j < 32; ++j)  // from the voxel's centre up: half a voxel, the voxels above, the ramp's half
        EXPECT_NEAR(t->tree().getValue(Coord(4, j, 4)), std::exp(-sigma * h * (32 - j - 0.5 + 0.0)), 2e-7) << j;
}

TEST(TransmittanceGrid, OnTheLatticeApproachesTheExactOneForAnyDirection)
{
    // A thresholded field with edges one voxel wide, several mean free paths thick. Bilinear interpolation between
    // rays errs by O(spacing^2) of the depth's curvature, which at edges is all that counts.
    const auto field = box({48, 40, 56}, 1, [](Coord ijk) { return test::clumps(ijk, 21, 1.0) > 0.2 ? 1.0 : 0.0; });
    const Vec3d directions[] = {{0.3, 1, 0.2}, {-1, 0.7, 0.4}, {0.1, -0.2, -1}, {1, 1, 1}, {0.5, -1, 0.5}, {1, 0, 0}};
    for (const Vec3d& to : directions) {
        const auto exact = floats(transmittance_grid(*field, grey(0.3), sun(to), {Fidelity::Exact}));
        const auto one = floats(transmittance_grid(*field, grey(0.3), sun(to), {Fidelity::Lattice, 1}));
        TransmittanceReport said;
        const auto two = floats(transmittance_grid(*field, grey(0.3), sun(to), {Fidelity::Lattice, 2}, {}, &said));
        const auto four = floats(transmittance_grid(*field, grey(0.3), sun(to), {Fidelity::Lattice, 4}));
        const auto e1 = compare(*one, *exact), e2 = compare(*two, *exact), e4 = compare(*four, *exact);
        EXPECT_LT(e2.mean, 0.45 * e1.mean + 1e-7) << to;  // edges curve, so a little less than the 4 of order 2
        EXPECT_LT(e4.mean, 0.45 * e2.mean + 1e-7) << to;
        EXPECT_LT(e2.mean, 5e-3) << to;  // every second voxel of this field is at an edge: clouds have a tenth of that
        EXPECT_EQ(e2.count, said.voxels);
        EXPECT_NEAR(said.mean_error, e2.mean, 0.5 * e2.mean + 1e-6) << "what the report says is what is so";
    }
}

TEST(TransmittanceGrid, RefinedHasDensitysCentresAndExactValuesBetweenThem)
{
    auto field = box({20, 20, 20}, 0.5, [](Coord ijk) { return test::clumps(ijk, 8, 1.0); });
    field->transform().postTranslate(Vec3d(-6, 1, 2));
    const Light light = sun({0.3, 1, 0.2});
    TransmittanceOptions fine, fine_exact;
    fine.refine = fine_exact.refine = 3;
    fine_exact.fidelity = Fidelity::Exact;
    const auto plain = floats(transmittance_grid(*field, grey(0.5), light, {}));
    const auto lattice = floats(transmittance_grid(*field, grey(0.5), light, fine));
    const auto exact = floats(transmittance_grid(*field, grey(0.5), light, fine_exact));
    EXPECT_EQ(lattice->activeVoxelCount(), 27 * plain->activeVoxelCount());
    const auto at = lattice->getConstAccessor();
    for (auto v = plain->cbeginValueOn(); v; ++v) {
        const Coord ijk = v.getCoord(), three(3 * ijk[0], 3 * ijk[1], 3 * ijk[2]);
        EXPECT_NEAR(*v, at.getValue(three), 1e-6) << ijk;  // of single-precision sums of other steps
        EXPECT_LT((plain->indexToWorld(ijk) - lattice->indexToWorld(three)).length(), 1e-12);
    }
    EXPECT_LT(compare(*lattice, *exact).mean, 5e-3);  // of the lattice's own interpolation, as at density's voxels
}

TEST(TransmittanceGrid, FollowsAnyTransform)
{
    const auto plain = box({30, 30, 30}, 1, [](Coord ijk) { return test::clumps(ijk, 2, 1.0); });
    const auto turned = plain->deepCopy();
    auto transform = openvdb::math::Transform::createLinearTransform(0.1);
    transform->postRotate(0.5, openvdb::math::Z_AXIS);
    transform->postTranslate(Vec3d(5, 6, 7));
    turned->setTransform(transform);
    const Vec3d to = Vec3d(0.3, 1, 0.2).unit();
    const Vec3d to_turned = (transform->indexToWorld(to) - transform->indexToWorld(Vec3d(0))).unit();
    const auto a = floats(transmittance_grid(*plain, grey(0.2), sun(to), {}));
    const auto b = floats(transmittance_grid(*turned, grey(2.0), sun(to_turned), {}));
    EXPECT_LT(compare(*a, *b).max, 1e-5);  // slopes of 1e-16 times distances, exponentials of floats
    EXPECT_LT(test::trilinear(a->getConstAccessor(), Vec3d(15, 2, 15)), 0.9);
}

TEST(TransmittanceGrid, OfAPointLightInsideIsTheDepthToItsPosition)
{
    const auto ball = box({33, 33, 33}, 1, [](Coord) { return 1.0; });
    const Light lamp = make_lamp(Vec3d(16, 16, 16));
    const auto t = floats(transmittance_grid(*ball, grey(0.25), lamp, {}));
    EXPECT_EQ(t->tree().getValue(Coord(16, 16, 16)), 1.0f);
    EXPECT_NEAR(t->tree().getValue(Coord(26, 16, 16)), std::exp(-2.5), 1e-7);
    EXPECT_NEAR(t->tree().getValue(Coord(20, 19, 16)), std::exp(-1.25), 1e-7);
}

TEST(TransmittanceGrid, HasItsVoxelsWhereLightIsNeededAndOneElsewhere)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    grid->tree().setValueOn(Coord(7, 8, 9), 1.0f);
    const auto t = floats(transmittance_grid(*grid, grey(1), sun({0, 1, 0}), {}));
    EXPECT_EQ(t->activeVoxelCount(), 27u);
    EXPECT_EQ(t->background(), 1.0f);
    EXPECT_EQ(t->getName(), "transmittance_sun");
    EXPECT_NEAR(t->tree().getValue(Coord(7, 7, 9)), std::exp(-1.0), 1e-6);
    EXPECT_EQ(t->tree().getValue(Coord(7, 9, 9)), 1.0f);
    const auto light = read_light(*t, t->getName());
    ASSERT_TRUE(light);
    EXPECT_EQ(light->place(), Vec3d(0, 1, 0));
    EXPECT_EQ(get_text(*t, schema::density_digest, ""), grid_digest(*grid));
}

TEST(TransmittanceGrid, OfAColouredMediumHasThreeChannels)
{
    const auto slab = box({8, 16, 8}, 1, [](Coord) { return 1.0; });
    Medium m;
    m.sigma_t_per_density = Vec3d(0.1, 0.2, 0.4);
    const auto t = openvdb::gridPtrCast<openvdb::Vec3SGrid>(transmittance_grid(*slab, m, sun({0, 1, 0}), {}));
    ASSERT_TRUE(t);
    const auto v = t->tree().getValue(Coord(4, 5, 4));
    EXPECT_NEAR(v[0], std::exp(-0.1 * 10.5), 1e-6);
    EXPECT_NEAR(v[1], v[0] * v[0], 1e-6);
    EXPECT_NEAR(v[2], v[1] * v[1], 1e-6);
}

/// Share of a disc of angular radius `radius` that lies beyond a great circle at angular distance `beyond` from its
/// centre, |beyond| < radius [rad].
double share_beyond(double beyond, double radius)
{
    const double area = 2 * (std::acos(std::sin(beyond) / std::sin(radius)) -
                             std::cos(radius) * std::acos(std::tan(beyond) / std::tan(radius)));
    return area / (2 * M_PI * (1 - std::cos(radius)));
}

/// An opaque half plane x < 24 at height 40, one voxel thick, and a row of points along x at height 2 under its edge.
FloatGridPtr half_plane()
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->setName("density");
    for (int x = 0; x < 24; ++x)
        for (int z = -10; z <= 10; ++z) grid->tree().setValueOn(Coord(x, 40, z), 1.0f);
    for (int x = 16; x <= 32; ++x) grid->tree().setValueOn(Coord(x, 2, 0), 1e-9f);
    return grid;
}

struct Placement {
    const char* name;
    openvdb::math::Transform::Ptr transform;
};

/// The same body upright, turned by odd angles, and mirrored.
std::vector<Placement> placements()
{
    std::vector<Placement> out;
    for (const char* name : {"upright", "turned", "mirrored"}) {
        auto transform = openvdb::math::Transform::createLinearTransform(0.1);
        if (out.size() == 1) {
            transform->postRotate(0.7, openvdb::math::Z_AXIS);
            transform->postRotate(1.1, openvdb::math::X_AXIS);
            transform->postTranslate(Vec3d(3, -4, 5));
        } else if (out.size() == 2) {
            transform->postScale(Vec3d(-1, 1, 1));
        }
        out.push_back({name, transform});
    }
    return out;
}

/// A direction of index space in world space.
Vec3d turned(const Placement& where, const Vec3d& index)
{
    return (where.transform->indexToWorld(index) - where.transform->indexToWorld(Vec3d(0.0))).unit();
}

TEST(TransmittanceGrid, PenumbraOfAHalfPlaneIsTheShareOfTheDiscBesideIt)
{
    const double radius = 10 * M_PI / 180;
    TransmittanceOptions o;
    o.fidelity = Fidelity::Exact;
    o.disc_samples = 400;
    // The interpolant of the plane fills 39 < y < 41 and ends at x = 24. At 1e4 mean free paths a voxel light passes
    // within 0.02 voxels of its edge, 1e-3 of the penumbra. 400 points of a spiral give a straight cut's share within
    // 400^(-3/4) = 0.011.
    const Medium opaque = grey(1e4 / 0.1);
    for (const Placement& where : placements()) {
        const auto density = half_plane();
        density->setTransform(where.transform);
        const Light wide = make_sun(turned(where, Vec3d(0, 1, 0)), Vec3d(1.0), 20);
        const auto t = floats(transmittance_grid(*density, opaque, wide, o));
        int between = 0;
        for (int x = 16; x <= 32; ++x) {
            const double inside = 24 - x;  // a ray clears the lower edge from under the plane, the upper from beside it
            const double beyond = std::atan(inside / (inside > 0 ? 39.0 - 2 : 41.0 - 2));
            const double expected = beyond >= radius ? 0 : beyond <= -radius ? 1 : share_beyond(beyond, radius);
            EXPECT_NEAR(t->tree().getValue(Coord(x, 2, 0)), expected, 0.013) << where.name << ' ' << x;
            between += expected > 0.02 && expected < 0.98;
        }
        EXPECT_GE(between, 11) << "points in the penumbra";
    }
}

TEST(TransmittanceGrid, LatticeOfADiscIsTheMeanOfExactRays)
{
    const auto field = box({24, 24, 24}, 1, [](Coord ijk) { return test::clumps(ijk, 5, 1.0); });
    const Light wide = make_sun(Vec3d(0.3, 1, 0.2), Vec3d(1.0), 30);
    TransmittanceOptions lattice, exact;
    exact.fidelity = Fidelity::Exact;
    lattice.disc_samples = exact.disc_samples = 8;
    TransmittanceReport said;
    const auto a = floats(transmittance_grid(*field, grey(0.3), wide, lattice, {}, &said));
    const auto b = floats(transmittance_grid(*field, grey(0.3), wide, exact));
    const auto point = floats(transmittance_grid(*field, grey(0.3), make_sun(wide.place()), exact));
    const auto difference = compare(*a, *b);
    EXPECT_LT(difference.mean, 2e-3);  // of bilinear interpolation between the lattice's rays
    EXPECT_GT(compare(*point, *b).mean, 10 * difference.mean) << "the disc matters more than the lattice's error";
    EXPECT_NEAR(said.mean_error, difference.mean, 0.3 * difference.mean);
}

TEST(TransmittanceGrid, IsInvariantUnderRotationAndMirroring)
{
    const auto body = box({20, 24, 18}, 0.1, [](Coord ijk) { return test::clumps(ijk, 9, 1.0); });
    for (const Fidelity fidelity : {Fidelity::Lattice, Fidelity::Exact})
        for (const int refine : {1, 2}) {
            TransmittanceOptions o;
            o.fidelity = fidelity;
            o.refine = refine;
            FloatGridPtr of_sun, of_lamp;
            for (const Placement& where : placements()) {
                body->setTransform(where.transform);
                const auto under_sun =
                    floats(transmittance_grid(*body, grey(3), make_sun(turned(where, Vec3d(0.3, 1, 0.2))), o));
                const auto under_lamp = floats(transmittance_grid(
                    *body, grey(3), make_lamp(where.transform->indexToWorld(Vec3d(25, 11.3, 7))), o));
                if (!of_sun) {
                    of_sun = under_sun;
                    of_lamp = under_lamp;
                    EXPECT_LT(of_sun->tree().getValue(Coord(10, 2, 9)), 0.9);
                    continue;
                }
                // Directions differ by 1e-16 times distances, exponentials are floats.
                EXPECT_LT(compare(*of_sun, *under_sun).max, 1e-5) << where.name << ' ' << refine;
                EXPECT_LT(compare(*of_lamp, *under_lamp).max, 1e-5) << where.name << ' ' << refine;
            }
        }
}

TEST(TransmittanceGrid, RefinedPointsOfASlabAreTheExponentialOfTheirDepth)
{
    const double h = 0.5, sigma = 0.7;
    const auto slab = box({9, 16, 9}, h, [](Coord) { return 1.0; });
    for (const Fidelity fidelity : {Fidelity::Lattice, Fidelity::Exact}) {
        TransmittanceOptions o;
        o.fidelity = fidelity;
        o.refine = 3;
        const auto t = floats(transmittance_grid(*slab, grey(sigma), sun({0, 1, 0}), o));
        for (int n = 0; n <= 45; ++n)  // at voxel n / 3; half a voxel of the ramp lies above the last centre
            EXPECT_NEAR(t->tree().getValue(Coord(12, n, 12)), std::exp(-sigma * h * (15.5 - n / 3.0)), 2e-7) << n;
    }
}

TEST(TransmittanceGrid, DoesNotDependOnTheNumberOfThreads)
{
    const auto field = box({50, 50, 50}, 1, [](Coord ijk) { return test::clumps(ijk, 4, 1.0); });
    const auto run = [&](int threads) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(threads));
        return floats(transmittance_grid(*field, grey(0.3), sun({0.3, 1, 0.2}), {}));
    };
    EXPECT_EQ(compare(*run(1), *run(2)).max, 0);
}

}  // namespace
}  // namespace vdbcloud
