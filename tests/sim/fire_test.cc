// Fuel, heat and soot against closed forms, and the fire that they make together.
#include "air.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/presets.h"

#include <gtest/gtest.h>

#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Air at rest in which fuel can burn; temperature and potential temperature are one.
Parameters still_fire()
{
    Parameters p = bare({2, 3, 2}, {2, 3, 2});
    p.momentum = false, p.buoyancy = p.dye = p.combustion.on = true;
    p.moist.by = SaturationBy::Height;
    return p;
}

/// Two levels of 2 km each, where temperature and density fall.
void make_tall(Parameters& p) { p.lattice.h[2] = 2000, p.moist.by = SaturationBy::Temperature, p.anelastic = true; }
double exner(const Simulation& sim, size_t cell)
{
    return sim.parameters().moist.by == SaturationBy::Temperature ? sim.column().level[cell / 6].exner : 1;
}

std::unique_ptr<Simulation> lit(const Parameters& p, double temperature, double fuel)
{
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::Theta, std::vector<double>(p.lattice.cells(), temperature));
    if (sim->has(Quantity::Fuel)) sim->set(Quantity::Fuel, std::vector<double>(p.lattice.cells(), fuel));
    sim->start();
    return sim;
}

TEST(Combustion, TurnsFuelToHeatAndSootByAnExactFactor)
{
    Parameters p = still_fire();
    p.combustion = {true, 0.3, 2000, 2.5, 500, 1900};
    for (const double dt : {0.01, 0.5, 0.25}) {
        p.dt = dt;
        if (dt == 0.25) make_tall(p);
        auto sim = lit(p, 600, 0.4);
        sim->advance_to(0.5);
        const double left = 0.4 * std::exp(-0.5 / 0.3);
        for (const double y : all(*sim, Quantity::Fuel)) EXPECT_NEAR(y, left, 1e-13);
        for (size_t c = 0; c < 12; ++c)
            EXPECT_NEAR(all(*sim, Quantity::Theta)[c], 600 + 2000 * (0.4 - left) / exner(*sim, c), 1e-9);
        for (const double s : all(*sim, Quantity::Dye)) EXPECT_NEAR(s, 2.5 * (0.4 - left), 1e-13);
        std::vector<double> flame(6);
        sim->get_flame_plane(1, flame.data());
        for (const double f : flame) EXPECT_NEAR(f, 2000 / 0.3 * left, 1e-9);
        const Budget b = sim->budget();
        EXPECT_LT(std::abs(b.fuel_drift), 1e-12);
        EXPECT_LT(std::abs(b.dye_drift), 1e-12);
        EXPECT_LT(std::abs(b.theta_drift), 1e-12);
        EXPECT_NEAR(b.fuel_mean, left, 1e-13);
    }
}

TEST(Combustion, NeedsIgnitionAndEndsAtTheFlamesTemperature)
{
    Parameters p = still_fire();
    p.combustion = {true, 0.1, 4000, 1, 500, 1900}, p.dt = 0.01;
    auto cold = lit(p, 500, 0.5);
    cold->advance_to(1);
    EXPECT_EQ(all(*cold, Quantity::Fuel), std::vector<double>(12, 0.5));
    Parameters tall = p;
    make_tall(tall);
    auto high = lit(tall, 530, 0.5);  // a potential temperature
    high->advance_to(1);
    EXPECT_LT(all(*high, Quantity::Fuel)[0], 0.4) << 530 * exner(*high, 0);
    EXPECT_EQ(all(*high, Quantity::Fuel)[6], 0.5) << 530 * exner(*high, 6);
    // b = (T_flame - T) / heat is less than the fuel: dT/dt = (T_flame - T) / time.
    auto rich = lit(p, 700, 0.9);
    rich->advance_to(0.2);
    const double t = 1900 - 1200 * std::exp(-2.0);
    for (const double v : all(*rich, Quantity::Theta)) EXPECT_NEAR(v, t, 1e-9);
    for (const double v : all(*rich, Quantity::Fuel)) EXPECT_NEAR(v, 0.9 - (t - 700) / 4000, 1e-12);
}

TEST(Cooling, FollowsTheFourthPowerExactlyForAnyStep)
{
    Parameters p = still_fire();
    p.combustion.on = p.dye = false, p.cooling = 3000, p.cooling_temperature = 1900;
    for (const double dt : {0.01, 2.0}) {
        p.dt = dt;
        auto sim = lit(p, 1500, 0);
        sim->advance_to(2);
        const double x = 1200 / 1600.0;
        const double expected = 300 + 1600 * std::pow(std::pow(x, -3) + 3 * 3000 * 2 / 1600.0, -1.0 / 3);
        for (const double t : all(*sim, Quantity::Theta)) EXPECT_NEAR(t, expected, 1e-8);
        EXPECT_LT(std::abs(sim->budget().theta_drift), 1e-12);
    }
    Parameters tall = p;
    make_tall(tall);
    auto high = lit(tall, 1500, 0);
    high->advance_to(2);
    for (size_t c = 0; c < 12; ++c) {
        const double ex = exner(*high, c), span = 1900 - 300 * ex, x = 1200 * ex / span;
        const double expected = 300 * ex + span * std::pow(std::pow(x, -3) + 3 * 3000 * 2 / span, -1.0 / 3);
        EXPECT_NEAR(all(*high, Quantity::Theta)[c] * ex, expected, 1e-8);
    }
    EXPECT_LT(std::abs(high->budget().theta_drift), 1e-12);
    // Air as warm as its environment, or colder, radiates nothing.
    auto cold = lit(p, 290, 0);
    cold->advance_to(2);
    EXPECT_EQ(all(*cold, Quantity::Theta), std::vector<double>(12, 290));
}

TEST(HotBuoyancy, IsBoundedByGravityAndIsBoussinesqForSmallDeviations)
{
    const Constants c;
    MoistTerms hot{SaturationBy::Height, false, false, false, true}, plain = hot;
    plain.hot = false;
    const Reference reference{300, 0};
    const Thermodynamics a(c, hot, false, reference), b(c, plain, false, reference);
    const Level level{};
    EXPECT_NEAR(a.buoyancy(level, 0.01, 0) / b.buoyancy(level, 0.01, 0), 1 / (1 + 0.01 / 300), 1e-12);
    EXPECT_NEAR(a.buoyancy(level, 1500, 0), c.g * 1500 / 1800, 1e-12);
    EXPECT_LT(a.buoyancy(level, 1e6, 0), c.g);
    EXPECT_EQ(a.buoyancy(level, 0, 0), 0);
    EXPECT_NEAR(b.buoyancy(level, 1500, 0), 5 * c.g, 1e-9);
}

Preset small_fire()
{
    Preset s = preset("fire");
    const Lattice before = s.parameters.lattice;
    for (const size_t d : {0, 1, 2}) {
        s.parameters.lattice.n[d] = before.n[d] / 3;
        s.parameters.lattice.h[d] *= double(before.n[d]) / s.parameters.lattice.n[d];
    }
    return s;
}

TEST(Fire, HasAHotCoreUnderCoolingSmokeAndClosedBudgets)
{
    const Preset s = small_fire();
    auto sim = Simulation::make(s.parameters, s.sounding);
    sim->advance_to(4);  // the first puff has left
    const Budget b = sim->budget();
    EXPECT_EQ(b.fault, "");
    EXPECT_LT(std::abs(b.fuel_drift), 1e-6);
    EXPECT_LT(std::abs(b.dye_drift), 1e-6);
    EXPECT_LT(std::abs(b.theta_drift), 1e-6);
    EXPECT_GT(b.theta_max, 1200);
    EXPECT_LT(b.theta_max, s.parameters.combustion.flame);
    EXPECT_GT(b.theta_min, 287);  // noise of 5 K
    // Temperature that soot has in the mean, in four layers from the floor.
    const auto theta = all(*sim, Quantity::Theta), soot = all(*sim, Quantity::Dye);
    double heat[4] = {}, mass[4] = {};
    for (size_t c = 0; c < theta.size(); ++c) {
        const size_t layer = 4 * c / theta.size();
        heat[layer] += theta[c] * soot[c], mass[layer] += soot[c];
    }
    for (const size_t l : {0, 1, 2, 3}) ASSERT_GT(mass[l], 0) << l;
    for (const size_t l : {1, 2, 3}) EXPECT_LT(heat[l] / mass[l], heat[l - 1] / mass[l - 1]) << l;
    EXPECT_GT(heat[0] / mass[0], 700);
    EXPECT_LT(heat[3] / mass[3], 600);
}

TEST(Fire, ContinuesFromACheckpointWithEqualBits)
{
    const Preset s = small_fire();
    auto once = Simulation::make(s.parameters, s.sounding), half = Simulation::make(s.parameters, s.sounding),
         again = Simulation::make(s.parameters, s.sounding);
    half->advance_to(0.3);
    std::stringstream state;
    half->save(state), again->restore(state);
    once->advance_to(0.3), once->advance_to(0.5), again->advance_to(0.5);
    for (const Quantity q : {Quantity::U, Quantity::W, Quantity::Theta, Quantity::Dye, Quantity::Fuel})
        EXPECT_EQ(all(*once, q), all(*again, q));
    EXPECT_EQ(once->budget().fuel_drift, again->budget().fuel_drift);
}

TEST(Fire, EffectsThatLackTheirFieldsAreRefused)
{
    const Sounding air = Sounding::uniform(300);
    Parameters p = still_fire();
    EXPECT_NO_THROW(check(p, air));
    p.dye = false;
    EXPECT_THROW(check(p, air), InputError);
    p = still_fire(), p.buoyancy = false;
    EXPECT_THROW(check(p, air), InputError);
    p = still_fire(), p.combustion.ignition = 1950;
    EXPECT_THROW(check(p, air), InputError);
    p = still_fire(), p.moist.hot = p.moisture = true;
    EXPECT_THROW(check(p, air), InputError);
    p = still_fire(), p.combustion.on = false, p.floor.patches = {{{1, 1}, 1, 0, 0, 0, 1}};
    EXPECT_THROW(check(p, air), InputError);
}

}  // namespace
}  // namespace vdbcloud::sim
