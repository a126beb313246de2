// Forces and the base state against closed forms: every term of buoyancy, the anelastic density, huge steps.
#include "air.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

TEST(Buoyancy, IsTheSumOfItsTermsAndEachCanBeOff)
{
    // g [theta'/theta0 + 0.608 q_v' - q_l'], saturation by height: q_l = q_t - q_s, theta = theta_l + (L/cp) q_l.
    for (const bool latent : {true, false})
        for (const bool vapour : {true, false})
            for (const bool loading : {true, false}) {
                const Thermodynamics air({}, {SaturationBy::Height, latent, vapour, loading}, true);
                Level level;
                level.q_height = 0.010, level.heat = 2.5e6 / 1004, level.theta_env = 1, level.q_env = 0.008;
                for (const double q_t : {0.009, 0.013}) {
                    const double q_l = std::max(0.0, q_t - 0.010), q_v = q_t - q_l;
                    const double theta = 0.4 + (latent ? 2.5e6 / 1004 * q_l : 0);
                    const double b = 9.81 * ((theta - 0.6) / 300 + vapour * 0.608 * (q_v - 0.008) - loading * q_l);
                    // theta_l 1.4 - 0.6 + ...: deviation 0.4 - 0.6 from the environment's 1 K above the reference.
                    EXPECT_NEAR(air.buoyancy(level, 0.8, q_t), b, 1e-14);
                }
            }
}

/// Vertical wind [m/s] that one step of dt makes out of an excess of a quantity, amplitude cos(k x) sin(m z).
struct Push {
    Quantity quantity;
    double mean, amplitude;
    double acceleration;  ///< at amplitude [m/s^2]
    const char* name;
};

void expect_push(const Push& push, TimeScheme scheme, double n2)
{
    SCOPED_TRACE(push.name);
    const double k = 2 * M_PI / 1600, m = M_PI / 1000, h = 100, dt = 3;
    Parameters p = bare({16, 1, 10}, {1600, 1600, 1000});
    p.buoyancy = p.moisture = p.rain = true;
    p.moist = {SaturationBy::Height, true, true, true};
    p.q_scale_height = 1e9;  // q_s is 0.02 everywhere
    p.time_scheme = scheme, p.dt = dt;
    const double slope = n2 * 300 / 9.81;
    const double water = push.quantity == Quantity::Water ? push.mean : 0.02;
    auto sim = Simulation::make(p, {"air", {0, 1000}, {300, 300 + slope * 1000}, {water, water}, {0, 0}, {0, 0}, 0});
    auto values = all(*sim, push.quantity);
    const auto mode = values_at(p.lattice, push.quantity,
                                [&](double x, double, double z) { return std::cos(k * x) * std::sin(m * z); });
    for (size_t c = 0; c < values.size(); ++c) {
        if (push.quantity == Quantity::Rain) values[c] = push.mean;
        values[c] += push.amplitude * mode[c];
    }
    sim->set(push.quantity, values);
    sim->start();
    sim->advance_to(dt);
    // From centres to faces: cos(m h / 2). The pressure leaves lambda_x / (lambda_x + lambda_z) of it, eigenvalues of
    // the differences. Exact but for transport by the wind itself, of relative size w m dt.
    const auto lambda = [&](double wave) { return std::pow(2 * std::sin(wave * h / 2) / h, 2); };
    const double share = std::cos(m * h / 2) * lambda(k) / (lambda(k) + lambda(m));
    const double implicit = scheme == TimeScheme::HugeStep ? 1 / (1 + dt * dt * n2) : 1;
    const auto w = all(*sim, Quantity::W);
    const auto exact = values_at(p.lattice, Quantity::W, [&](double x, double, double z) {
        return dt * push.acceleration * share * implicit * std::cos(k * x) * std::sin(m * z);
    });
    EXPECT_LT(largest_difference(w, exact), 2e-3 * largest(exact));
}

TEST(Buoyancy, WarmMoistCloudyAndRainyAirAreMovedAsTheyWeigh)
{
    const double heat = 2.5e6 / 1004;
    const Push pushes[] = {
        {Quantity::Theta, 0, 1e-4, 9.81 * 1e-4 / 300, "warm"},
        {Quantity::Water, 0.01, 1e-6, 9.81 * 0.608 * 1e-6, "vapour"},
        {Quantity::Water, 0.03, 1e-6, 9.81 * (heat / 300 - 1) * 1e-6, "cloud"},
        {Quantity::Rain, 1e-4, 1e-6, -9.81 * 1e-6, "rain"},
    };
    for (const Push& push : pushes) expect_push(push, TimeScheme::Euler, 0);
}

TEST(HugeSteps, BuoyancyActsImplicitlyWhereAirIsStable)
{
    for (const double n2 : {0.0, 4e-4, 0.05})
        expect_push({Quantity::Theta, 0, 1e-4, 9.81 * 1e-4 / 300, "warm"}, TimeScheme::HugeStep, n2);
}

TEST(BaseState, IsTheIsentropicAtmosphere)
{
    // theta constant: exner = 1 - g z / (cp theta), p = 1e5 exner^(cp/R), rho ~ p / T ~ exner^(cp/R - 1).
    Parameters p = bare({4, 4, 25}, {400, 400, 10000});
    p.anelastic = true;
    const Column column = make_column(p, Sounding::uniform(310));
    const auto exner = [](double z) { return 1 - 9.81 * z / (1004 * 310); };
    const double power = 1004 / 287.05;
    for (size_t k = 0; k < 25; ++k) {
        const double z = 400 * (double(k) + 0.5);
        EXPECT_NEAR(column.level[k].exner, exner(z), 1e-12);
        EXPECT_NEAR(column.level[k].pressure / (1e5 * std::pow(exner(z), power)), 1, 1e-11);
        EXPECT_NEAR(column.rho_centre[k] / std::pow(exner(z), power - 1), 1, 1e-11);
        EXPECT_NEAR(column.rho_face[k + 1] / std::pow(exner(z + 200), power - 1), 1, 1e-11);
    }
    EXPECT_EQ(column.rho_face[0], 1);
    EXPECT_LT(column.rho_face[25], 0.4);
}

TEST(BaseState, FollowsVirtualTemperatureAndTheSoundingsPressure)
{
    // theta_v = (300 + 0.004 z)(1 + 0.608 q): exner = exner_0 - g / (cp 0.004 (1 + 0.608 q)) ln(1 + 0.004 z / 300). The
    // midpoint rule in layers of h = 10 m errs by h^2/24 (f'(0) - f'(z)), f = g / (cp theta_v): 3.4e-10 at 8 km; of
    // density 2.5 / exner times that, of L / (cp exner) 4300 / exner times.
    const double q = 0.015, exner0 = std::pow(0.95, 287.05 / 1004);
    Parameters p = bare({4, 4, 20}, {400, 400, 8000});
    p.anelastic = p.moisture = true;
    const Column column = make_column(p, {"moist", {0, 8000}, {300, 332}, {q, q}, {0, 0}, {0, 0}, 95000});
    const auto exner = [&](double z) {
        return exner0 - 9.81 / (1004 * 0.004 * (1 + 0.608 * q)) * std::log(1 + 0.004 * z / 300);
    };
    for (size_t k = 0; k < 20; ++k) {
        const double z = 400 * (double(k) + 0.5), theta = 300 + 0.004 * z;
        EXPECT_NEAR(column.level[k].exner, exner(z), 4e-10);
        EXPECT_NEAR(column.rho_centre[k], std::pow(exner(z) / exner0, 1004 / 287.05 - 1) * 300 / theta, 2e-9);
        EXPECT_NEAR(column.level[k].heat, 2.5e6 / 1004 / exner(z), 3e-6);
    }
}

TEST(BaseState, AnelasticAirConservesItsMass)
{
    // d(rho u)/dx + d(rho w)/dz = 0 cell by cell, evaluated here with the isentropic density.
    Parameters p = bare({24, 1, 20}, {6000, 6000, 10000});
    p.buoyancy = p.anelastic = true;
    p.bubbles.push_back({{3000, 0, 2500}, 1500, 1500, 2, 0, 0});
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->advance_to(300);
    const auto u = all(*sim, Quantity::U), w = all(*sim, Quantity::W);
    const auto rho = [](double z) { return std::pow(1 - 9.81 * z / (1004 * 300), 1004 / 287.05 - 1); };
    double worst = 0, compression = 0;
    for (size_t k = 0; k < 20; ++k)
        for (size_t i = 0; i < 24; ++i) {
            const size_t c = 24 * k + i;
            const double du = (u[24 * k + (i + 1) % 24] - u[c]) / 250, above = k < 19 ? w[c + 24] : 0;
            const double z = 500 * double(k);
            worst = std::max(worst, std::abs(rho(z + 250) * du + (rho(z + 500) * above - rho(z) * w[c]) / 500));
            compression = std::max(compression, std::abs(du + (above - w[c]) / 500));
        }
    EXPECT_LT(worst, 1e-12);
    EXPECT_GT(compression, 1e-4);
}

}  // namespace
}  // namespace vdbcloud::sim
