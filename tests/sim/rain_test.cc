// Warm rain against the published formulas of Kessler 1969 as Klemp and Wilhelmson 1978 give them, evaluated here with
// their own constants and units (g/cm^3, mbar).
#include "air.h"

#include <gtest/gtest.h>

#include <functional>

namespace vdbcloud::sim {
namespace {

using namespace test;

constexpr int levels = 16;

/// Still air in columns of 16 cells of dz [m], rain on; one step of dt [s] by forward differences.
Parameters columns(double dz, double dt)
{
    Parameters p = bare({2, 3, levels}, {200, 300, levels * dz});
    p.momentum = false, p.moisture = p.rain = true;
    p.moist = {SaturationBy::Height, true, true, true};
    p.q_scale_height = 3000;
    p.time_scheme = TimeScheme::Euler;
    p.dt = dt;
    return p;
}

/// q_t and q_r by level.
using Profile = std::function<double(const Level&)>;

std::unique_ptr<Simulation> start(const Parameters& p, const Profile& q_t, const Profile& q_r)
{
    auto sim = Simulation::make(p, {"air", {0}, {300}, {0}, {0}, {0}, 0});
    const size_t plane = size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]);
    std::vector<double> water, rain;
    for (const Level& level : sim->column().level)
        for (size_t c = 0; c < plane; ++c) water.push_back(q_t(level)), rain.push_back(q_r(level));
    sim->set(Quantity::Water, water);
    sim->set(Quantity::Rain, rain);
    sim->start();
    return sim;
}

/// One value a level, of the first column.
std::vector<double> profile(const Simulation& sim, Quantity q)
{
    const auto values = all(sim, q);
    std::vector<double> column;
    for (size_t k = 0; k < size_t(levels); ++k) column.push_back(values[k * values.size() / levels]);
    return column;
}

/// Rain that cloud [kg/kg] gives within dt where q_c and q_r are the same in every cell: as much falls in as out, so
/// cells below the lid hold exactly what conversion leaves.
void expect_conversion(double q_c, double q_r, double expected, double droplets = 0)
{
    const double dt = 2;
    Parameters p = columns(200, dt);
    p.droplets = droplets;
    auto sim = start(
        p, [&](const Level& l) { return l.q_height + q_c; }, [&](const Level&) { return q_r; });
    const auto theta = profile(*sim, Quantity::Theta), water = profile(*sim, Quantity::Water);
    sim->advance_to(dt);
    const auto rain = profile(*sim, Quantity::Rain), dried = profile(*sim, Quantity::Water),
               warmed = profile(*sim, Quantity::Theta);
    const double heat = 2.5e6 / 1004;
    for (size_t k = 0; k + 1 < size_t(levels); ++k) {
        // Rounding of q_t (0.02, so 3e-18) and theta (300 K, so 6e-14 K).
        EXPECT_NEAR(rain[k] - q_r, expected * dt, 1e-16) << k;
        EXPECT_NEAR(water[k] - dried[k], expected * dt, 1e-16) << k;
        EXPECT_NEAR(warmed[k] - theta[k], heat * expected * dt, 1e-12) << k;
    }
}

TEST(Rain, AutoconversionIsAThousandthOfTheCloudAboveOneGramAKilogram)
{
    expect_conversion(3e-3, 0, 1e-3 * (3e-3 - 1e-3));
    expect_conversion(1.5e-3, 0, 1e-3 * (1.5e-3 - 1e-3));
    expect_conversion(0.9e-3, 0, 0);
}

TEST(Rain, AccretionIsCloudTimesRainToTheSevenEighths)
{
    expect_conversion(0.5e-3, 1e-3, 2.2 * 0.5e-3 * std::pow(1e-3, 0.875));
    expect_conversion(0.2e-3, 4e-3, 2.2 * 0.2e-3 * std::pow(4e-3, 0.875));
    expect_conversion(2e-3, 1e-3, 1e-3 * (2e-3 - 1e-3) + 2.2 * 2e-3 * std::pow(1e-3, 0.875));
}

TEST(Rain, ConversionOfCountedDropletsIsThatOfKhairoutdinovAndKogan)
{
    // Tabulated in their units: mixing ratios in kg/kg, droplets in a cm^3.
    for (const double n : {30.0, 70.0, 400.0})
        for (const double q_c : {0.3e-3, 1e-3, 2e-3}) {
            const double alone = 1350 * std::pow(q_c, 2.47) / std::pow(n, 1.79);
            expect_conversion(q_c, 0, alone, n);
            expect_conversion(q_c, 5e-4, alone + 67 * std::pow(q_c * 5e-4, 1.15), n);
        }
}

TEST(Rain, ConversionTakesNotMoreThanTheCloudThereIs)
{
    // 2.2 * 0.05^0.875 * 2 s > 0.3: with dt = 60 s accretion would take 9 times the cloud.
    Parameters p = columns(1e5, 60);
    p.q_scale_height = 1e9;
    auto sim = start(
        p, [](const Level& l) { return l.q_height + 1e-4; }, [](const Level&) { return 0.05; });
    sim->advance_to(60);
    const auto cloud = all_cloud(*sim);
    EXPECT_LT(largest(cloud), 1e-17);
}

/// Bolton 1980, eq. 10.
double saturation(double t, double p)
{
    const double e = 611.2 * std::exp(17.67 * (t - 273.15) / (t - 29.65)), eps = 287.05 / 461.5;
    return eps * e / (p - (1 - eps) * e);
}

/// Klemp and Wilhelmson 1978, eq. 2.14: E_r [1/s]; rho [kg/m^3], p [Pa].
double evaporation(double q_v, double q_vs, double q_r, double rho, double p)
{
    const double rho_cgs = rho / 1000, mbar = p / 100;
    const double ventilation = 1.6 + 124.9 * std::pow(rho_cgs * q_r, 0.2046);
    return 1 / rho_cgs * (1 - q_v / q_vs) * ventilation * std::pow(rho_cgs * q_r, 0.525) /
           (5.4e5 + 2.55e6 / (mbar * q_vs));
}

TEST(Rain, EvaporationIsThePublishedFormulaAndCoolsAndMoistens)
{
    const double dt = 1, q_r = 8e-4;
    for (const SaturationBy by : {SaturationBy::Height, SaturationBy::Temperature})
        for (const double humidity : {0.3, 0.8}) {
            Parameters p = columns(250, dt);
            p.moist.by = by;
            const auto q_s = [&](const Level& l) {
                return by == SaturationBy::Height ? l.q_height : saturation(300 * l.exner, l.pressure);
            };
            auto sim = start(
                p, [&](const Level& l) { return humidity * q_s(l); }, [&](const Level&) { return q_r; });
            const auto theta = profile(*sim, Quantity::Theta), water = profile(*sim, Quantity::Water);
            sim->advance_to(dt);
            const auto warmed = profile(*sim, Quantity::Theta), wetted = profile(*sim, Quantity::Water);
            for (size_t k = 0; k < size_t(levels); ++k) {
                const Level& l = sim->column().level[k];
                const double gain = dt * evaporation(humidity * q_s(l), q_s(l), q_r, 1.16, l.pressure);
                ASSERT_GT(gain, 1e-8);
                // Air is not changed by what falls. Rounding of q_t against gains of 1e-7 is 1e-11 of them.
                EXPECT_NEAR((wetted[k] - water[k]) / gain, 1, 1e-8) << k;
                const double heat = 2.5e6 / 1004 / (by == SaturationBy::Height ? 1 : l.exner);
                EXPECT_NEAR((warmed[k] - theta[k]) / (-heat * gain), 1, 1e-8) << k;
            }
        }
}

TEST(Rain, EvaporationTakesNotMoreThanTheRainAndAQuarterOfTheDeficit)
{
    // dt of 600 s, dz of 1e6 m, so that nothing falls out of its cell.
    Parameters p = columns(1e6, 600);
    p.q_scale_height = 1e12;
    const auto gain = [&](double q_t, double q_r) {
        auto sim = start(
            p, [&](const Level&) { return q_t; }, [&](const Level&) { return q_r; });
        sim->advance_to(600);
        // What falls from cell to cell differs by what evaporated: q_s changes by 2e-8 a cell.
        EXPECT_NEAR(profile(*sim, Quantity::Rain)[3] + profile(*sim, Quantity::Water)[3], q_t + q_r, 1e-9);
        return profile(*sim, Quantity::Water)[3] - q_t;
    };
    EXPECT_NEAR(gain(0.001, 1e-9), 1e-9, 1e-17);  // all of it
    const double q_s = 0.02 * std::exp(-3.5e6 / 1e12);
    EXPECT_NEAR(gain(0.019, 0.5), 0.25 * (q_s - 0.019), 1e-12);
}

/// What leaves the only rainy cell of a column within dt, as a fraction of what it held.
double fraction_fallen(const Parameters& p, int cell, double q_r, double& arrived)
{
    auto sim = Simulation::make(p, {"air", {0}, {300}, {0}, {0}, {0}, 0});
    std::vector<double> rain(p.lattice.cells(), 0.0), water;
    const size_t plane = size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]);
    for (size_t c = 0; c < rain.size(); ++c) {
        if (c / plane == size_t(cell)) rain[c] = q_r;
        water.push_back(sim->column().level[c / plane].q_height);  // saturated: nothing evaporates
    }
    sim->set(Quantity::Water, water);
    sim->set(Quantity::Rain, rain);
    sim->start();
    sim->advance_to(p.dt);
    const auto after = profile(*sim, Quantity::Rain);
    arrived = cell > 0 ? after[size_t(cell) - 1] : sim->budget().rain_fallen;
    return 1 - after[size_t(cell)] / q_r;
}

TEST(Rain, FallsAtTheTerminalVelocityOfKessler)
{
    // V = 3634 cm/s (rho q_r)^0.1346 (rho_floor / rho)^0.5, rho in g/cm^3; upwind in one step, V dt / dz leaves.
    for (const double q_r : {1e-4, 2e-3}) {
        Parameters p = columns(250, 5);
        const double v = 36.34 * std::pow(1.16e-3 * q_r, 0.1346);
        ASSERT_GT(v, 4);
        ASSERT_LT(v * p.dt, 250);
        double arrived;
        // Saturated to rounding: what evaporates or condenses of 1e-18 is not seen.
        EXPECT_NEAR(fraction_fallen(p, 7, q_r, arrived) / (v * p.dt / 250), 1, 1e-9);
        EXPECT_NEAR(arrived / (q_r * v * p.dt / 250), 1, 1e-9);
        // From the lowest cell onto the floor [kg/m^2].
        EXPECT_NEAR(fraction_fallen(p, 0, q_r, arrived) / (v * p.dt / 250), 1, 1e-9);
        EXPECT_NEAR(arrived / (1.16 * q_r * v * p.dt), 1, 1e-9);
    }
}

TEST(Rain, FallsFasterInThinAirAndConservesItsMass)
{
    Parameters p = columns(500, 5);
    p.anelastic = true;
    const auto column = make_column(p, {"air", {0}, {300}, {0}, {0}, {0}, 0});
    const double q_r = 1e-3, rho = column.rho_centre[12], below = column.rho_centre[11];
    ASSERT_LT(rho, 0.6);
    const double v = 36.34 * std::pow(1.16e-3 * rho * q_r, 0.1346) * std::sqrt(1 / rho);
    double arrived;
    EXPECT_NEAR(fraction_fallen(p, 12, q_r, arrived) / (v * p.dt / 500), 1, 1e-9);
    EXPECT_NEAR(arrived / (q_r * v * p.dt / 500 * rho / below), 1, 1e-9);
}

TEST(Rain, OneLongStepFallsAsFarAsManyShortOnes)
{
    // From one cell into dry cells below, 60 s at about 5 m/s. Short steps smear the rain over some 7 cells, long ones
    // over 2 to 3: the speed, which goes as q^0.1346, and so the distance, differ by up to (7 / 2)^0.1346 = 1.18 or a
    // little more. Rain that stopped in the first dry cell would have fallen 50 m, not 300.
    double height[2];
    for (const bool short_steps : {false, true}) {
        Parameters p = columns(50, short_steps ? 1 : 60);
        auto sim = Simulation::make(p, {"air", {0}, {300}, {0}, {0}, {0}, 0});
        std::vector<double> rain(p.lattice.cells(), 0.0), water;
        const size_t plane = size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]);
        for (size_t c = 0; c < rain.size(); ++c) {
            if (c / plane == 14) rain[c] = 1e-3;
            water.push_back(sim->column().level[c / plane].q_height);  // saturated: nothing evaporates
        }
        sim->set(Quantity::Water, water);
        sim->set(Quantity::Rain, rain);
        sim->start();
        sim->advance_to(60);
        const auto after = profile(*sim, Quantity::Rain);
        double sum = 0, moment = 0;
        for (size_t k = 0; k < size_t(levels); ++k) sum += after[k], moment += after[k] * 50 * (double(k) + 0.5);
        EXPECT_NEAR(sum, 1e-3, 1e-8);  // the smeared front leaves 1e-6 of it on the floor
        height[short_steps] = moment / sum;
    }
    EXPECT_GT(725 - height[1], 250);
    EXPECT_NEAR((725 - height[0]) / (725 - height[1]), 1, 0.25);
}

TEST(Rain, WaterInTheAirAndOnTheFloorIsConservedWhileItRains)
{
    Parameters p = columns(100, 20);  // V dt of more than a cell: sub-steps
    p.anelastic = true;
    auto sim = start(
        p, [](const Level& l) { return l.q_height * (l.z > 800 ? 1.2 : 0.7); },
        [](const Level& l) { return l.z > 600 ? 5e-3 : 0; });
    const auto mass = [&] {
        const auto water = profile(*sim, Quantity::Water), rain = profile(*sim, Quantity::Rain);
        double sum = sim->budget().rain_fallen;
        for (size_t k = 0; k < size_t(levels); ++k)
            sum += (water[k] + rain[k]) * 1.16 * sim->column().rho_centre[k] * 100;
        return sum;
    };
    const double before = mass();
    sim->advance_to(600);
    EXPECT_GT(sim->budget().rain_fallen, 0.1);
    EXPECT_NEAR(mass() / before, 1, 1e-12);
}

}  // namespace
}  // namespace vdbcloud::sim
