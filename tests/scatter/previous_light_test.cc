// Light of an earlier frame at the voxels of this one, in closed form: fields linear in space are sampled exactly.
#include "vdbcloud/scatter/previous_light.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/voxels/voxel_index.h"

#include "scatter/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using openvdb::math::Transform;

/// A lattice about the origin, turned and of no cubes.
Transform::Ptr lattice(double edge, double angle)
{
    const auto transform = Transform::createLinearTransform(edge);
    transform->preScale(Vec3d(1, 1.3, 0.8));
    transform->postRotate(angle, openvdb::math::Y_AXIS);
    return transform;
}

/// f at the places of voxels -14..14 along each axis; of a staggered grid each component at its own place.
template<typename GridT, typename F>
typename GridT::Ptr field(const Transform::Ptr& transform, const F& f)
{
    const auto grid = GridT::create();
    grid->setTransform(transform->copy());
    auto set = grid->getAccessor();
    for (int i = -14; i <= 14; ++i)
        for (int j = -14; j <= 14; ++j)
            for (int k = -14; k <= 14; ++k) set.setValue(Coord(i, j, k), f(Vec3d(i, j, k)));
    return grid;
}

Vec3d flow(const Vec3d& x) { return Vec3d(0.3 * x[0] - 0.2, 0.4 - 0.2 * x[1] + 0.1 * x[0], 0.25 * x[2]); }
double fluence_at(const Vec3d& x) { return 20 + 3 * x[0] - 2 * x[1] + x[2]; }
Vec3d flux_at(const Vec3d& x) { return Vec3d(2 + x[1], -1 + 0.5 * x[2], 3 - x[0]); }
double moment_at(const Vec3d& x, int m) { return 0.3 * m - 1 + 0.2 * x[m % 3]; }

PreviousLight earlier()
{
    const auto then = lattice(0.2, 0.4), own = lattice(0.3, -0.7);
    PreviousLight previous;
    CollidedLight& light = previous.light;
    light.channel_scale = Vec3d(1, 2, 4);
    light.phi = field<FloatGrid>(then, [&](const Vec3d& i) { return float(fluence_at(then->indexToWorld(i))); });
    light.flux.fill(field<Vec3SGrid>(then, [&](const Vec3d& i) { return Vec3f(flux_at(then->indexToWorld(i))); }));
    std::vector<FloatGridPtr> moments;
    for (int m = 0; m < 5; ++m)
        moments.push_back(
            field<FloatGrid>(then, [&](const Vec3d& i) { return float(moment_at(then->indexToWorld(i), m)); }));
    light.moments.fill(moments);
    previous.velocity = field<Vec3SGrid>(own, [&](const Vec3d& i) {
        Vec3f v;
        for (int a = 0; a < 3; ++a) {
            Vec3d face = i;
            face[a] -= 0.5;
            v[a] = float(flow(own->indexToWorld(face))[a]);
        }
        return v;
    });
    previous.velocity->setGridClass(openvdb::GRID_STAGGERED);
    previous.seconds = 0.5;
    return previous;
}

/// The medium now: 6 x 5 x 4 turned voxels that are no cubes.
FloatGridPtr medium_now()
{
    const Vec3d x = Vec3d(2, 1, -2) / 3, y = Vec3d(-2, 2, -1) / 3, z = Vec3d(1, 2, 2) / 3;
    const auto grid = test::voxel_field(Vec3i(6, 5, 4), 0.1 * x, 0.15 * y, 0.2 * z, [](const Vec3i&) { return 1.0; });
    grid->transform().postTranslate(Vec3d(-0.2, 0.1, 0.3));
    return grid;
}

TEST(PreviousLight, IsSampledWhereMatterCameFrom)
{
    const VoxelIndex index(*medium_now());
    for (const int channel : {0, 2}) {
        const double scale = channel == 0 ? 1 : 4;
        const StartingLight start = starting_light(earlier(), index, channel, 2);
        ASSERT_EQ(start.moments.size(), 9u);
        size_t slots = 0;
        for (size_t slot = 0; slot < index.blocks().slots(); ++slot) {
            if (!index.blocks().active(slot)) continue;
            ++slots;
            EXPECT_TRUE(start.known[slot]);
            const Vec3d now = index.world(Vec3d(index.blocks().voxel(slot))), then = now - 0.5 * flow(now);
            EXPECT_NEAR(start.moments[0][slot], scale * fluence_at(then) / std::sqrt(4 * pi), 1e-4);
            // The moments about the axes of the index describe the radiance that those about the world's do.
            for (const Vec3d& s : {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0.6, 0, 0.8), Vec3d(1, -2, 2) / 3}) {
                const Vec3d world = s[0] * index.axis(0) + s[1] * index.axis(1) + s[2] * index.axis(2);
                double of_index[9], of_world[9], found = 0, second = 0;
                evaluate_harmonics(2, s, of_index);
                evaluate_harmonics(2, world, of_world);
                for (int m = 1; m < 9; ++m) found += double(start.moments[size_t(m)][slot]) * of_index[m];
                for (int m = 0; m < 5; ++m) second += moment_at(then, m) * of_world[4 + m];
                EXPECT_NEAR(found, scale * (3 / (4 * pi) * flux_at(then).dot(world) + second), 1e-4);
            }
        }
        EXPECT_EQ(slots, 120u);
    }
}

TEST(PreviousLight, IsNotKnownBeyondTheEarlierMedium)
{
    PreviousLight previous = earlier();
    previous.seconds = 0;
    const auto phi = openvdb::gridPtrCast<FloatGrid>(previous.light.phi);
    for (auto v = phi->beginValueOn(); v; ++v)
        if (v.getCoord().x() < 0) v.setValueOff();
    const VoxelIndex index(*medium_now());
    const StartingLight start = starting_light(previous, index, 1, 2);
    int known = 0;
    for (size_t slot = 0; slot < index.blocks().slots(); ++slot) {
        if (!index.blocks().active(slot)) continue;
        const Vec3d place = phi->worldToIndex(index.world(Vec3d(index.blocks().voxel(slot))));
        EXPECT_EQ(start.known[slot] != 0, std::round(place[0]) >= 0) << place;
        if (!start.known[slot]) {
            EXPECT_EQ(start.moments[0][slot], 0);
        }
        known += start.known[slot];
    }
    EXPECT_GT(known, 10);
    EXPECT_LT(known, 110);
}

}  // namespace
}  // namespace vdbcloud
