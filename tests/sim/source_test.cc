// Sources and sinks of shapes against closed forms: amounts, times, targets, budgets.
#include "air.h"
#include "shapes.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <numeric>
#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

Sounding wind(double u) { return {"wind", {0}, {300}, {0.01}, {u}, {0}, 0}; }

/// Still air with heat, water and dye.
Parameters still(std::array<int, 3> n, std::array<double, 3> size)
{
    Parameters p = bare(n, size);
    p.momentum = false, p.moisture = p.dye = true;
    p.moist.by = SaturationBy::Height;
    return p;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

FieldSource everywhere_source()
{
    FieldSource s;
    s.shape = mask([](const Point&, double) { return 1.0; });
    return s;
}

TEST(Sources, ABallGivesItsVolumeTimesItsRate)
{
    Parameters p = still({20, 20, 20}, {200, 200, 200});
    FieldSource s;
    s.shape = ball({92, 107, 103}, 41);
    s.heat = 0.5, s.water = 1e-5, s.dye = 2;
    p.sources = {s}, p.dt = 1;
    auto sim = Simulation::make(p, wind(0));
    sim->advance_to(8);
    const double volume = 4 * M_PI / 3 * 41 * 41 * 41;
    const auto dye = all(*sim, Quantity::Dye), theta = all(*sim, Quantity::Theta), water = all(*sim, Quantity::Water);
    EXPECT_NEAR(sum(dye) * 1000 / (2 * 8 * volume), 1, 2e-3);  // shares of 4^3 points a cell
    for (size_t c = 0; c < dye.size(); ++c) {
        EXPECT_NEAR(theta[c] - 300, 0.25 * dye[c], 1e-9);
        EXPECT_NEAR(water[c] - 0.01, 5e-6 * dye[c], 1e-13);
        EXPECT_LE(dye[c], 16 * (1 + 1e-12));
    }
    EXPECT_NEAR(dye[size_t((10 * 20 + 10) * 20 + 9)], 16, 1e-12) << "within the ball";
    EXPECT_EQ(dye[0], 0);
    for (const double drift : {sim->budget().dye_drift, sim->budget().water_drift, sim->budget().theta_drift})
        EXPECT_LT(std::abs(drift), 1e-12);
}

TEST(Sources, ABallFillsUnevenCellsByTheirShares)
{
    Parameters p = still({40, 20, 10}, {200, 200, 200});
    const Point middle{92, 107, 103};
    FieldSource s;
    s.shape = ball(middle, 41);
    s.dye = 1;
    p.sources = {s}, p.dt = 1;
    auto sim = Simulation::make(p, wind(0));
    sim->advance_to(1);
    const auto dye = all(*sim, Quantity::Dye);
    constexpr int n = 6;  // points along an axis of a cell
    double worst = 0;
    for (size_t c = 0; c < dye.size(); ++c) {
        int within = 0;
        for (int m = 0; m < n * n * n; ++m) {
            const double x = 5 * (double(c % 40) + (m % n + 0.5) / n) - middle[0],
                         y = 10 * (double(c / 40 % 20) + (m / n % n + 0.5) / n) - middle[1],
                         z = 20 * (double(c / 800) + (m / n / n + 0.5) / n) - middle[2];
            within += x * x + y * y + z * z < 41 * 41;
        }
        worst = std::max(worst, std::abs(dye[c] - within / double(n * n * n)));
    }
    EXPECT_LT(worst, 0.09) << "two quadratures of a cell";
}

TEST(Sources, BeginEndAndRampAtTheirTimes)
{
    Parameters p = still({2, 2, 2}, {2, 2, 2});
    FieldSource s = everywhere_source();
    s.dye = 3, s.from = 1.3, s.until = 7.1;
    p.sources = {s}, p.dt = 1;
    auto sharp = Simulation::make(p, wind(0));
    sharp->advance_to(1.3);
    EXPECT_EQ(all(*sharp, Quantity::Dye)[0], 0);
    sharp->advance_to(2.8);
    EXPECT_NEAR(all(*sharp, Quantity::Dye)[0], 3 * 1.5, 1e-12);
    sharp->advance_to(20);
    EXPECT_NEAR(all(*sharp, Quantity::Dye)[0], 3 * 5.8, 1e-12);
    p.sources[0].ramp = 2, p.dt = 0.02;  // each ramp has half of its time
    auto smooth = Simulation::make(p, wind(0));
    smooth->advance_to(20);
    EXPECT_NEAR(all(*smooth, Quantity::Dye)[0], 3 * 3.8, 1e-5);
}

TEST(Sources, AMaskMayChangeWithTime)
{
    Parameters p = still({4, 2, 2}, {4, 2, 2});
    FieldSource s;
    s.shape = mask([](const Point& x, double t) { return x[0] < 2 ? t : 0; }, true);
    s.dye = 1;
    p.sources = {s}, p.dt = 0.5;
    auto sim = Simulation::make(p, wind(0));
    sim->advance_to(4);
    const auto dye = all(*sim, Quantity::Dye);
    EXPECT_NEAR(dye[1], 8, 1e-12);
    EXPECT_EQ(dye[2], 0);
}

TEST(Sources, SinksTakeNoMoreThanThereIs)
{
    for (const Precision precision : {Precision::Float, Precision::Double})
        for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::Rk2, TimeScheme::Euler, TimeScheme::HugeStep}) {
            Parameters p = still({32, 1, 8}, {3200, 100, 800});
            p.scalar_scheme = ScalarScheme::Limited5, p.precision = precision, p.time_scheme = scheme;
            if (scheme == TimeScheme::HugeStep) p.dt = 10;
            p.bubbles = {{{800, 0, 400}, 600, 1e9, 0, 0, 5}};
            FieldSource s;
            s.shape = mask([](const Point& x, double) { return std::abs(x[0] - 2000) < 300 ? 1.0 : 0.0; });
            s.dye = -50, s.water = -1;
            p.sources = {s};
            auto sim = Simulation::make(p, wind(10));
            sim->start();
            const double before = sim->budget().dye_mean;
            sim->advance_to(100);
            const Budget b = sim->budget();
            for (const Quantity q : {Quantity::Dye, Quantity::Water})
                for (const double value : all(*sim, q)) ASSERT_GE(value, q == Quantity::Water ? -1e-10 : 0);
            EXPECT_LT(b.dye_mean, 0.7 * before);
            EXPECT_GT(b.dye_mean, 0.01 * before) << "not all has arrived";
            if (scheme == TimeScheme::HugeStep) continue;  // its transport conserves nothing
            EXPECT_LT(std::abs(b.dye_drift), precision == Precision::Float ? 1e-6 : 1e-12);
            EXPECT_LT(std::abs(b.water_drift), precision == Precision::Float ? 1e-6 : 1e-12);
        }
}

TEST(Sources, AirReturnsToAVelocityByTheExactFactorForAnyRate)
{
    for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::HugeStep})
        for (const double rate : {0.1, 1e9}) {
            Parameters p = bare({4, 4, 4}, {400, 400, 400});
            FieldSource s = everywhere_source();
            s.has_velocity = true, s.velocity = {6, -3, 0}, s.rate = rate;
            p.sources = {s}, p.dt = 4, p.time_scheme = scheme;
            if (scheme == TimeScheme::Rk3) p.frame = {2.5, -1};  // velocities are those over the ground
            auto sim = Simulation::make(p, wind(2));
            sim->advance_to(8);
            const double left = std::exp(-8 * rate);
            for (const double u : all(*sim, Quantity::U)) EXPECT_NEAR(u, 6 - 4 * left, 1e-12);
            for (const double v : all(*sim, Quantity::V)) EXPECT_NEAR(v, -3 + 3 * left, 1e-12);
        }
}

TEST(Sources, AFanLeavesNoDivergenceAndNoFasterAir)
{
    Parameters p = bare({24, 20, 16}, {240, 200, 160});
    FieldSource s;
    s.shape = ball({120, 100, 80}, 30);
    s.has_velocity = true, s.velocity = {8, 0, 0}, s.rate = 1e6;
    p.sources = {s};
    auto sim = Simulation::make(p, wind(0));
    sim->advance_to(10);
    const Budget b = sim->budget();
    EXPECT_EQ(b.fault, "");
    EXPECT_GT(b.speed_max, 4);
    EXPECT_LT(b.speed_max, 8.5);
}

TEST(Sources, AFanMovesAirAlikeOnBothOfItsSides)
{
    // A first step from rest has no transport: each component is the mirror image of itself about the ball.
    for (const size_t axis : {0, 1, 2}) {
        Parameters p = bare({12, 10, 8}, {120, 100, 80});
        FieldSource s;
        s.shape = ball({60, 50, 40}, 25);
        s.has_velocity = true, s.velocity[axis] = 2, s.rate = 1;
        p.sources = {s}, p.dt = 0.5, p.time_scheme = TimeScheme::Euler;
        auto sim = Simulation::make(p, wind(0));
        sim->advance_to(0.5);
        const auto v = all(*sim, axis == 0 ? Quantity::U : axis == 1 ? Quantity::V : Quantity::W);
        const auto at = [&](std::array<int, 3> c) { return v[size_t((c[2] * 10 + c[1]) * 12 + c[0])]; };
        const std::array<int, 3> n{12, 10, 8};
        for (int k = 1; k < 8; ++k)
            for (int j = 1; j < 10; ++j)
                for (int i = 1; i < 12; ++i) {
                    const std::array<int, 3> c{i, j, k};
                    std::array<int, 3> mirrored = c;
                    for (const size_t d : {0, 1, 2}) mirrored[d] = n[d] - c[d] - (d == axis ? 0 : 1);
                    ASSERT_NEAR(at(c), at(mirrored), 1e-12) << axis << " " << i << " " << j << " " << k;
                }
        EXPECT_GT(at({6, 5, 4}), 0.2);
    }
}

TEST(Sources, AirReturnsToATemperatureAndTheBudgetKnows)
{
    Parameters p = still({4, 4, 4}, {400, 400, 400});
    FieldSource s = everywhere_source();
    s.has_temperature = true, s.temperature = 800, s.rate = 0.2;
    p.sources = {s}, p.dt = 3;
    auto sim = Simulation::make(p, wind(0));
    sim->advance_to(9);
    for (const double t : all(*sim, Quantity::Theta)) EXPECT_NEAR(t, 800 - 500 * std::exp(-1.8), 1e-9);
    EXPECT_LT(std::abs(sim->budget().theta_drift), 1e-12);
    // A temperature, not a potential one, where the two differ.
    p.lattice.h[2] = 1000, p.moist.by = SaturationBy::Temperature;
    auto tall = Simulation::make(p, wind(0));
    tall->advance_to(9);
    for (size_t k = 0; k < 4; ++k) {
        const double target = 800 / tall->column().level[k].exner;
        EXPECT_NEAR(all(*tall, Quantity::Theta)[16 * k], target - (target - 300) * std::exp(-1.8), 1e-9);
    }
    EXPECT_LT(tall->column().level[3].exner, 0.93);
    EXPECT_EQ(sim->budget().new_extrema, -1);
}

TEST(Sources, StayOnTheGroundBelowABoxThatMoves)
{
    // Air that moves with the box, one cell a step: each column of cells passes the mask in turn.
    Parameters p = still({8, 1, 2}, {80, 10, 20});
    p.time_scheme = TimeScheme::Euler, p.dt = 1, p.frame = {10, 0};
    FieldSource s;
    s.shape = mask([](const Point& x, double) { return x[0] > 40 && x[0] < 50 ? 1.0 : 0.0; });
    s.dye = 2;
    p.sources = {s};
    auto sim = Simulation::make(p, wind(10));
    sim->advance_to(3);
    const auto dye = all(*sim, Quantity::Dye);
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(dye[size_t(i)], i >= 2 && i <= 4 ? 2 : 0, 1e-12) << i;
    // Beyond periodic sides the ground is that of the opposite side, along y as along x.
    sim->advance_to(6);
    p = still({1, 8, 2}, {10, 80, 20});
    p.time_scheme = TimeScheme::Euler, p.dt = 1, p.frame = {0, 10};
    s.shape = mask([](const Point& x, double) { return x[1] > 40 && x[1] < 50 ? 1.0 : 0.0; });
    p.sources = {s};
    auto across = Simulation::make(p, {"wind", {0}, {300}, {0.01}, {0}, {10}, 0});
    across->advance_to(6);
    for (const Simulation* one : {sim.get(), across.get()})
        for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(all(*one, Quantity::Dye)[i], i < 5 || i == 7 ? 2 : 0, 1e-12) << i;
}

TEST(Sources, ContinueFromACheckpointWithEqualBits)
{
    Parameters p = bare({16, 12, 14}, {160, 120, 140});
    p.buoyancy = p.dye = true, p.precision = Precision::Float, p.scalar_scheme = ScalarScheme::Limited5;
    FieldSource s;
    s.shape = ball({80, 60, 40}, 30);
    s.heat = 1, s.dye = 1, s.has_velocity = true, s.velocity = {0, 0, 2}, s.rate = 1, s.from = 2, s.until = 9,
    s.ramp = 2;
    p.sources = {s};
    auto once = Simulation::make(p, wind(1)), half = Simulation::make(p, wind(1)), again = Simulation::make(p, wind(1));
    half->advance_to(5);
    std::stringstream state;
    half->save(state), again->restore(state);
    once->advance_to(5), once->advance_to(12), again->advance_to(12);
    for (const Quantity q : {Quantity::U, Quantity::W, Quantity::Theta, Quantity::Dye})
        EXPECT_EQ(all(*once, q), all(*again, q));
    EXPECT_LT(std::abs(once->budget().dye_drift), 1e-6);
    EXPECT_LT(std::abs(once->budget().theta_drift), 1e-6);
    EXPECT_GT(once->budget().w_max, 1);
}

TEST(Sources, OfWhatARunLacksAreRefused)
{
    const auto refused = [](const std::function<void(FieldSource&)>& change) {
        Parameters p = bare({4, 4, 4}, {4, 4, 4});
        p.momentum = false;
        FieldSource s = everywhere_source();
        change(s);
        p.sources = {s};
        EXPECT_THROW(check(p, wind(0)), InputError);
    };
    refused([](FieldSource& s) { s.heat = 1; });
    refused([](FieldSource& s) { s.water = 1; });
    refused([](FieldSource& s) { s.dye = 1; });
    refused([](FieldSource& s) { s.fuel = 1; });
    refused([](FieldSource& s) { s.has_velocity = true, s.rate = 1; });
    refused([](FieldSource& s) { s.from = 2, s.until = 2; });
    refused([](FieldSource& s) { s.until = 2, s.ramp = 1.5; });
    refused([](FieldSource& s) { s.rate = -1; });
}

}  // namespace
}  // namespace vdbcloud::sim
