// Grids as envelopes, and the distances they are made of.
#include "vdbcloud/fractal/mask_envelope.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/distance_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

TEST(SignedDistance, IsTheDistanceToTheNearestVoxelOfTheOtherKind)
{
    for (const double share : {0.5, 0.05, 0.97}) {
        const Vec3i n(9, 7, 12);
        const Vec3d h(1, 0.5, 2);
        std::vector<uint8_t> set(size_t(n.product()));
        for (size_t v = 0; v < set.size(); ++v) set[v] = uniform(hash_bits(3, v)) < share;
        const auto d = signed_distance(n, h, set);
        const auto at = [&](size_t v) {
            const size_t row = v / 12, layer = row / 7;
            return Vec3d(double(layer), double(row % 7), double(v % 12)) * h;
        };
        for (size_t v = 0; v < set.size(); ++v) {
            double nearest = 1e15;
            for (size_t w = 0; w < set.size(); ++w)
                if (set[v] != set[w]) nearest = std::min(nearest, (at(v) - at(w)).length());
            ASSERT_NEAR(d[v], (set[v] ? 1 : -1) * (nearest - 0.25), 1e-5) << v;
        }
    }
}

TEST(SignedDistance, IsGreatWhereThereIsNoVoxelOfTheOtherKind)
{
    EXPECT_LT(signed_distance({2, 2, 2}, {1, 1, 1}, std::vector<uint8_t>(8, 0))[3], -1e14);
    EXPECT_GT(signed_distance({2, 2, 2}, {1, 1, 1}, std::vector<uint8_t>(8, 1))[3], 1e14);
}

/// A ball of radius 1.2 about (1, 2, 3), as fog or as a level set, on a grid that is turned and sheared.
FloatGridPtr ball(bool level_set)
{
    auto grid = FloatGrid::create(level_set ? 0.3f : 0.0f);
    auto transform = Transform::createLinearTransform(0.06);
    transform->postRotate(0.4, openvdb::math::Y_AXIS);
    transform->postTranslate({0.7, 1.6, 3.3});
    grid->setTransform(transform);
    grid->setGridClass(level_set ? openvdb::GRID_LEVEL_SET : openvdb::GRID_FOG_VOLUME);
    auto accessor = grid->getAccessor();
    for (int i = -40; i <= 40; ++i)
        for (int j = -40; j <= 40; ++j)
            for (int k = -40; k <= 40; ++k) {
                const double d = (grid->indexToWorld(openvdb::Coord(i, j, k)) - Vec3d(1, 2, 3)).length() - 1.2;
                if (level_set) {
                    if (std::abs(d) < 0.3)
                        accessor.setValue({i, j, k}, float(d));
                    else if (d < 0)
                        accessor.setValueOff({i, j, k}, -0.3f);
                } else if (d < 0) {
                    accessor.setValue({i, j, k}, 5.0f);
                }
            }
    return grid;
}

TEST(MaskEnvelope, HasTheDepthOfTheBodyInWorldSpace)
{
    const Box domain{{-1, 0, 1}, {3, 4, 5}};
    for (bool level_set : {false, true}) {
        const auto envelope = mask_envelope(*ball(level_set), domain, {50, 60, 40});
        double most = 0;
        for (int s = 0; s < 2000; ++s) {
            float x[3], d;
            for (int a = 0; a < 3; ++a)
                x[a] = float(domain.low[a] + 4 * uniform(hash_bits(9, uint64_t(s), uint64_t(a))));
            envelope->depth({}, 1, &x[0], &x[1], &x[2], &d);
            most = std::max(most, std::abs(d - (1.2 - (Vec3d(x[0], x[1], x[2]) - Vec3d(1, 2, 3)).length())));
            // Bounds hold for balls around the point.
            Envelope::Parts near;
            const auto range = envelope->select({}, {{x[0] + 0.1f, x[1], x[2] - 0.1f}, 0.15f}, -1e30f, near);
            ASSERT_TRUE(range.low <= d && d <= range.high);
        }
        // The border is known to half a diagonal of the domain's voxels, 0.07, and fog's to half of its own
        // besides.
        EXPECT_LT(most, level_set ? 0.08 : 0.12);
    }
}

TEST(MaskEnvelope, OfFogIsWhereItIsAboveALevelOfItsGreatestValue)
{
    // Fog that rises from 0 at x = 0 to 8 at x = 4: the border lies at x = 4 level, to half a voxel of 0.05.
    auto fog = FloatGrid::create(0.0f);
    fog->setTransform(Transform::createLinearTransform(0.1));
    fog->setGridClass(openvdb::GRID_FOG_VOLUME);
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j < 20; ++j)
            for (int k = 0; k < 20; ++k) fog->tree().setValueOn({i, j, k}, 0.2f * float(i));
    for (double level : {0.25, 0.5, 0.8}) {
        const auto envelope = mask_envelope(*fog, {{0, 0.5, 0.5}, {4, 1.5, 1.5}}, {80, 20, 20}, level);
        for (double x : {4 * level - 0.3, 4 * level + 0.3}) {
            const float p = float(x), q = 1;
            float depth;
            envelope->depth({}, 1, &p, &q, &q, &depth);
            EXPECT_NEAR(depth, x - 4 * level, 0.03) << level;
        }
    }
}

TEST(MaskEnvelope, BoundsHoldTheActiveVoxelsOfATurnedGrid)
{
    const auto box = mask_bounds(*ball(false));
    for (int d = 0; d < 3; ++d) {  // around a turned box: at least the ball, at most sqrt(2) of it, and a voxel
        EXPECT_LT(box.low[d], Vec3d(1, 2, 3)[d] - 1.15);
        EXPECT_GT(box.low[d], Vec3d(1, 2, 3)[d] - 1.2 * std::sqrt(2) - 0.1);
        EXPECT_GT(box.high[d], Vec3d(1, 2, 3)[d] + 1.15);
    }
    EXPECT_THROW(mask_bounds(*FloatGrid::create(0.0f)), InputError);
    EXPECT_THROW(mask_envelope(*ball(false), {{10, 10, 10}, {11, 11, 11}}, {8, 8, 8}), InputError);
}

}  // namespace
}  // namespace vdbcloud
