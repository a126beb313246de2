// Repeatability, restarts, memory, huge steps, refusals, and invariants under random parameters.
#include "air.h"
#include "support/size.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/presets.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// A busy scene with every effect on, on a small box.
Preset everything(Precision precision = Precision::Float)
{
    Preset s = preset("cumulus");
    Parameters& p = s.parameters;
    const Lattice before = p.lattice;
    p.lattice = {{20, 18, 24}, {200, 220, 150}, {Side::Open, Side::Periodic}};
    rescale_forcing(p, before);
    p.precision = precision;
    p.rain = p.anelastic = p.dye = p.subgrid = true;
    p.friction_time = 2000, p.viscosity = 2, p.diffusivity = 1, p.radiation = 50, p.wind_relaxation = 900;
    p.bubbles.push_back({{2000, 2000, 1200}, 900, 500, 2, 6e-3, 1});
    return s;
}

std::string state_of(const Simulation& sim)
{
    std::ostringstream out;
    sim.save(out);
    return out.str();
}

TEST(Robust, ThreadsAndRepetitionGiveEqualBits)
{
    for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::Rk2, TimeScheme::Euler, TimeScheme::HugeStep}) {
        std::string states[3];
        for (int run = 0; run < 3; ++run) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, run == 1 ? 1 : 2);
            Preset s = everything();
            s.parameters.time_scheme = scheme;
            auto sim = Simulation::make(s.parameters, s.sounding);
            sim->advance_to(120);
            EXPECT_GT(sim->budget().cloud_max, 1e-4);
            states[run] = state_of(*sim);
        }
        EXPECT_EQ(states[0], states[1]) << int(scheme);
        EXPECT_EQ(states[0], states[2]) << int(scheme);
    }
}

TEST(Robust, RestartContinuesWithEqualBits)
{
    for (const Precision precision : {Precision::Float, Precision::Double})
        for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::Euler, TimeScheme::HugeStep}) {
            Preset s = everything(precision);
            s.parameters.time_scheme = scheme;
            auto whole = Simulation::make(s.parameters, s.sounding), first = Simulation::make(s.parameters, s.sounding);
            whole->advance_to(60), whole->advance_to(120);
            first->advance_to(60);
            std::istringstream in(state_of(*first));
            auto second = Simulation::make(s.parameters, s.sounding);
            second->restore(in);
            second->advance_to(120);
            EXPECT_EQ(state_of(*whole), state_of(*second)) << int(scheme);
            EXPECT_EQ(whole->budget().water_drift, second->budget().water_drift);
        }
}

TEST(Robust, MemoryMatchesThePlanAndOffEffectsHaveNone)
{
    const auto measured = [](const Parameters& p) {
        auto sim = Simulation::make(p, Sounding::uniform(300));
        EXPECT_NEAR(double(sim->bytes()) / double(memory_needed(p)), 1, 0.02);
        return double(sim->bytes()) / double(p.lattice.cells()) / 4;
    };
    Parameters p;
    p.lattice = {{64, 64, 64}, {50, 50, 50}, {Side::Periodic, Side::Periodic}};
    const double all = measured(p);
    Parameters dry = p;
    dry.moisture = false;
    const double without_water = measured(dry);
    EXPECT_NEAR((all - without_water) / 4, 80. / 64 * 72 / 64 * 72 / 64, 0.02);  // four arrays of a field, padded
    Parameters still = dry;
    still.momentum = still.buoyancy = false, still.dye = true;
    EXPECT_LT(measured(still), 0.55 * without_water);  // wind, dye with its stages, drain times
    Parameters slice = p;
    slice.lattice.n[1] = 1;
    EXPECT_LT(measured(slice), 26);
    for (const Effect& e : effects())
        EXPECT_TRUE(!e.on(still) || (e.name != "momentum and pressure" && e.name != "moisture")) << e.name;
}

TEST(Robust, GivenWindCarriesDyeWithoutPressure)
{
    Parameters p = bare({64, 1, 4}, {6400, 6400, 400});
    p.momentum = false, p.dye = true;
    p.scalar_scheme = ScalarScheme::Limited5;
    p.cfl = 0.375;
    p.bubbles.push_back({{1600, 0, 200}, 800, 1e9, 0, 0, 1});
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {10}, {0}, 0});
    sim->start();
    const auto before = all(*sim, Quantity::Dye);
    sim->advance_to(640);  // once around
    const auto after = all(*sim, Quantity::Dye);
    double sum = 0, was = 0;
    for (size_t i = 0; i < after.size(); ++i) sum += after[i], was += before[i];
    EXPECT_NEAR(sum / was, 1, 1e-12);
    EXPECT_LT(largest_difference(before, after), 0.1 * largest(before));  // the limiter flattens the peak
    EXPECT_LE(largest(after), largest(before) * (1 + 1e-12));
    for (const double v : after) EXPECT_GE(v, 0);
}

TEST(Robust, StepOverTheLimitIsSplitAndEndsOnTheFrame)
{
    Parameters p = bare({16, 1, 16}, {1600, 1600, 1600});
    p.buoyancy = true;
    p.dt = 600;
    p.bubbles.push_back({{800, 0, 500}, 400, 400, 3, 0, 0});
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->advance_to(300);
    EXPECT_EQ(sim->time(), 300);
    EXPECT_GT(sim->budget().steps, 10);
    EXPECT_LE(sim->budget().courant, 1);
    EXPECT_GT(sim->budget().w_max, 2);
}

TEST(Robust, HugeStepsStayBounded)
{
    Preset s = preset("cumulus");
    s.parameters.lattice = {{24, 24, 24}, {170, 170, 170}, {Side::Periodic, Side::Periodic}};
    s.parameters.time_scheme = TimeScheme::HugeStep;
    s.parameters.dt = 600;
    auto sim = Simulation::make(s.parameters, s.sounding);
    sim->advance_to(6000);
    const Budget b = sim->budget();
    EXPECT_EQ(b.steps, 10);
    EXPECT_LT(b.speed_max, 500);
    EXPECT_LT(std::abs(b.water_drift), 1);
    EXPECT_NE(b.water_drift, 0);  // the report states the error
    EXPECT_EQ(b.fault, "");
}

/// Mean error of a round cloud of dye that a slanted wind has carried 2.6 cells a step, once through the box.
double carried_error(int n, bool maccormack)
{
    Parameters p = bare({n, n, 2}, {1000, 1000, 100});
    p.momentum = false, p.dye = true, p.time_scheme = TimeScheme::HugeStep, p.maccormack = maccormack;
    p.dt = 2.6 * 1000 / n / 10;
    const double turns = std::floor(100 / p.dt) * p.dt;  // whole steps
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {10}, {5}, 0});
    const auto blob = [&](double t) {
        return values_at(p.lattice, Quantity::Dye, [&, t](double x, double y, double) {
            const double r =
                std::hypot(std::remainder(x - 500 - 10 * t, 1000), std::remainder(y - 500 - 5 * t, 1000)) / 300;
            return r < 1 ? std::pow(std::cos(M_PI / 2 * r), 4) : 0.0;
        });
    };
    sim->set(Quantity::Dye, blob(0));
    sim->start();
    sim->advance_to(turns);
    const auto dye = all(*sim, Quantity::Dye), exact = blob(turns);
    double error = 0, sum = 0;
    for (size_t c = 0; c < dye.size(); ++c) error += std::abs(dye[c] - exact[c]), sum += exact[c];
    EXPECT_LE(largest(dye), 1);
    for (const double d : dye) EXPECT_GE(d, 0);
    return error / sum;
}

TEST(Robust, HugeStepsConvergeAtFirstOrderAndAtSecondWithMacCormack)
{
    const double linear[2] = {carried_error(48, false), carried_error(96, false)};
    const double corrected[2] = {carried_error(48, true), carried_error(96, true)};
    EXPECT_GT(std::log2(linear[0] / linear[1]), 0.7);
    EXPECT_LT(std::log2(linear[0] / linear[1]), 1.3);
    EXPECT_GT(std::log2(corrected[0] / corrected[1]), 1.6);
    EXPECT_LT(std::log2(corrected[0] / corrected[1]), 2.4);
    EXPECT_LT(corrected[1], 0.4 * linear[1]);  // clamping flattens the peak
    std::printf("huge steps, error at 48 and 96 cells: %.3f %.3f, with MacCormack %.4f %.4f\n", linear[0], linear[1],
                corrected[0], corrected[1]);
}

TEST(Robust, BudgetFixRemovesTheDriftOfHugeSteps)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        double drift[2], cloud[2];
        for (const bool fixed : {false, true}) {
            Preset s = preset("cumulus");
            s.parameters.lattice = {{16, 16, 16}, {240, 240, 240}, {Side::Periodic, Side::Periodic}};
            s.parameters.time_scheme = TimeScheme::HugeStep, s.parameters.precision = precision;
            s.parameters.dt = 60, s.parameters.maccormack = true, s.parameters.fix_budget = fixed;
            auto sim = Simulation::make(s.parameters, s.sounding);
            sim->advance_to(1200);
            const Budget b = sim->budget();
            drift[fixed] = std::abs(b.water_drift) + std::abs(b.theta_drift), cloud[fixed] = b.cloud_mean;
            EXPECT_GE(b.water_min, 0);
            EXPECT_EQ(b.water_corrected > 0, fixed);
        }
        EXPECT_GT(drift[0], 1e-5);  // the error without the fix
        EXPECT_LT(drift[1], precision == Precision::Float ? 1e-6 : 1e-12);
        EXPECT_GT(cloud[1], 1e-6);
    }
}

TEST(Robust, RefusesImpossibleValuesByName)
{
    const auto thrown = [](const std::function<void()>& work) -> std::string {
        try {
            work();
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    const auto refused = [&](const std::function<void(Parameters&)>& change) {
        Parameters p;
        p.lattice = {{8, 8, 8}, {100, 100, 100}, {Side::Periodic, Side::Periodic}};
        change(p);
        const std::string at_start = thrown([&] { Simulation::make(p, Sounding::uniform(300)); });
        // A plan, which makes no simulation, refuses what a run refuses.
        EXPECT_EQ(thrown([&] { check(p, Sounding::uniform(300)); }), at_start);
        return at_start;
    };
    EXPECT_EQ(refused([](Parameters&) {}), "");
    EXPECT_NE(refused([](Parameters& p) { p.friction_time = 0; }).find("friction time"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.viscosity = NAN; }).find("viscosity"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.lattice.h[2] = 0; }).find("spacing along z"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.lattice.n[2] = 1; }).find("cells along z"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.cfl = 2; }).find("cfl = 2"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.floor.moisture = -1; }).find("moisture flux"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.rain = true, p.moisture = false; }).find("rain"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.maccormack = true; }).find("huge steps"), std::string::npos);
    EXPECT_NE(refused([](Parameters& p) { p.lattice.h[2] = 5000; }).find("height of the box"), std::string::npos);
    EXPECT_EQ(refused([](Parameters& p) { p.constants.rho0 = 1e300; }), "rho0 = 1e+300: expected 0.001..1000 kg/m^3");
    const Bubble cold{{400, 400, 400}, 200, 200, -900, 0, 0};
    EXPECT_EQ(refused([&](Parameters& p) { p.bubbles = {cold}; }), "bubble temperature = -900: expected -200..1000");
    EXPECT_EQ(refused([&](Parameters& p) { p.bubbles = {cold}, p.bubbles[0].theta = -199; }), "");
    // Two bubbles that are allowed alone.
    const std::string both = refused([&](Parameters& p) {
        p.bubbles = {cold, cold};
        for (Bubble& b : p.bubbles) b.theta = -199;
    });
    EXPECT_NE(both.find("initial air: theta_l in cell ["), std::string::npos) << both;
    EXPECT_NE(both.find("expected 100..2000 K"), std::string::npos) << both;
    // Of other quantities, too; and bubbles that are too much together only if they meet.
    const auto several = [&](double water, double dye, double apart) {
        return refused([&](Parameters& p) {
            p.dye = true;
            for (const double x : {400 - apart, 400 + apart})
                p.bubbles.push_back({{x, 400, 400}, 200, 200, 0, water, dye});
        });
    };
    EXPECT_NE(several(0.9, 0, 0).find("initial air: q_t in cell ["), std::string::npos);
    EXPECT_NE(several(0, 9e5, 0).find("initial air: dye in cell ["), std::string::npos);
    EXPECT_EQ(several(0.9, 0, 200), "");
    EXPECT_EQ(several(0, 9e5, 200), "");
}

TEST(Robust, NumbersThatProgramsOfferHaveRangesThatAirCanHave)
{
    // At either end of any range of a constant, alone, a run is refused in a sentence or keeps its invariants.
    for (const auto* group : {&constant_settings(), &noise_settings()})
        for (const Setting& setting : *group)
            for (const double end : {setting.range.low, setting.range.high}) {
                if (!std::isfinite(end) || (setting.range.open && end == setting.range.low)) continue;
                EXPECT_LE(std::abs(end), 1e12) << setting.name;
                for (const SaturationBy by : {SaturationBy::Height, SaturationBy::Temperature}) {
                    Parameters p;
                    p.lattice = {{6, 5, 6}, {100, 100, 100}, {Side::Periodic, Side::Periodic}};
                    p.moist.by = by, p.rain = p.anelastic = true;
                    p.bubbles.push_back({{300, 250, 200}, 200, 200, 2, 5e-3, 0});
                    setting.value(p) = end;
                    SCOPED_TRACE(setting.name + " = " + std::to_string(end));
                    try {
                        auto sim = Simulation::make(p, {"humid", {0}, {300}, {0.012}, {2}, {1}, 0});
                        int steps = 0;
                        sim->advance_to(10, [&](double) { return ++steps < 40; });
                        EXPECT_EQ(sim->budget().fault, "");
                    } catch (const InputError&) {
                    } catch (const Cancelled&) {
                    }
                }
            }
}

TEST(Robust, NamesTheCellOfAValueThatAirCannotHave)
{
    Parameters p = bare({8, 8, 8}, {800, 800, 800});
    p.buoyancy = p.moisture = p.dye = p.rain = true;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    const struct {
        Quantity q;
        double usual, bad, good;
        const char* sentence;
    } cases[] = {
        {Quantity::U, 0, 1e30, 500, "file: u in cell [3, 5, 6] = 1e+30: expected -500..500 m/s (the equations"},
        {Quantity::V, 0, -1e6, -500, "file: v in cell [3, 5, 6] = -1e+06: expected -500..500 m/s (the equations"},
        {Quantity::W, 0, 501, 499, "file: w in cell [3, 5, 6] = 501: expected -500..500 m/s (the equations"},
        {Quantity::Theta, 300, 99, 101, "file: theta_l in cell [3, 5, 6] = 99: expected 100..2000 K"},
        {Quantity::Water, 0.01, 1e30, 1, "file: q_t in cell [3, 5, 6] = 1e+30: expected 0..1 kg/kg"},
        {Quantity::Water, 0.01, -1e-9, 0, "file: q_t in cell [3, 5, 6] = -1e-09: expected 0..1 kg/kg"},
        {Quantity::Rain, 0, 2, 1, "file: rain in cell [3, 5, 6] = 2: expected 0..1 kg/kg"},
        {Quantity::Dye, 0, 1e300, 1e6, "file: dye in cell [3, 5, 6] = 1e+300: expected 0..1e+06"},
    };
    for (const auto& c : cases) {
        std::vector<double> values(512, c.usual);
        double& value = values[3 + 8 * (5 + 8 * 6)];
        value = c.good;
        EXPECT_NO_THROW(sim->set(c.q, values, "file")) << c.sentence;
        value = c.bad;
        try {
            sim->set(c.q, values, "file");
            ADD_FAILURE() << c.sentence;
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).rfind(c.sentence, 0), 0u) << error.what();
        }
    }
}

TEST(Robust, NamesTheCellOfANonFiniteInitialValue)
{
    Parameters p = bare({8, 8, 8}, {800, 800, 800});
    p.buoyancy = true;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    std::vector<double> theta(512, 300);
    theta[3 + 8 * (5 + 8 * 6)] = NAN;
    try {
        sim->set(Quantity::Theta, theta);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("[3, 5, 6]"), std::string::npos) << error.what();
    }
}

void watch(Simulation& sim, bool single)
{
    const Parameters& p = sim.parameters();
    int steps = 0;
    for (const double end : {30.0, 600.0}) {
        try {
            sim.advance_to(end, [&](double) { return ++steps < 60; });
        } catch (const Cancelled&) {
        }
        const Budget b = sim.budget();  // throws, naming a cell, if anything is not finite
        ASSERT_TRUE(std::isfinite(b.kinetic) && std::isfinite(b.theta_mean) && std::isfinite(b.water_mean));
        ASSERT_EQ(b.fault, "") << "after " << b.time << " s, " << b.steps << " steps";
        ASSERT_GE(b.water_min, 0);
        if (b.new_extrema >= 0 && p.time_scheme != TimeScheme::HugeStep) {
            // What divergence is left compresses what it carries: nothing to see but in boxes far from cubes in float.
            // Its rate is the divergence times the wind over the spacing, where the wind is what pushes against walls.
            const auto& h = p.lattice.h;
            double windiest = std::max(b.speed_max, 0.1);
            for (size_t k = 0; k < sim.column().u.size(); ++k)
                windiest = std::max({windiest, std::abs(sim.column().u[k]), std::abs(sim.column().v[k])});
            const double compressed = b.time * windiest / std::min({h[0], h[1], h[2]});
            ASSERT_LE(b.new_extrema, (single ? 1e-5 : 1e-12) + std::max(200.0, compressed) * b.divergence)
                << "after " << b.time << " s, " << b.steps << " steps";
        }
        for (const double q : all_cloud(sim)) ASSERT_GE(q, 0);
    }
}

/// Random parameters of all kinds, with many extremes.
/// Returns false if they were refused.
bool check_random(uint64_t seed)
{
    SCOPED_TRACE("seed " + std::to_string(seed));
    uint64_t draw = 0;
    const auto random = [&] { return uniform(hash_bits(4711, seed, draw++)); };
    const auto below = [&](int n) { return int(random() * n); };
    const auto chance = [&](double p) { return random() < p; };
    const auto from = [&](std::initializer_list<double> list) { return list.begin()[below(int(list.size()))]; };

    Parameters p;
    const int sizes[] = {1, 2, 3, 5, 7, 8, 11, 13, 16, 20};
    p.lattice.n = {sizes[below(10)], sizes[below(10)], std::max(2, sizes[below(10)])};
    const double h = from({1, 30, 100, 500});
    p.lattice.h = {h, h * from({1, 1, 0.5, 3}), h * from({1, 1, 0.05, 0.3, 3, 20})};
    if (p.lattice.n[2] * p.lattice.h[2] > 9000) p.lattice.h[2] = 9000.0 / p.lattice.n[2];
    for (Side& side : p.lattice.side) side = Side(below(3));
    p.precision = Precision(below(2));
    p.momentum = !chance(0.1), p.buoyancy = !chance(0.1), p.moisture = !chance(0.2), p.anelastic = chance(0.3);
    p.rain = p.moisture && chance(0.3), p.dye = chance(0.3), p.subgrid = chance(0.3);
    p.moist = {SaturationBy(below(2)), !chance(0.1), chance(0.7), chance(0.7)};
    p.friction_time = chance(0.5) ? never : from({1e-9, 0.1, 10, 1000, 1e12});
    p.viscosity = chance(0.7) ? 0 : from({0.01, 1, 100, 1e4}),
    p.diffusivity = chance(0.7) ? 0 : from({0.01, 1, 100, 1e4});
    p.radiation = p.moisture && chance(0.3) ? from({1, 70, 5000}) : 0;
    p.sponge = chance(0.5) ? 0 : from({1e-3, 0.05, 5});
    p.wind_relaxation = chance(0.7) ? never : from({1, 600});
    p.constants.g = chance(0.9) ? 9.81 : from({0, 1, 100});
    p.floor.heat = chance(0.5) ? 0 : from({-1, 0.1, 50});
    p.floor.moisture = chance(0.5) ? 0 : from({1e-4, 0.05});
    if (chance(0.4))
        p.floor.patches.push_back({{100 * random(), 100 * random()}, h, from({0.1, 100}), from({0, 0.1}), 1});
    if (chance(0.6)) {
        const double lx = p.lattice.n[0] * p.lattice.h[0], ly = p.lattice.n[1] * p.lattice.h[1],
                     lz = p.lattice.n[2] * p.lattice.h[2];
        p.bubbles.push_back({{lx * random(), ly * random(), lz * random()},
                             2 * h,
                             2 * p.lattice.h[2],
                             from({-30, 2, 200}),
                             from({0, 1e-3, 0.3}),
                             from({0, 1})});
    }
    p.noise = {from({0, 0.1, 10}), from({0, 1e-4, 0.02}), never, seed};
    p.time_scheme = TimeScheme(below(4));
    p.scalar_scheme = ScalarScheme(below(3));
    p.momentum_scheme = MomentumScheme(below(2));
    p.dt = chance(0.5) ? 0 : from({0.1, 10, 600});
    p.cfl = from({0.1, 0.5, 0.7, 0.75});
    Sounding s{"random",
               {0, 500, 520, 4000},
               {300, 300, 300 + from({0, 20}), 300 + from({-5, 0, 15, 60})},
               {from({0, 0.01, 0.03}), 0.01, 0.01, from({0, 0.005, 0.05})},
               {from({0, 5, 80}), 0, 0, 10},
               {0, from({0, -40}), 0, 0},
               0};

    p.maccormack = p.time_scheme == TimeScheme::HugeStep && chance(0.5);
    p.fix_budget = p.time_scheme == TimeScheme::HugeStep && chance(0.5);

    std::ostringstream traits;
    traits << "scheme " << int(p.time_scheme) << int(p.scalar_scheme) << int(p.momentum_scheme) << " precision "
           << int(p.precision) << " cells " << p.lattice.n[0] << ' ' << p.lattice.n[1] << ' ' << p.lattice.n[2] << " h "
           << p.lattice.h[0] << ' ' << p.lattice.h[1] << ' ' << p.lattice.h[2] << " sides " << int(p.lattice.side[0])
           << int(p.lattice.side[1]) << " diffusivity " << p.diffusivity << " viscosity " << p.viscosity << " subgrid "
           << p.subgrid << " rain " << p.rain << " momentum " << p.momentum << " dt " << p.dt << " cfl " << p.cfl
           << " g " << p.constants.g << " anelastic " << p.anelastic;
    SCOPED_TRACE(traits.str());
    std::unique_ptr<Simulation> sim;
    try {
        sim = Simulation::make(p, s);
    } catch (const InputError&) {
        return false;  // refused before the first step, in one sentence
    }
    sim->start();
    const bool single = p.precision == Precision::Float;
    watch(*sim, single);
    return true;
}

TEST(Robust, RandomParametersSurviveAndKeepTheirInvariants)
{
    const int sets = vdbcloud::test::sized(40, 500);
    int ran = 0;
    for (int i = 0; i < sets; ++i) ran += check_random(uint64_t(i));
    EXPECT_GT(ran, sets * 3 / 4);
}

}  // namespace
}  // namespace vdbcloud::sim
