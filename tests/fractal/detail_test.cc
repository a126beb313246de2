// Detail below the voxels of a simulation: water stays in its voxel, noise has its size, moves with the flow and does
// not flicker.
#include "vdbcloud/fractal/detail.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/digest.h"

#include "support/fields.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

/// A cloud of smooth lumps with voids.
FloatGridPtr lumps(int n = 12, double h = 20)
{
    return box({n, n, n}, h, [](Coord c) { return test::clumps(c, 5, 0.002); });
}
FloatGridPtr even(int n = 12)
{
    return box({n, n, n}, 20, [](Coord) { return 0.5; });
}

Vec3SGridPtr wind(const FloatGrid& on, const Vec3d& speed)
{
    const auto vel = Vec3SGrid::create(Vec3f(speed));
    vel->setTransform(on.transform().copy());
    return vel;
}

/// The mean of fine voxels over a coarse one.
double mean_in(const FloatGrid& fine, const Coord& voxel, int factor)
{
    double sum = 0;
    for (int x = 0; x < factor; ++x)
        for (int y = 0; y < factor; ++y)
            for (int z = 0; z < factor; ++z)
                sum += double(
                    fine.tree().getValue(Coord(voxel[0] * factor + x, voxel[1] * factor + y, voxel[2] * factor + z)));
    return sum / (factor * factor * factor);
}

/// Root mean square of ln(a / b), b at places that are `shift` further, over voxels of a coarse box.
double change(const FloatGrid& a, const FloatGrid& b, int from, int to, const Coord& shift = Coord(0))
{
    double sum = 0;
    int count = 0;
    for (int x = from; x < to; ++x)
        for (int y = from; y < to; ++y)
            for (int z = from; z < to; ++z) {
                const double p = double(a.tree().getValue(Coord(x, y, z))),
                             q = double(b.tree().getValue(Coord(x, y, z) + shift));
                if (!(p > 0) || !(q > 0)) continue;
                sum += std::pow(std::log(p / q), 2);
                ++count;
            }
    return std::sqrt(sum / count);
}

/// The greatest difference between two voxels side by side.
double greatest_step(const FloatGrid& grid)
{
    double most = 0;
    const auto at = grid.getConstAccessor();
    for (auto v = grid.cbeginValueOn(); v; ++v)
        for (int a = 0; a < 3; ++a)
            for (const int side : {-1, 1}) {
                Coord c = v.getCoord();
                c[a] += side;
                most = std::max(most, std::abs(double(*v) - double(at.getValue(c))));
            }
    return most;
}

TEST(Detail, KeepsTheWaterOfEachVoxel)
{
    for (const int factor : {2, 3, 4}) {
        DetailOptions o;
        o.factor = factor;
        const auto coarse = lumps();
        coarse->setTransform(openvdb::math::Transform::createLinearTransform(20));
        coarse->transform().preScale(Vec3d(1, 2, 1));
        coarse->transform().postTranslate(Vec3d(-300, 40, 7));
        const auto fine = add_detail(*coarse, nullptr, o);
        double most = 0;
        for (auto v = coarse->cbeginValueOn(); v; ++v)
            if (*v > 0)
                most = std::max(most, std::abs(mean_in(*fine, v.getCoord(), factor) / double(*v) - 1));
            else
                EXPECT_EQ(mean_in(*fine, v.getCoord(), factor), 0);
        EXPECT_LT(most, 2e-7) << "rounding of floats";
        // The voxels fill those of the simulation.
        const Vec3d low = fine->indexToWorld(Vec3d(-0.5)), theirs = coarse->indexToWorld(Vec3d(-0.5));
        EXPECT_LT((low - theirs).length(), 1e-9);
        const Vec3d high = fine->indexToWorld(Vec3d(factor * 12 - 0.5)), end = coarse->indexToWorld(Vec3d(11.5));
        EXPECT_LT((high - end).length(), 1e-9);
    }
}

TEST(Detail, HasItsSize)
{
    // In even matter: 0.15 of the amount, less what the mean of each voxel takes: waves of one to two voxels lose about
    // half of their power to it.
    DetailOptions o;
    o.amount = 1;
    o.factor = 4;
    const auto fine = add_detail(*even(), nullptr, o);
    double sum = 0, square = 0;
    int count = 0;
    for (int x = 16; x < 32; ++x)
        for (int y = 16; y < 32; ++y)
            for (int z = 16; z < 32; ++z) {
                const double l = std::log(double(fine->tree().getValue(Coord(x, y, z))) / 0.5);
                sum += l, square += l * l, ++count;
            }
    const double deviation = std::sqrt(square / count - sum * sum / count / count);
    EXPECT_GT(deviation, 0.15 * 0.5);
    EXPECT_LT(deviation, 0.15 * 1.05);
    // Without an amount even matter is even.
    o.amount = 0;
    const auto plain = add_detail(*even(), nullptr, o);
    // The edge's sharpening rings, by 1 % within four voxels of the simulation and a tenth of that beyond.
    for (int x = 8; x < 40; ++x)
        EXPECT_NEAR(plain->tree().getValue(Coord(x, 20, 23)), 0.5, x < 16 || x >= 32 ? 1e-2 : 5e-4);
    // Where matter ends there is more.
    o.amount = 1;
    const auto coarse = lumps();
    const auto rough = add_detail(*coarse, nullptr, o);
    o.amount = 0;
    const auto smooth = add_detail(*coarse, nullptr, o);
    EXPECT_GT(change(*rough, *smooth, 0, 48), 0.4);
    EXPECT_LT(change(*rough, *smooth, 0, 48), 1.1);
}

TEST(Detail, IsContinuousAlsoWhereMatterEnds)
{
    // Voxels of half the edge halve the greatest step, also that to the voids, where coarse voxels jump; 0.1 is for the
    // part of the gain that is even in each coarse voxel, and for voxels whose middle falls on a kink.
    DetailOptions o;
    o.amount = 0;
    const auto step = [&](int factor) {
        o.factor = factor;
        return greatest_step(*add_detail(*lumps(), nullptr, o));
    };
    EXPECT_NEAR(step(8) / step(4), 0.5, 0.1);
}

TEST(Detail, LeastDensitiesStayFinite)
{
    // Lone voxels of the least numbers that a float has, all of whose parts may round to 0, beside dense ones.
    DetailOptions o;
    o.amount = 3;
    o.factor = 2;
    const double least = double(std::numeric_limits<float>::denorm_min());
    const auto coarse = box({18, 18, 18}, 20, [&](Coord c) {
        const bool lone = c[0] % 2 && c[1] % 2 && c[2] % 2;
        return c[0] > 15 ? 1.0 : lone ? least : 0.0;
    });
    const auto fine = add_detail(*coarse, nullptr, o);
    for (auto v = fine->cbeginValueAll(); v; ++v) ASSERT_TRUE(std::isfinite(*v)) << v.getCoord();
    for (auto v = coarse->cbeginValueOn(); v; ++v)
        EXPECT_NEAR(mean_in(*fine, v.getCoord(), 2), *v, 2e-7 * double(*v) + least) << v.getCoord();
}

TEST(Detail, ChangesWithTheAngleOfItsWeights)
{
    // Weights w and 1 - w of two independent patterns: 2 sin(dtheta / 2) in the root mean square.
    const auto angle = [](double t) {
        const auto weight = [](double part) { return 1 - std::abs(2 * (part - std::floor(part)) - 1); };
        return std::atan2(weight(t + 0.5), weight(t));
    };
    DetailOptions o;
    o.period = 60;
    const auto at = [&](double t) {
        o.time = t;
        return add_detail(*even(), nullptr, o);
    };
    const auto first = at(20);
    const double whole = change(*first, *at(20 + 6000), 16, 32) / std::sqrt(2.0);  // of independent noise: its size
    for (const double dt : {0.5, 2.0, 8.0}) {
        const double expected = whole * 2 * std::sin(std::abs(angle((20 + dt) / 60) - angle(20.0 / 60)) / 2);
        EXPECT_NEAR(change(*first, *at(20 + dt), 16, 32), expected, 0.15 * expected) << dt;
    }
    // Nothing jumps where a pattern ends.
    EXPECT_LT(change(*at(59.9), *at(60.1), 16, 32), 0.02 * whole);
    EXPECT_LT(change(*at(29.9), *at(30.1), 16, 32), 0.02 * whole);
    EXPECT_GT(change(*at(20), *at(50), 16, 32), 0.5 * whole);
}

TEST(Detail, MovesWithTheFlow)
{
    // In half a second matter moves by 2, 1, 3 coarse voxels, 8, 4, 12 fine ones; its detail is the same there, but for
    // the change that a fluid at rest has, too. Floats round places of patterns to 1e-5 voxels.
    DetailOptions o;
    o.time = 20;
    const auto block = [](const Coord& from) {
        const auto grid = FloatGrid::create(0.0f);
        grid->setTransform(openvdb::math::Transform::createLinearTransform(20));
        grid->transform().preScale(Vec3d(1, 2, 0.5));
        grid->fill(openvdb::CoordBBox(from, from.offsetBy(11)), 0.5f);
        return grid;
    };
    const auto then = block(Coord(0)), now = block(Coord(2, 1, 3));
    const Vec3d speed(80, 80, 60);
    const auto before = add_detail(*then, wind(*then, speed).get(), o);
    DetailOptions later = o;
    later.time = 20.5;
    const auto after = add_detail(*now, wind(*now, speed).get(), later);
    const auto still = add_detail(*then, nullptr, o), still_later = add_detail(*then, nullptr, later);
    const double flicker = change(*still, *still_later, 16, 32);
    EXPECT_GT(flicker, 0);
    EXPECT_NEAR(change(*before, *after, 16, 32, Coord(8, 4, 12)), flicker, 0.15 * flicker);
    // What stays in its place changes far more.
    EXPECT_GT(change(*before, *after, 16, 32), 8 * flicker);
}

TEST(Detail, TakesTheFlowOfAnyLatticeAtItsPlaces)
{
    // A flow linear in space has the same samples on any lattice, staggered or not, to the rounding of floats.
    DetailOptions o;
    o.time = 20;
    const auto matter = even();
    const auto flow = [](const Vec3d& x) { return Vec3d(0.3 * x[0] - 20, 0.2 * x[2] - 0.4 * x[1], -0.1 * x[0] + 10); };
    const auto on = [&](const openvdb::math::Transform& lattice, bool staggered) {
        const auto vel = Vec3SGrid::create(Vec3f(0.0f));
        vel->setTransform(lattice.copy());
        for (int i = -4; i < 40; ++i)
            for (int j = -4; j < 40; ++j)
                for (int k = -4; k < 40; ++k) {
                    Vec3f v;
                    for (int a = 0; a < 3; ++a) {
                        Vec3d at(i, j, k);
                        if (staggered) at[a] -= 0.5;
                        v[a] = float(flow(lattice.indexToWorld(at))[a]);
                    }
                    vel->tree().setValue(Coord(i, j, k), v);
                }
        if (staggered) vel->setGridClass(openvdb::GRID_STAGGERED);
        return vel;
    };
    const auto own = openvdb::math::Transform::createLinearTransform(10);
    own->preScale(Vec3d(1, 1.5, 0.9));
    own->postTranslate(Vec3d(-13, -11, -17));
    const auto plain = add_detail(*matter, on(matter->transform(), false).get(), o);
    EXPECT_LT(change(*plain, *add_detail(*matter, on(*own, true).get(), o), 16, 32), 1e-4);
    EXPECT_GT(change(*plain, *add_detail(*matter, nullptr, o), 16, 32), 0.05);
}

TEST(Detail, HasOneSizeAlongAllAxesOfTheWorld)
{
    const auto flat = even();
    flat->transform().preScale(Vec3d(1, 3, 1));
    const auto fine = add_detail(*flat, nullptr, {});
    const auto over = [&](const Coord& shift) { return change(*fine, *fine, 16, 32, shift); };
    // One long step and three short ones reach as far; 16^3 voxels have some 5 % of sampling error.
    EXPECT_NEAR(over(Coord(3, 0, 0)) / over(Coord(0, 1, 0)), 1, 0.12);
    EXPECT_NEAR(over(Coord(0, 0, 3)) / over(Coord(0, 1, 0)), 1, 0.12);
    EXPECT_LT(over(Coord(1, 0, 0)), 0.7 * over(Coord(0, 1, 0)));
}

TEST(Detail, DependsOnTheSeedAndNotOnThreadsOrTiles)
{
    const DetailOptions o;
    const auto coarse = lumps();
    const auto with = [&](size_t threads) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        return grid_digest(*add_detail(*coarse, nullptr, o));
    };
    EXPECT_EQ(with(1), with(2));
    DetailOptions other = o;
    other.seed = 2;
    EXPECT_NE(grid_digest(*add_detail(*coarse, nullptr, other)), with(1));
    const auto tiled = FloatGrid::create(0.0f), filled = FloatGrid::create(0.0f);
    tiled->sparseFill(openvdb::CoordBBox(Coord(0), Coord(15)), 1.0f);
    filled->denseFill(openvdb::CoordBBox(Coord(0), Coord(15)), 1.0f);
    EXPECT_GT(tiled->tree().activeTileCount(), 0u);
    EXPECT_EQ(grid_digest(*add_detail(*tiled, nullptr, o)), grid_digest(*add_detail(*filled, nullptr, o)));
    const auto huge = FloatGrid::create(0.0f);
    huge->fill(openvdb::CoordBBox(Coord(0), Coord(511)), 1.0f);
    EXPECT_THROW(add_detail(*huge, nullptr, o), InputError);
}

}  // namespace
}  // namespace vdbcloud
