// Cases that break convection codes: each must stay finite and keep its invariants.
#include "air.h"

#include "vdbcloud/sim/presets.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Budgets, bounds and finite values, which every run must keep.
void expect_kept(const Simulation& sim)
{
    const Budget b = sim.budget();  // throws if a cell is not finite
    const bool single = sim.parameters().precision == Precision::Float;
    EXPECT_EQ(b.fault, "");
    EXPECT_LT(std::abs(b.theta_drift), single ? 2e-6 : 1e-12);
    EXPECT_LT(std::abs(b.water_drift), single ? 2e-6 : 1e-12);
    EXPECT_GE(b.water_min, 0);
    if (b.new_extrema >= 0) {
        // Rounding, and compression by the remaining divergence, which matters where cells are far from cubes.
        const auto& h = sim.parameters().lattice.h;
        const double left = b.divergence * std::max(b.speed_max, 0.1) / std::min({h[0], h[1], h[2]});
        EXPECT_LE(b.new_extrema, (single ? 4 * 1.2e-7 : 1e-14) + left * b.time);
    }
    EXPECT_LT(b.speed_max, 300);
}

Parameters moist(std::array<int, 3> n, std::array<double, 3> size, Precision precision)
{
    Parameters p = bare(n, size);
    p.precision = precision;
    p.buoyancy = p.moisture = true;
    p.moist = {};
    p.scalar_scheme = ScalarScheme::Limited5;
    return p;
}

const Sounding humid{"humid", {0, 800, 4000}, {300, 300, 312}, {0.014, 0.013, 0.001}, {0, 0, 0}, {0, 0, 0}, 0};

TEST(Hard, TwentyKelvinInversionInOneCellStopsABubble)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = moist({32, 1, 32}, {3200, 3200, 3200}, precision);
        p.dye = true;
        p.bubbles.push_back({{1600, 0, 500}, 500, 400, 2, 1e-3, 1});
        const Sounding capped{"capped",
                              {0, 1599, 1601, 3200},
                              {300, 300, 320, 324},
                              {0.013, 0.013, 0.002, 0.002},
                              {0, 0, 0, 0},
                              {0, 0, 0, 0},
                              0};
        auto sim = Simulation::make(p, capped);
        sim->advance_to(1200);
        expect_kept(*sim);
        EXPECT_GT(sim->budget().speed_max, 1);
        const auto dye = all(*sim, Quantity::Dye), theta = all(*sim, Quantity::Theta);
        double above = 0, whole = 0;
        for (size_t c = 0; c < dye.size(); ++c) {
            whole += dye[c];
            if (c / 32 < 18) continue;  // above are two cells over the inversion, which is below cell 16
            above += dye[c];
            EXPECT_GT(theta[c], 315);
        }
        // A bubble of 2 K does not pass an inversion of 20 K. Waves on the interface mix a little dye upwards.
        EXPECT_LT(above, 0.01 * whole);
        // Without the bubble it rests.
        p.bubbles.clear();
        auto still = Simulation::make(p, capped);
        still->advance_to(1200);
        EXPECT_LT(still->budget().speed_max, precision == Precision::Float ? 1e-5 : 1e-12);
    }
}

TEST(Hard, HeatFromOneFloorCellIsConserved)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = moist({15, 13, 18}, {1500, 1300, 1800}, precision);
        const double flux = 100;  // K m/s: 117 kW/m^2, a forest fire, on 100 x 100 m
        p.floor.patches.push_back({{750, 650}, 1, flux, 0.05, 0});
        auto sim = Simulation::make(p, humid);
        sim->start();
        const Budget before = sim->budget();
        sim->advance_to(120);
        expect_kept(*sim);
        const Budget after = sim->budget();
        const double columns = 15 * 13, heated = flux * 120 / 1800 / columns;
        EXPECT_NEAR((after.theta_mean - before.theta_mean) / heated, 1, precision == Precision::Float ? 1e-4 : 1e-10);
        EXPECT_GE(after.theta_min, before.theta_min - 1e-4);
        EXPECT_GT(after.w_max, 10);
    }
}

TEST(Hard, InvariantsHoldForFlatAndTallCells)
{
    for (const double ratio : {0.05, 0.3, 3.0, 20.0})
        for (const Precision precision : {Precision::Float, Precision::Double}) {
            Parameters p = moist({24, 10, 24}, {2400, 1000, 2400}, precision);
            p.lattice.h = {2400 / 24 / std::sqrt(ratio), 2400 / 24 / std::sqrt(ratio), 2400 / 24 * std::sqrt(ratio)};
            if (ratio > 10) p.lattice.n[2] = 8;  // below the lid of the atmosphere
            const double width = 24 * p.lattice.h[0], height = p.lattice.n[2] * p.lattice.h[2];
            p.bubbles.push_back({{width / 2, 5 * p.lattice.h[1], height / 3}, width / 3, height / 4, 2, 1e-3, 0});
            auto sim = Simulation::make(p, humid);
            sim->advance_to(120);
            SCOPED_TRACE(ratio);
            expect_kept(*sim);
            EXPECT_GT(sim->budget().w_max, 0.05);
        }
}

TEST(Hard, SlicesAlongXAndYAgree)
{
    std::vector<double> w[2], u[2];
    for (const int flat : {0, 1}) {
        Parameters p = moist({20, 20, 20}, {2000, 2000, 2000}, Precision::Double);
        p.lattice.n[size_t(flat)] = 1;
        p.bubbles.push_back({{flat == 0 ? 50. : 900., flat == 0 ? 900. : 50., 500}, 400, 400, 1.5, 1e-3, 0});
        auto sim = Simulation::make(p, humid);
        EXPECT_FALSE(sim->has(flat == 0 ? Quantity::U : Quantity::V));
        sim->advance_to(300);
        expect_kept(*sim);
        w[flat] = all(*sim, Quantity::W), u[flat] = all(*sim, flat == 0 ? Quantity::V : Quantity::U);
    }
    EXPECT_GT(largest(w[0]), 1);
    // A bubble centred on the flat axis is the same disc; sums are taken in another order.
    EXPECT_LT(largest_difference(w[0], w[1]), 1e-9 * largest(w[0]));
    EXPECT_LT(largest_difference(u[0], u[1]), 1e-9 * largest(w[0]));
}

TEST(Hard, SingleColumnStaysAtRest)
{
    Parameters p = moist({1, 1, 20}, {100, 100, 2000}, Precision::Float);
    p.floor.heat = 1;
    auto sim = Simulation::make(p, humid);
    sim->advance_to(100);
    expect_kept(*sim);
    EXPECT_LT(sim->budget().w_max, 1e-5);
    std::vector<double> floor(1);
    sim->get_plane(Quantity::Theta, 0, floor.data());
    EXPECT_NEAR(floor[0], 301, 1e-3);  // 1 K m/s for 100 s in 100 m
}

TEST(Hard, InvariantsHoldForOddAndPrimeSizes)
{
    for (const auto& n : {std::array<int, 3>{13, 11, 17}, {7, 23, 5}, {31, 2, 29}, {3, 3, 2}})
        for (const Side side : {Side::Periodic, Side::Wall, Side::Open}) {
            Parameters p = moist(n, {100. * n[0], 100. * n[1], 100. * n[2]}, Precision::Double);
            p.lattice.side = {side, side};
            p.bubbles.push_back({{50. * n[0], 50. * n[1], 30. * n[2]}, 30. * n[0], 30. * n[2], 2, 1e-3, 0});
            auto sim = Simulation::make(p, humid);
            sim->advance_to(120);
            expect_kept(*sim);
        }
}

TEST(Hard, AirStaysAtRestWithoutGravity)
{
    Parameters p = moist({12, 12, 12}, {1200, 1200, 1200}, Precision::Double);
    p.constants.g = 0;
    p.bubbles.push_back({{600, 600, 600}, 400, 400, 30, 5e-3, 0});
    auto sim = Simulation::make(p, humid);
    const auto before = all(*sim, Quantity::Theta);
    sim->advance_to(600);
    expect_kept(*sim);
    EXPECT_EQ(sim->budget().speed_max, 0);
    EXPECT_EQ(all(*sim, Quantity::Theta), before);
}

TEST(Hard, InfiniteFrictionTimeEqualsNoFriction)
{
    std::vector<double> w[2];
    for (const int run : {0, 1}) {
        Parameters p = moist({16, 1, 16}, {1600, 1600, 1600}, Precision::Float);
        p.friction_time = run == 0 ? never : 1e300;
        p.bubbles.push_back({{800, 0, 500}, 400, 400, 2, 0, 0});
        auto sim = Simulation::make(p, humid);
        sim->advance_to(100);
        w[run] = all(*sim, Quantity::W);
    }
    EXPECT_EQ(w[0], w[1]);
}

TEST(Hard, SupersaturatedStartHoldsCloudAndConservesWater)
{
    for (const SaturationBy by : {SaturationBy::Height, SaturationBy::Temperature}) {
        Parameters p = moist({16, 16, 16}, {1600, 1600, 1600}, Precision::Double);
        p.moist.by = by;
        p.noise = {0.2, 1e-3, never, 5};
        auto sim = Simulation::make(p, {"sauna", {0}, {300}, {0.1}, {0}, {0}, 0});
        sim->start();
        const Budget before = sim->budget();
        EXPECT_GT(before.cloud_mean, 0.01);
        sim->advance_to(120);
        expect_kept(*sim);
        EXPECT_LT(sim->budget().speed_max, 50);
    }
}

TEST(Hard, StepOfManyCellsOfWindIsSplitAndConservesDye)
{
    Parameters p = bare({32, 8, 4}, {320, 80, 40});
    p.momentum = false, p.dye = true, p.dt = 60;  // 80 m/s in cells of 10 m: 480 of them a step
    p.scalar_scheme = ScalarScheme::Limited5;
    p.bubbles.push_back({{160, 40, 20}, 60, 1e9, 0, 0, 1});
    auto sim = Simulation::make(p, {"storm", {0}, {300}, {0}, {80}, {-30}, 0});
    sim->start();
    const auto before = all(*sim, Quantity::Dye);
    sim->advance_to(60);
    const auto after = all(*sim, Quantity::Dye);
    double was = 0, is = 0;
    for (size_t c = 0; c < after.size(); ++c) was += before[c], is += after[c];
    EXPECT_NEAR(is / was, 1, 1e-11);
    EXPECT_LE(sim->budget().courant * longest_stage(p.time_scheme), p.cfl + 1e-9);
    EXPECT_GE(*std::min_element(after.begin(), after.end()), 0);
    EXPECT_LE(largest(after), largest(before) * (1 + 1e-12));
}

TEST(Hard, GivenWindIsZeroTowardsWalls)
{
    Parameters p = moist({8, 12, 8}, {4000, 3000, 9000}, Precision::Double);
    p.lattice.side = {Side::Wall, Side::Periodic};
    p.momentum = false, p.rain = true;
    p.noise = {5, 5e-3, never, 3};
    p.cfl = 0.75;
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0.012}, {20}, {5}, 0});
    sim->advance_to(1800);
    expect_kept(*sim);
    EXPECT_EQ(largest(all(*sim, Quantity::U)), 0);
    EXPECT_NEAR(sim->budget().speed_max, 5, 1e-12);
}

TEST(Hard, PresetsBeginWithTheirWeather)
{
    for (const std::string& name : preset_names()) {
        Preset s = preset(name);
        const Lattice before = s.parameters.lattice;
        for (const size_t d : {0, 1}) {
            s.parameters.lattice.h[d] *= double(before.n[d]) / 10;
            s.parameters.lattice.n[d] = 10;
        }
        auto sim = Simulation::make(s.parameters, s.sounding);
        sim->start();
        const Budget b = sim->budget();
        const double lid = before.n[2] * before.h[2];
        if (name == "fog") {
            EXPECT_LT(b.cloud_base, 5);
            EXPECT_GT(b.cloud_top, 40);
            EXPECT_LT(b.cloud_top, 120);
        } else if (name == "stratocumulus") {
            EXPECT_NEAR(b.cloud_base, 590, 40);
            EXPECT_NEAR(b.cloud_top, 845, 15);
        } else {
            EXPECT_LT(b.cloud_max, 1e-5) << name << ": cloud from " << b.cloud_base << " to " << b.cloud_top << " m";
        }
        EXPECT_LT(b.cloud_top, lid * 0.8) << name;
    }
}

}  // namespace
}  // namespace vdbcloud::sim
