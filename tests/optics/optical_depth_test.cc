// Optical depth against an independent sum over the interpolant, and against closed forms.
#include "vdbcloud/optics/optical_depth.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/optics/cell_march.h"

#include "support/fields.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

constexpr double far = 1e30;

/// A random ray through the middle region of a grid. The ray starts far outside the grid or inside.
WorldRay random_ray(const FloatGrid& grid, uint64_t seed)
{
    const auto bounds = grid.evalActiveVoxelBoundingBox();
    Vec3d p;
    for (int a = 0; a < 3; ++a)
        p[a] = bounds.min()[a] + uniform(hash_bits(seed, 10 + uint64_t(a))) * (bounds.max()[a] - bounds.min()[a]);
    const Vec3d x = grid.transform().indexToWorld(p), w = test::direction(seed);
    const double back = seed % 4 == 0 ? 0 : 1000 * grid.transform().voxelSize()[0];
    return {x - back * w, w};
}

void expect_exact(const FloatGrid& grid, int rays, const char* what)
{
    const BrickMap map(grid);
    double sum = 0;
    for (int n = 0; n < rays; ++n) {
        const auto ray = random_ray(grid, uint64_t(n));
        const double expected = test::integral_of_interpolant(grid, ray, 0, far);
        // Both sums are exact for the interpolant. They differ by the rounding of crossings at distances of 1e3 voxels.
        EXPECT_NEAR(density_depth(map, ray, 0, far), expected, 1e-9 * (1 + expected)) << what << ", ray " << n;
        sum += expected;
    }
    EXPECT_GT(sum, 0) << what << ": the rays met nothing, so nothing was tested";
}

TEST(OpticalDepth, IsExactForTheInterpolantUnderAnyAffineTransform)
{
    const auto clumps = [](Coord ijk) { return test::clumps(ijk, 3, 2.0); };
    using Transform = openvdb::math::Transform;
    const auto with = [&](const Transform::Ptr& transform) {
        auto grid = box({37, 29, 43}, 1, clumps);
        grid->setTransform(transform);
        return grid;
    };
    auto scaled = Transform::createLinearTransform(0.037);
    expect_exact(*with(scaled), 300, "scaled");
    auto turned = Transform::createLinearTransform(2.5);
    turned->postRotate(0.7, openvdb::math::X_AXIS);
    turned->postRotate(-1.1, openvdb::math::Y_AXIS);
    turned->postTranslate(Vec3d(100, -40, 7));
    expect_exact(*with(turned), 300, "turned");
    auto oblong = Transform::createLinearTransform(1.0);
    oblong->preScale(Vec3d(0.5, 2.0, 1.3));
    oblong->postShear(0.4, openvdb::math::X_AXIS, openvdb::math::Y_AXIS);
    expect_exact(*with(oblong), 300, "oblong and sheared");
    auto mirrored = Transform::createLinearTransform(1.0);
    mirrored->preScale(Vec3d(-1, 1, 1));
    expect_exact(*with(mirrored), 100, "mirrored");
}

TEST(OpticalDepth, IsExactAlongFacesAndEdgesAndThroughCorners)
{
    auto grid = box({24, 24, 24}, 1, [](Coord ijk) { return test::clumps(ijk, 5, 1.0) + 0.1; });
    const BrickMap map(*grid);
    const Vec3d directions[] = {{1, 0, 0},  {0, -1, 0}, {0, 0, 1},   {1, 1, 0},
                                {-1, 0, 1}, {1, 1, 1},  {-1, 1, -1}, {1, 2, 3}};
    for (const Vec3d& d : directions)
        for (const double shift : {0.0, 0.5, 1e-13}) {
            const Vec3d w = d.unit(), through(8 + shift, 8, 8 + shift);
            const WorldRay ray{through - 100 * w, w};
            const double expected = test::integral_of_interpolant(*grid, ray, 0, far);
            EXPECT_NEAR(density_depth(map, ray, 0, far), expected, 1e-9 * expected) << d << " shifted " << shift;
            // At 0 the ray runs in the face between two of the map's largest boxes.
            const WorldRay border{-100 * w, w};
            EXPECT_NEAR(density_depth(map, border, 0, far), test::integral_of_interpolant(*grid, border, 0, far), 1e-9)
                << "through the origin along " << d;
            const WorldRay back{through + 100 * w, -w};
            EXPECT_NEAR(density_depth(map, back, 0, far), expected, 1e-9 * expected) << "back along " << d;
        }
}

TEST(OpticalDepth, UniformAndLinearFieldsMatchTheirIntegral)
{
    // Density falls linearly to 0 within one voxel beyond edge voxels, so a box of n voxels has a depth of n voxels.
    const int n = 32;
    const double h = 0.25;
    const auto uniform_box = box({n, n, n}, h, [](Coord) { return 3.0; });
    const WorldRay along{{-5, 4 * h, 4.4 * h}, {1, 0, 0}};
    EXPECT_NEAR(density_depth(BrickMap(*uniform_box), along, 0, far), 3.0 * n * h, 1e-6);
    const auto ramp = box({n, n, n}, h, [](Coord ijk) { return 0.5 + 0.1 * ijk[0]; });
    EXPECT_NEAR(density_depth(BrickMap(*ramp), along, 0, far), (0.5 + 0.1 * (n - 1) / 2.0) * n * h, 1e-6);
}

TEST(OpticalDepth, IsAdditiveOverSegmentsAndSymmetric)
{
    const auto grid = box({30, 30, 30}, 1, [](Coord ijk) { return test::clumps(ijk, 9, 1.0); });
    const BrickMap map(*grid);
    const Vec3d o(-3, 2, 4), w = Vec3d(1, 0.6, 0.5).unit();
    const double whole = density_depth(map, {o, w}, 0, 60);
    ASSERT_GT(whole, 1);
    EXPECT_NEAR(density_depth(map, {o, w}, 0, 17.3) + density_depth(map, {o, w}, 17.3, 60), whole, 1e-12 * whole);
    EXPECT_NEAR(density_depth(map, {o + 60 * w, -w}, 0, 60), whole, 1e-12 * whole);
    EXPECT_EQ(density_depth(map, {o, -w}, 0, 60), 0);
}

TEST(OpticalDepth, IncludesActiveTilesAndDistantPieces)
{
    auto grid = openvdb::FloatGrid::create(0.0f);
    grid->fill(openvdb::CoordBBox(Coord(0, 0, 0), Coord(127, 127, 127)), 2.0f);  // tiles
    const int far_away = 1 << 29;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y)
            for (int z = 0; z < 8; ++z) grid->tree().setValueOn(Coord(far_away + x, 60 + y, 60 + z), 5.0f);
    ASSERT_GT(grid->tree().activeTileCount(), 0u);
    const BrickMap map(*grid);
    const WorldRay ray{{-10, 63.5, 63.5}, {1, 0, 0}};
    EXPECT_NEAR(density_depth(map, ray, 0, 1e5), 2.0 * 128, 1e-9);
    EXPECT_NEAR(density_depth(map, ray, 0, far), 2.0 * 128 + 5.0 * 8, 1e-6);  // distances of 5e8 round at 1e-7
    EXPECT_LT(map.bytes(), 20u << 20) << "constant bricks must share storage";
}

TEST(OpticalDepth, CrossesATileInAStepABrick)
{
    // Tiles of one value, of another, of zeros, and a leaf beside them; and the same voxels as leaves.
    auto tiles = FloatGrid::create();
    tiles->fill({Coord(0), Coord(127)}, 0.75f);
    tiles->fill({Coord(0, 0, 128), Coord(127, 127, 255)}, 0.0f);
    tiles->fill({Coord(0, 128, 0), Coord(7, 135, 7)}, 3.0f);
    tiles->tree().setValueOn(Coord(60, 60, 300), 2.0f);
    auto leaves = tiles->deepCopy();
    leaves->tree().voxelizeActiveTiles();
    ASSERT_LT(tiles->tree().leafCount(), 5u);
    for (const Vec3i& length : {Vec3i(0), Vec3i(128, 0, 0)}) {
        const BrickMap map(*tiles, 0, {}, {Vec3i(0), length}), dense(*leaves, 0, {}, {Vec3i(0), length});
        size_t pieces = 0, cells = 0;
        double sum = 0;
        for (int n = 0; n < 300; ++n) {
            WorldRay ray = random_ray(*tiles, uint64_t(n));
            if (length[0] > 0) ray.direction = Vec3d(1, 3, 3 * (n % 2)).unit();
            double cell_by_cell = 0;
            const IndexRay index(dense.index_from_world(), ray);
            march_cells(dense, index, 0, far, [&](double in, double out, const float* corners, const Vec3i& cell) {
                const Vec3d p = index.at(in) - Vec3d(cell[0], cell[1], cell[2]);
                cell_by_cell += (out - in) * along(corners, p, (out - in) * index.direction).integral(1);
                return ++cells, true;
            });
            // Crossings at distances of 1e3 voxels round to 1e-13 each, hundreds of them.
            EXPECT_NEAR(density_depth(map, ray, 0, far), cell_by_cell, 1e-10 * (1 + cell_by_cell)) << "ray " << n;
            sum += cell_by_cell;
            march_pieces(map, index, 0, far, [&](auto...) { return ++pieces, true; });
        }
        EXPECT_GT(sum, 300 * 5) << "the rays met little";
        // A brick has 8 cells along each axis, so a ray crosses 8 to 22 in one; 1 brick of 7 to 16 lies at a border.
        EXPECT_LT(double(pieces), 0.4 * double(cells));
        EXPECT_GT(pieces, 300u);
    }
}

TEST(OpticalDepth, ConvergesAtSecondOrderForSmoothFieldsAndFirstForJumps)
{
    // Parabola s0 (1 - r^2/R^2): tau = (4/3) s0 (R^2 - b^2)^1.5 / R^2. Uniform sphere: 2 s0 sqrt(R^2 - b^2).
    const auto error = [](int n, bool jump) {
        const double R = 1, h = 2.2 * R / n;
        auto grid = box({n, n, n}, h, [&](Coord ijk) {
            const Vec3d p = h * (Vec3d(ijk[0], ijk[1], ijk[2]) - Vec3d((n - 1) / 2.0));
            const double q = p.lengthSqr() / (R * R);
            return q > 1 ? 0.0 : jump ? 1.0 : 1 - q;
        });
        const BrickMap map(*grid);
        double sum = 0;
        int count = 0;
        for (uint64_t s = 0; s < 400; ++s) {
            const Vec3d w = test::direction(s), side = w.cross(test::direction(s + 1000)).unit();
            const double b = 0.8 * R * uniform(hash_bits(s, 77));
            const Vec3d centre(h * (n - 1) / 2.0);
            const double tau = density_depth(map, {centre + b * side - 5 * w, w}, 0, far);
            const double c = std::sqrt(R * R - b * b), exact = jump ? 2 * c : 4.0 / 3 * c * c * c / (R * R);
            sum += (tau - exact) * (tau - exact);
            ++count;
        }
        return std::sqrt(sum / count);
    };
    const double smooth = std::log2(error(24, false) / error(96, false)) / 2;
    EXPECT_GT(smooth, 1.9);
    // The error at a jump varies irregularly with resolution, so the slope is measured over a factor of 8.
    const double jump = std::log2(error(16, true) / error(128, true)) / 3;
    EXPECT_GT(jump, 0.9);
}

TEST(OpticalDepth, EmptyGridIsZeroAndFrustumIsRefused)
{
    const auto empty = openvdb::FloatGrid::create(0.0f);
    EXPECT_EQ(density_depth(BrickMap(*empty), {{0, 0, 0}, {1, 0, 0}}, 0, far), 0);
    empty->setTransform(
        openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(10)), 0.5, 10, 1));
    EXPECT_THROW(BrickMap{*empty}, InputError);
}

}  // namespace
}  // namespace vdbcloud
