// A box that moves over the ground: equal to the fixed one, with floor, friction and files on the ground.
#include "air.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/sim/run_record.h"

#include <gtest/gtest.h>

#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

Sounding wind(double u, double v) { return {"wind", {0}, {300}, {0}, {u}, {v}, 0}; }

/// A slice along x in which a warm bubble with dye rises.
Parameters thermal(int n)
{
    Parameters p = bare({n, 1, n}, {1600, 1600, 1600});
    p.buoyancy = p.dye = true;
    p.bubbles = {{{800, 0, 600}, 500, 500, 1, 0, 1}};
    return p;
}

TEST(MovingFrame, ABoxThatMovesWithTheWindHasTheBitsOfStillAir)
{
    for (const Precision precision : {Precision::Float, Precision::Double})
        for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::HugeStep}) {
            Parameters still = thermal(24), moving = still;
            still.precision = moving.precision = precision, still.time_scheme = moving.time_scheme = scheme;
            still.dt = moving.dt = 5;
            moving.frame = {8, 0};
            auto a = Simulation::make(still, wind(0, 0)), b = Simulation::make(moving, wind(8, 0));
            a->advance_to(120), b->advance_to(120);
            for (const Quantity q : {Quantity::W, Quantity::Theta, Quantity::Dye}) EXPECT_EQ(all(*a, q), all(*b, q));
            auto u = all(*b, Quantity::U);
            for (double& value : u) value -= 8;
            EXPECT_LT(largest_difference(u, all(*a, Quantity::U)), 2e-15) << "8 m/s have an ulp of 1.8e-15";
            EXPECT_GT(a->budget().w_max, 0.5);
            EXPECT_GT(b->budget().speed_max, 8);
        }
}

TEST(MovingFrame, EqualsTheFixedBoxWithinTheDiscretisation)
{
    // Both boxes solve one flow; transport by the wind of 5 m/s over 16 or 32 whole cells is what differs.
    double before = 0;
    for (const int n : {32, 64}) {
        Parameters fixed = thermal(n), moving = fixed;
        moving.frame = {5, 0};
        auto a = Simulation::make(fixed, wind(5, 0)), b = Simulation::make(moving, wind(5, 0));
        a->advance_to(160), b->advance_to(160);
        const auto at_ground = all(*a, Quantity::Theta), in_box = all(*b, Quantity::Theta);
        auto shifted = in_box;
        for (size_t c = 0; c < shifted.size(); ++c) {
            const size_t i = c % size_t(n), row = c - i;
            shifted[row + (i + size_t(n) / 2) % size_t(n)] = in_box[c];
        }
        const double difference = rms(at_ground, shifted);
        EXPECT_LT(difference, 0.02);
        if (before > 0) {
            EXPECT_GT(before / difference, 3.5) << "order 2 or more";
        }
        before = difference;
    }
}

TEST(MovingFrame, TheFloorStaysOnTheGround)
{
    // Air that moves with the box gathers what the ground beneath it gives. Steps of one cell see the map at whole
    // cells; steps of part of a cell see it linear between them, and no flux is lost.
    Parameters p = bare({6, 5, 2}, {600, 500, 100});
    p.momentum = false, p.buoyancy = true;
    p.floor.heat = 0.1;
    for (int c = 0; c < 30; ++c) p.floor.map.push_back(0.25 * (c * c % 7));
    p.time_scheme = TimeScheme::Euler;
    p.frame = {10, -20};
    const double dz = 50;
    const auto map = [&](int i, int j) { return p.floor.map[size_t((j % 5 + 5) % 5 * 6 + (i % 6 + 6) % 6)]; };
    p.dt = 10;  // 1 cell along x, 2 back along y
    auto whole = Simulation::make(p, wind(10, -20));
    whole->advance_to(70);
    auto theta = all(*whole, Quantity::Theta);
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 6; ++i) {
            double sum = 0;
            for (int n = 0; n < 7; ++n) sum += 0.1 * map(i + n, j - 2 * n) * 10 / dz;
            EXPECT_NEAR(theta[size_t(j * 6 + i)], 300 + sum, 1e-12);
        }
    p.dt = 2.5;
    auto part = Simulation::make(p, wind(10, -20));
    part->advance_to(5);
    theta = all(*part, Quantity::Theta);
    double total = 0, all_of_map = 0;
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 6; ++i) {
            const double second = 0.375 * map(i, j) + 0.125 * map(i + 1, j) + 0.375 * map(i, j - 1) +
                                  0.125 * map(i + 1, j - 1);  // a quarter of a cell along x, a half back along y
            EXPECT_NEAR(theta[size_t(j * 6 + i)], 300 + 0.1 * 2.5 / dz * (map(i, j) + second), 1e-12);
            total += theta[size_t(j * 6 + i)] - 300, all_of_map += map(i, j);
        }
    EXPECT_NEAR(total, 0.1 * 5 / dz * all_of_map, 1e-11);
    EXPECT_LT(std::abs(part->budget().theta_drift), 1e-12);
}

TEST(MovingFrame, DragIsThatOfTheGround)
{
    for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::HugeStep}) {
        Parameters p = bare({4, 4, 4}, {400, 400, 400});
        p.friction_time = 50, p.frame = {7, -3}, p.time_scheme = scheme, p.dt = 1;
        p.wind_relaxation = scheme == TimeScheme::Rk3 ? 80 : never;
        auto sim = Simulation::make(p, wind(9, 2));
        sim->advance_to(40);
        // du/dt = -u/50 - (u - 9)/80, over the ground.
        const double back = std::isfinite(p.wind_relaxation) ? 1 / 80. : 0, rate = 1 / 50. + back;
        for (const auto& [q, start] : {std::pair{Quantity::U, 9.0}, {Quantity::V, 2.0}}) {
            const double rest = start * back / rate;
            for (const double value : all(*sim, q))
                EXPECT_NEAR(value, rest + (start - rest) * std::exp(-40 * rate), back > 0 ? 2e-6 : 1e-12);
        }
    }
}

TEST(MovingFrame, FilesHaveTheBoxWhereItIsAndWindsOverTheGround)
{
    Parameters p = thermal(8);
    p.lattice.n[1] = 4, p.lattice.h[1] = 100, p.frame = {8, -2};
    auto sim = Simulation::make(p, wind(8, -2));
    sim->advance_to(100);
    for (const UpAxis up : {UpAxis::Y, UpAxis::Z}) {
        const FramePlan plan{{up, true, {}, 1e-5, 0.05}, 10, 0, "none"};
        const GridFile file = make_snapshot(*sim, plan.snapshot, describe(p, wind(8, -2), plan));
        ASSERT_FALSE(file.grids.empty());
        for (const GridBasePtr& grid : file.grids) {
            const auto first = grid->transform().indexToWorld(openvdb::Coord(0, 0, 0));
            EXPECT_NEAR(first[0], -700 + 800, 1e-9);
            EXPECT_NEAR(first[up == UpAxis::Y ? 2 : 1], -150 - 200, 1e-9);
            if (grid->getName() != "vel") continue;
            const auto v = openvdb::gridPtrCast<Vec3SGrid>(grid)->getAccessor().getValue(openvdb::Coord(0, 0, 0));
            EXPECT_NEAR(v[0], all(*sim, Quantity::U)[0], 1e-5);
            EXPECT_NEAR(v[0], 8, 3);
        }
    }
}

TEST(MovingFrame, ContinuesFromACheckpointWithEqualBits)
{
    Parameters p = thermal(16);
    p.frame = {3, 0};
    p.floor.patches = {{{300, 800}, 200, 0.5, 0, 1, 0}};
    auto once = Simulation::make(p, wind(1, 0)), half = Simulation::make(p, wind(1, 0)),
         again = Simulation::make(p, wind(1, 0));
    half->advance_to(50);
    std::stringstream state;
    half->save(state), again->restore(state);
    once->advance_to(50), once->advance_to(100), again->advance_to(100);
    for (const Quantity q : {Quantity::U, Quantity::W, Quantity::Theta, Quantity::Dye})
        EXPECT_EQ(all(*once, q), all(*again, q));
}

TEST(MovingFrame, IsRefusedWhereWallsStandAndAlongAnAxisOfOneCell)
{
    Parameters p = bare({4, 1, 4}, {400, 100, 400}, Side::Wall);
    p.frame = {1, 0};
    EXPECT_THROW(check(p, wind(0, 0)), InputError);
    p.lattice.side[0] = Side::Open;
    EXPECT_NO_THROW(check(p, wind(0, 0)));
    p.frame = {0, 1};
    EXPECT_THROW(check(p, wind(0, 0)), InputError);
    p.frame = {501, 0};
    EXPECT_THROW(check(p, wind(0, 0)), InputError);
}

}  // namespace
}  // namespace vdbcloud::sim
