// Bodies far apart in one map: its tables, and how rays find the boxes that hold bricks.
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/cell_march.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace vdbcloud {
namespace {

FloatGridPtr voxels_at(const std::vector<Vec3i>& places)
{
    auto grid = FloatGrid::create(0.0f);
    for (const Vec3i& at : places) grid->tree().setValue(openvdb::Coord(at[0], at[1], at[2]), 2.0f);
    return grid;
}

/// `count` voxels at random within `reach` of 0, each in a leaf of its own.
std::vector<Vec3i> scattered(int count, double reach)
{
    std::vector<Vec3i> places;
    for (int n = 0; n < count; ++n) {
        Vec3i at;
        for (int a = 0; a < 3; ++a) at[a] = int(reach * (2 * uniform(hash_bits(7, uint64_t(n), uint64_t(a))) - 1));
        places.push_back(at);
    }
    return places;
}

TEST(BrickMap, TablesTakeMemoryByTheBrickWhereverItLies)
{
    for (const int apart : {600, 5000, 100000000 / 10}) {
        std::vector<Vec3i> places;
        for (int n = 0; n < 300; ++n) places.push_back(Vec3i(n % 7, n / 7 % 7, n / 49) * apart);
        const BrickMap map(*voxels_at(places));
        EXPECT_EQ(map.bricks().size(), 300u * 8) << "a voxel in the corner of a brick feeds eight";
        const double values = 8 * 729 * 4, bytes = double(map.bytes()) / 300;
        EXPECT_GT(bytes, values);
        // Two tables of bits for each brick, at most: the eight may lie in eight cells of 128^3.
        EXPECT_LT(bytes, values + 8 * (700 + 5300) * (apart > 4096 ? 1.0 : 0.15)) << apart;
        for (const Vec3i& at : places) {
            EXPECT_EQ(map.sample(Vec3d(at[0], at[1], at[2])), 2) << at;
            EXPECT_EQ(map.sample(Vec3d(at[0] + 0.5, at[1], at[2] - 0.25)), 0.75) << at;
            EXPECT_EQ(map.sample(Vec3d(at[0] + 300, at[1], at[2])), 0) << at;
        }
    }
}

TEST(BrickMap, RaysFindTheRootsThatTheyMeetAmongMany)
{
    const auto places = scattered(2000, 1 << 29);
    const BrickMap map(*voxels_at(places));
    ASSERT_GT(map.roots().size(), 1900u);
    size_t met = 0, tested = 0;
    constexpr int rays = 300;
    for (int n = 0; n < rays; ++n) {
        // Two thirds of the rays aim at a voxel.
        const Vec3i aim = places[size_t(n)], start = scattered(rays, 1 << 29)[size_t(rays - 1 - n)];
        Vec3d to = Vec3d(aim[0], aim[1], aim[2]) - Vec3d(start[0], start[1], start[2]);
        if (n % 3 == 0) to = Vec3d(uniform(hash_bits(n, 1)) - 0.5, uniform(hash_bits(n, 2)) - 0.5, 0.3);
        const IndexRay ray(map.index_from_world(), {Vec3d(start[0], start[1], start[2]), to.unit()});
        march_detail::RootHits hits;
        march_detail::find_roots(map, ray, 0, 1e12, hits);
        std::set<const BrickMap::Root*> found, expected;
        for (size_t k = 0; k < hits.count; ++k) found.insert(hits.begin()[k].root);
        for (const BrickMap::Root& root : map.roots()) {
            double t0 = 0, t1 = 1e12;
            const Vec3d lo(root.first[0], root.first[1], root.first[2]);
            const Vec3d hi(root.last[0] + 1.0, root.last[1] + 1.0, root.last[2] + 1.0);
            if (clip(ray, lo, hi, t0, t1)) expected.insert(&root);
        }
        EXPECT_EQ(found, expected) << n;
        met += found.size();
        tested += hits.tested;
        int cells = 0;
        march_cells(map, ray, 0, 1e12, [&](double, double, const float*, const Vec3i&) { return ++cells, true; });
        if (n % 3 != 0) {
            EXPECT_GE(cells, 1) << n;
        }
    }
    EXPECT_GE(met, size_t(rays) * 2 / 3);
    EXPECT_LT(double(tested) / rays, 200) << "of 2000 roots";
}

TEST(BrickMap, EmptinessInARootIsCrossedInLargeSteps)
{
    std::vector<Vec3i> places{{5, 5, 5}, {4090, 4090, 4090}};
    for (const Vec3i& at : scattered(12, 2000)) places.push_back(at + Vec3i(2047));
    const BrickMap map(*voxels_at(places));
    ASSERT_EQ(map.roots().size(), 1u);
    const BrickMap::Root& root = map.roots()[0];
    std::map<int, int> sizes;
    for (int n = 0; n < 100000; ++n) {
        // Half of the cells lie near a voxel.
        const Vec3i cell =
            n % 2 ? places[size_t(n) % places.size()] / 64 * 64 + Vec3i(n / 2 % 64, n / 128 % 64, n / 999 % 64)
                  : Vec3i(int(hash_bits(n, 1) % 4096), int(hash_bits(n, 2) % 4096), int(hash_bits(n, 3) % 4096));
        const int32_t super = BrickMap::super_at(root, cell);
        if (super >= 0 && map.number_at(super, cell) >= 0) continue;
        const int shift = map.empty_shift(root, super, cell);
        ++sizes[shift];
        const auto same = [&](const Vec3i& b) {
            for (int a = 0; a < 3; ++a)
                if ((b[a] * 8) >> shift != cell[a] >> shift) return false;
            return true;
        };
        ASSERT_TRUE(std::none_of(map.bricks().begin(), map.bricks().end(), same)) << cell;
    }
    ASSERT_EQ(sizes.size(), 4u);
    for (const int shift : {3, 5, 7, 9}) EXPECT_GT(sizes[shift], 0) << shift;
    // A diagonal row of places of 512 cells: 8 of them, and three crossings of a plane for each.
    const IndexRay ray(map.index_from_world(), {Vec3d(0.5, 3, 4), Vec3d(1, 1.01, 0.99).unit()});
    int steps = 0;
    double t = 0;
    for (Vec3i cell(0, 3, 4); cell[0] < 4096 && cell[1] < 4096 && cell[2] < 4096; ++steps) {
        const int32_t super = BrickMap::super_at(root, cell);
        const bool brick = super >= 0 && map.number_at(super, cell) >= 0;
        const int shift = brick ? 3 : map.empty_shift(root, super, cell);
        int axis = 0;
        t = march_detail::exit_of(ray, cell, shift, axis);
        march_detail::leave(ray, cell, shift, axis, t);
    }
    EXPECT_GT(t, 4000 * 1.7);
    // Through 14 places at most that hold a voxel, each 4^3 of 128, which hold 4^3 of 32, which hold 4^3 of 8.
    EXPECT_LT(steps, 8 * 3 + 14 * 12);
    // As many as are counted, but for those of cells within bricks that the ray meets.
    const size_t counted = count_steps(map, ray, 0, 1e12);
    EXPECT_GE(counted, size_t(steps) / 2);
    EXPECT_LE(counted, size_t(steps) + 14 * 24);
}

}  // namespace
}  // namespace vdbcloud
