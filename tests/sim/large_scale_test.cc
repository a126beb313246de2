// Large-scale forcing and the surface layer against closed forms.
#include "air.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/large_scale.h"
#include "vdbcloud/sim/presets.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Air that carries heat and water without clouds or buoyancy.
Parameters carrying(std::array<int, 3> n, std::array<double, 3> size)
{
    Parameters p = bare(n, size);
    p.moisture = true;
    p.moist = {SaturationBy::Height, false, false, false};
    return p;
}

/// theta_l, q_t, u and v linear in height up to the lid.
Sounding linear(double lid)
{
    return {"linear",
            {0, lid},
            {300, 300 + 5e-3 * lid},
            {0.012, 0.012 - 3e-6 * lid},
            {2, 2 + 4e-3 * lid},
            {-1, -1 - 2e-3 * lid},
            0};
}

/// Rates [unit/s] of every cell in one short step.
std::vector<double> rates(const Parameters& given, const Sounding& sounding, Quantity q)
{
    Parameters p = given;
    p.time_scheme = TimeScheme::Euler, p.dt = 1;
    auto sim = Simulation::make(p, sounding);
    sim->start();
    const auto before = all(*sim, q);
    sim->advance_to(1);
    auto rate = all(*sim, q);
    EXPECT_EQ(sim->budget().steps, 1u);
    for (size_t c = 0; c < rate.size(); ++c) rate[c] -= before[c];
    return rate;
}

TEST(Subsidence, OfLinearProfilesIsMinusWTimesTheGradientOnAllLevels)
{
    for (const double sign : {-1.0, 1.0})
        for (const bool anelastic : {false, true}) {
            Parameters p = carrying({3, 4, 10}, {600, 200, 1000});
            p.anelastic = anelastic;
            p.large_scale.z = {0, 600, 1000}, p.large_scale.w = {0, sign * 0.02, sign * 0.01};
            const std::pair<Quantity, double> gradients[] = {
                {Quantity::Theta, 5e-3}, {Quantity::Water, -3e-6}, {Quantity::U, 4e-3}, {Quantity::V, -2e-3}};
            for (const auto& [q, gradient] : gradients) {
                const auto rate = rates(p, linear(1000), q);
                for (size_t c = 0; c < rate.size(); ++c) {
                    const double z = (double(c / 12) + 0.5) * 100,
                                 w = sign * (z < 600 ? 0.02 * z / 600 : 0.02 - 0.01 * (z - 600) / 400);
                    EXPECT_NEAR(rate[c], -w * gradient, 2e-13) << int(q) << " " << c;
                }
            }
        }
}

TEST(Subsidence, TakesTheAirOfTheLevelThatItComesFrom)
{
    Parameters p = carrying({4, 3, 8}, {400, 300, 800});
    p.time_scheme = TimeScheme::Euler, p.dt = 10;
    p.large_scale.z = {0};
    for (const double w : {-0.5, 0.5}) {
        p.large_scale.w = {w};
        auto sim = Simulation::make(p, Sounding::uniform(300));
        sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta,
                                            [](double, double, double z) { return z < 400 ? 300.0 : 301.0; }));
        sim->start();
        sim->advance_to(10);
        const auto theta = all(*sim, Quantity::Theta);
        for (size_t k = 0; k < 8; ++k) {
            const double was = k < 4 ? 300 : 301, gain = w < 0 && k == 3 ? 0.05 : w > 0 && k == 4 ? -0.05 : 0;
            EXPECT_NEAR(theta[k * 12], was + gain, 1e-12) << w << " " << k;
        }
    }
}

TEST(Subsidence, SparesTheWindWhereThatIsAsked)
{
    Parameters p = carrying({3, 4, 10}, {300, 400, 1000});
    p.large_scale.z = {0}, p.large_scale.w = {-0.02}, p.large_scale.carries_wind = false;
    EXPECT_EQ(largest(rates(p, linear(1000), Quantity::U)), 0);
    EXPECT_NEAR(largest(rates(p, linear(1000), Quantity::Theta)), 0.02 * 5e-3, 1e-12);
}

TEST(Subsidence, OfAnyStrengthKeepsTheBoundsOfHeatAndWater)
{
    // 9 m/s through cells of 10 m, with diffusion: steps shrink to the sum of both limits.
    Parameters p = carrying({8, 1, 24}, {800, 100, 240});
    p.large_scale.z = {0}, p.large_scale.w = {-9};
    p.scalar_scheme = ScalarScheme::Limited5, p.diffusivity = 5;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta, [](double x, double, double z) {
                 return 300 + (std::abs(x - 400) < 150 && z > 100 ? 1.0 : 0.0);
             }));
    sim->start();
    sim->advance_to(60);
    for (const double theta : all(*sim, Quantity::Theta)) {
        EXPECT_GE(theta, 300 - 1e-9);
        EXPECT_LE(theta, 301 + 1e-9);
    }
}

TEST(LargeScale, TendenciesChangeEveryCellOfALevelAndTheBudgetsKnow)
{
    for (const Precision precision : {Precision::Double, Precision::Float}) {
        Parameters p = carrying({4, 4, 10}, {400, 400, 1000});
        p.precision = precision, p.anelastic = true, p.dt = 5;
        p.large_scale.z = {0, 1000}, p.large_scale.theta = {-4e-5, 0}, p.large_scale.water = {-2e-8, 1e-8};
        p.large_scale.w = {-0.01, -0.005};
        p.floor.heat = 8e-3, p.floor.moisture = 5.2e-5;
        p.noise = {0.1, 2.5e-5, never, 1};  // cells of a level round each in its own way
        auto sim = Simulation::make(p, linear(1000));
        sim->start();
        sim->advance_to(3600);
        const Budget b = sim->budget();
        const double tolerance = precision == Precision::Double ? 1e-12 : 1e-6;
        EXPECT_LT(std::abs(b.theta_drift), tolerance);
        EXPECT_LT(std::abs(b.water_drift), tolerance);
        EXPECT_EQ(b.fault, "");
        p.large_scale.w.clear(), p.floor = {}, p.noise = {};
        auto alone = Simulation::make(p, Sounding::uniform(300));
        alone->set(Quantity::Water, std::vector<double>(p.lattice.cells(), 0.012));
        alone->start();
        alone->advance_to(3600);
        const auto theta = all(*alone, Quantity::Theta), water = all(*alone, Quantity::Water);
        // In float 720 steps of four stages each round to half an ulp of the deviation.
        const double ulps = precision == Precision::Double ? 1e-11 : 2880 * 0.5 * std::pow(2.0, -24);
        for (size_t c = 0; c < theta.size(); ++c) {
            const double s = (double(c / 16) + 0.5) / 10;
            EXPECT_NEAR(theta[c], 300 - 4e-5 * (1 - s) * 3600, ulps * 0.15) << c;
            EXPECT_NEAR(water[c], 0.012 + (-2e-8 + 3e-8 * s) * 3600, ulps * 0.012) << c;
        }
    }
}

/// Distance from the inertial circle after one period.
double inertial_error(TimeScheme scheme, int steps)
{
    const double f = 1e-4, period = 2 * M_PI / f;
    Parameters p = bare({4, 5, 3}, {4e5, 5e5, 300});
    p.time_scheme = scheme, p.coriolis = f, p.dt = period / steps;
    p.large_scale.z = {0}, p.large_scale.u_g = {5}, p.large_scale.v_g = {-2};
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {8}, {2}, 0});
    sim->start();
    // A quarter of the circle first: clockwise on the northern hemisphere, where f > 0.
    sim->advance_to(period / 4);
    EXPECT_NEAR(all(*sim, Quantity::U)[7], 5 + 4, 30.0 / steps);
    EXPECT_NEAR(all(*sim, Quantity::V)[7], -2 - 3, 30.0 / steps);
    sim->advance_to(period);
    EXPECT_EQ(sim->budget().steps, uint64_t(steps));
    return std::hypot(all(*sim, Quantity::U)[7] - 8, all(*sim, Quantity::V)[7] - 2);
}

TEST(Coriolis, InertialOscillationHasItsPeriodAndTheOrderOfTheScheme)
{
    const std::tuple<TimeScheme, double, double> schemes[] = {
        {TimeScheme::Euler, 0.75, 1.4}, {TimeScheme::Rk2, 1.9, 2.1}, {TimeScheme::Rk3, 2.9, 3.1}};
    for (const auto& [scheme, least, most] : schemes) {
        const double coarse = inertial_error(scheme, 64), fine = inertial_error(scheme, 128);
        EXPECT_GT(std::log2(coarse / fine), least);
        EXPECT_LT(std::log2(coarse / fine), most);
    }
    EXPECT_LT(inertial_error(TimeScheme::Rk3, 128), 1e-3);
}

TEST(Coriolis, SoundingsWindIsGeostrophicWithoutAnother)
{
    Parameters p = bare({4, 4, 6}, {400, 400, 600});
    p.coriolis = 1e-4;
    EXPECT_LT(largest(rates(p, linear(600), Quantity::U)), 1e-15);
    EXPECT_LT(largest(rates(p, linear(600), Quantity::V)), 1e-15);
}

TEST(Coriolis, DoesNoWorkOnEddies)
{
    Parameters p = bare({8, 6, 4}, {800, 600, 400});
    p.time_scheme = TimeScheme::Euler, p.dt = 1e-3;
    const auto energy = [&](double f) {
        p.coriolis = f;
        auto sim = Simulation::make(p, Sounding::uniform(300));
        sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [](double x, double y, double) {
                     return std::sin(2 * M_PI * (x / 800 + 2 * y / 600)) + std::cos(4 * M_PI * x / 800);
                 }));
        sim->set(Quantity::V, values_at(p.lattice, Quantity::V, [](double x, double y, double) {
                     return std::cos(2 * M_PI * (x / 800 - y / 600) + 0.3);
                 }));
        sim->start();
        sim->advance_to(p.dt);
        return sim->budget().kinetic;
    };
    EXPECT_NEAR(energy(1e-1) / energy(0), 1, 1e-8);  // (f dt)^2
    EXPECT_GT(energy(0), 0.1);
}

TEST(Coriolis, IsRefusedInSlicesAndForAGivenWind)
{
    Parameters p = bare({8, 1, 4}, {800, 100, 400});
    p.coriolis = 1e-4;
    EXPECT_THROW(Simulation::make(p, Sounding::uniform(300)), InputError);
    p = bare({8, 8, 4}, {800, 800, 400});
    p.coriolis = 1e-4, p.momentum = false;
    EXPECT_THROW(Simulation::make(p, Sounding::uniform(300)), InputError);
}

TEST(Surface, StressTakesMomentumFromTheLowestCellsAlone)
{
    for (const bool anelastic : {false, true}) {
        Parameters p = bare({4, 5, 6}, {400, 500, 240});
        p.anelastic = anelastic;
        for (const bool law : {false, true}) {
            p.surface = {};
            (law ? p.surface.drag : p.surface.friction_velocity) = law ? 1.2e-3 : 0.28;
            const double speed = std::hypot(6.0, -2.5), stress = law ? 1.2e-3 * speed * speed : 0.28 * 0.28;
            const Sounding wind{"wind", {0}, {300}, {0}, {6}, {-2.5}, 0};
            auto sim = Simulation::make(p, wind);
            sim->start();
            const double rho = sim->column().rho_centre[0];
            for (const auto& [q, part] : {std::pair{Quantity::U, 6 / speed}, {Quantity::V, -2.5 / speed}}) {
                const auto rate = rates(p, wind, q);
                for (size_t c = 0; c < rate.size(); ++c)
                    EXPECT_NEAR(rate[c], c < 20 ? -stress * part / (40 * rho) : 0, 1e-12) << c;
                EXPECT_NEAR(sim->floor_flux(q), -stress * part, 1e-14);
            }
        }
    }
}

TEST(Surface, StressUsesTheWindOfEachCell)
{
    // u changes along y and v along x: the stress on u sees the mean of the four v around it.
    Parameters p = bare({8, 6, 2}, {800, 600, 80});
    p.surface.drag = 2e-3;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    const auto u = values_at(p.lattice, Quantity::U, [](double, double y, double) { return 3 + std::sin(y / 50); });
    const auto v = values_at(p.lattice, Quantity::V, [](double x, double, double) { return 1 + std::cos(x / 90); });
    sim->set(Quantity::U, u), sim->set(Quantity::V, v);
    sim->start();
    double along = 0;
    const auto at = [](const std::vector<double>& f, int i, int j) {
        return f[size_t((j + 6) % 6) * 8 + size_t((i + 8) % 8)];
    };
    for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 8; ++i) {
            const double other = (at(v, i, j) + at(v, i - 1, j) + at(v, i, j + 1) + at(v, i - 1, j + 1)) / 4;
            along -= 2e-3 * std::hypot(at(u, i, j), other) * at(u, i, j) / 48;
        }
    EXPECT_NEAR(sim->floor_flux(Quantity::U), along, 1e-14);
}

TEST(Surface, StressStopsAirWithoutTurningItRound)
{
    // 0.01 m/s of wind would be gone in 1 s: it falls by half a step and never turns round.
    Parameters p = bare({4, 4, 2}, {400, 400, 20});
    p.surface.friction_velocity = 0.3, p.dt = 5;
    auto sim = Simulation::make(p, {"breeze", {0, 5, 6}, {300, 300, 300}, {0, 0, 0}, {0.01, 0.01, 0}, {0, 0, 0}, 0});
    sim->start();
    double before = 0.01;
    for (int step = 1; step <= 20; ++step) {
        sim->advance_to(5 * step);
        const double now = all(*sim, Quantity::U)[0];
        EXPECT_GE(now, 0);
        EXPECT_LT(now, before);
        before = now;
    }
    EXPECT_LT(before, 1e-6);
}

TEST(Surface, ExchangeFollowsTheBulkLaw)
{
    for (const bool real : {false, true}) {
        Parameters p = carrying({4, 3, 5}, {400, 300, 200});
        p.moist.by = real ? SaturationBy::Temperature : SaturationBy::Height;
        p.anelastic = real;
        p.surface.heat_exchange = 1.1e-3, p.surface.water_exchange = 1.3e-3, p.surface.temperature = 299.8;
        const Sounding air{"air", {0}, {297.9}, {0.015}, {-8}, {4}, 101540};
        auto sim = Simulation::make(p, air);
        const double rho = sim->column().rho_centre[0], speed = std::hypot(8.0, 4.0);
        // Bolton 1980 over water at 26.65 C: 34.96 hPa; 0.622 of it over the pressure less 0.378 of it.
        const double e = 611.2 * std::exp(17.67 * (299.8 - 273.15) / (299.8 - 29.65)), ratio = 287.05 / 461.5;
        const double q_s = real ? ratio * e / (101540 - (1 - ratio) * e) : 0.02;
        const double warm = real ? 299.8 / std::pow(1.0154, 287.05 / 1004) : 299.8;
        for (const auto& [q, flux] : {std::pair{Quantity::Theta, 1.1e-3 * speed * (warm - 297.9)},
                                      {Quantity::Water, 1.3e-3 * speed * (q_s - 0.015)}}) {
            const auto rate = rates(p, air, q);
            for (size_t c = 0; c < rate.size(); ++c)
                EXPECT_NEAR(rate[c], c < 12 ? flux / (40 * rho) : 0, 1e-12) << int(q) << " " << c;
            EXPECT_GT(std::abs(flux), 1e-6);
        }
    }
}

TEST(LargeScale, ForcesActOnTheWindOverTheGroundInABoxThatMoves)
{
    for (const Quantity q : {Quantity::U, Quantity::V, Quantity::Theta, Quantity::Water}) {
        Parameters p = carrying({4, 3, 5}, {400, 300, 200});
        p.surface = {0.3, 0, 2e-3, 3e-3, 310};
        p.large_scale.z = {0, 200}, p.large_scale.w = {-0.1, -0.2};
        for (const bool given : {false, true}) {
            p.coriolis = 1e-3;
            if (given) p.large_scale.u_g = {9, 3}, p.large_scale.v_g = {-1, 2};
            p.frame = {0, 0};
            const auto fixed = rates(p, linear(200), q);
            p.frame = {6, -2.5};
            EXPECT_LT(largest_difference(fixed, rates(p, linear(200), q)), 1e-12) << int(q);
            EXPECT_GT(largest(fixed), 1e-7);
        }
    }
}

TEST(LargeScale, TablesNameTheirColumnsAndUnits)
{
    const LargeScale f = read_large_scale("t", "# comment\nz[km], w_ls[cm/s], dq_t[g/kg/day], dtheta_l[K/h]\n"
                                               "0,0,-,3.6\n0.5,-,8.64,-  # gap\n\n2 -1 - 7.2\n");
    EXPECT_EQ(f.z, (std::vector<double>{0, 500, 2000}));
    EXPECT_NEAR(f.w[1], -0.0025, 1e-15);
    EXPECT_NEAR(f.w[2], -0.01, 1e-15);
    for (const double rate : f.water) EXPECT_NEAR(rate, 1e-7, 1e-20);  // one value holds at all heights
    EXPECT_NEAR(f.theta[0], 1e-3, 1e-15);
    EXPECT_NEAR(f.theta[1], 1.25e-3, 1e-15);
    EXPECT_TRUE(f.u_g.empty());
}

TEST(LargeScale, DamagedTablesAreRefusedWithTheirLine)
{
    const std::pair<const char*, const char*> cases[] = {
        {"", "expected a table"},
        {"z[m]\n0\n", "one more column"},
        {"w_ls[m/s] z[m]\n0 0\n", "z as the first column"},
        {"z[m] w_ls[knots]\n0 0\n", "line 1: 'w_ls[knots]'"},
        {"z[m] w_ls[m/s] w_ls[m/s]\n0 0 0\n", "each column once"},
        {"z[m] w_ls[m/s]\n0 1 2\n", "line 2: 3 values: expected 2"},
        {"z[m] w_ls[m/s]\n0 1\n0 2\n", "line 3: expected heights that increase"},
        {"z[m] w_ls[m/s]\n0 nan\n", "line 2: 'nan'"},
        {"z[m] w_ls[m/s]\n- 1\n", "line 2: '-'"},
        {"z[m] w_ls[m/s]\n0 -\n", "a column of gaps"}};
    for (const auto& [text, message] : cases) {
        try {
            read_large_scale("t.txt", text);
            ADD_FAILURE() << text;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
            EXPECT_EQ(std::string(error.what()).rfind("t.txt: ", 0), 0u);
        }
    }
    EXPECT_THROW(large_scale_named("gate"), InputError);
}

TEST(LargeScale, ValuesOutOfRangeAreRefused)
{
    Parameters p = carrying({3, 4, 10}, {300, 400, 1000});
    const auto refused = [&](const char* message) {
        try {
            check(p, Sounding::uniform(300));
            ADD_FAILURE() << message;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
        }
        p.large_scale = {};
    };
    p.large_scale.z = {0, 0}, refused("height");
    p.large_scale.z = {0, 1}, p.large_scale.w = {1}, refused("w_ls at every height");
    p.large_scale.z = {0}, p.large_scale.w = {11}, refused("w_ls = 11");
    p.large_scale.z = {0}, p.large_scale.theta = {-2}, refused("dtheta_l = -2");
    p.large_scale.z = {0}, p.large_scale.u_g = {1}, refused("both u_g and v_g");
    p.surface.friction_velocity = 0.3, p.surface.drag = 1e-3, refused("one of the two");
}

TEST(Presets, HaveThePublishedForcingOfBomexAndRico)
{
    const auto at = [](const LargeScale& f, const std::vector<double>& column, double z) {
        return interpolate(f.z, column, z);
    };
    const Preset bomex = preset("bomex"), rico = preset("rico");
    const LargeScale &b = bomex.parameters.large_scale, &r = rico.parameters.large_scale;
    EXPECT_NEAR(at(b, b.w, 750), -0.00325, 1e-12);
    EXPECT_NEAR(at(b, b.w, 1800), -0.00325, 1e-12);
    EXPECT_EQ(at(b, b.w, 2500), 0);
    EXPECT_NEAR(at(b, b.theta, 1000), -2 / 86400., 1e-12);
    EXPECT_NEAR(at(b, b.theta, 2250), -1 / 86400., 1e-12);
    EXPECT_NEAR(at(b, b.water, 100), -1.2e-8, 1e-20);
    EXPECT_NEAR(at(b, b.water, 400), -0.6e-8, 1e-20);
    EXPECT_NEAR(at(b, b.u_g, 2000), -10 + 1.8e-3 * 2000, 1e-12);
    EXPECT_NEAR(at(r, r.w, 1130), -0.0025, 1e-12);
    EXPECT_NEAR(at(r, r.theta, 3333), -2.5 / 86400, 1e-12);
    EXPECT_NEAR(at(r, r.water, 1490), (-1 + 0.5 * 1.3456) / 86400e3, 1e-15);
    EXPECT_NEAR(at(r, r.u_g, 2000), -9.9 + 4, 1e-9);
    const auto air = [&](const Preset& s, double z) {
        return std::array{interpolate(s.sounding.z, s.sounding.theta, z),
                          interpolate(s.sounding.z, s.sounding.water, z), interpolate(s.sounding.z, s.sounding.u, z)};
    };
    EXPECT_NEAR(air(bomex, 1000)[0], 298.7 + 480 * 3.7 / 960, 1e-9);
    EXPECT_NEAR(air(bomex, 1000)[1], 1e-3 * (16.3 - 480 * 5.6 / 960), 1e-12);
    EXPECT_NEAR(air(bomex, 1850)[2], -8.75 + 1150 * 4.14 / 2300, 1e-9);
    EXPECT_NEAR(air(rico, 3630)[0], 297.9 + 2890 * 19.1 / 3260, 1e-6);
    EXPECT_NEAR(air(rico, 2000)[1], 1e-3 * (13.8 - 1260 * 11.4 / 2520), 1e-12);
    for (const Preset* s : {&bomex, &rico}) EXPECT_NO_THROW(check(s->parameters, s->sounding));
}

}  // namespace
}  // namespace vdbcloud::sim
