// Sub-grid mixing after Smagorinsky and Lilly against closed forms: nu = (c_s delta)^2 |S| sqrt(1 - Ri / Pr), Pr = 1/3.
#include "air.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

constexpr double coefficient = 0.2;

/// A given wind, and dye that changes along y alone: it decays at 3 nu (1/Pr = 3) times the eigenvalue of y, in each
/// cell by itself, and so shows the eddy viscosity of every cell.
Parameters tracer_box(std::array<int, 3> n, std::array<double, 3> size)
{
    Parameters p = bare(n, size);
    p.momentum = false, p.subgrid = p.dye = true;
    p.smagorinsky = coefficient;
    p.time_scheme = TimeScheme::Euler;
    p.dt = 1e-3;
    return p;
}

double dye_at(double y, double length) { return 2 + std::cos(2 * M_PI * y / length); }

/// Eddy viscosity of each cell [m^2/s], from one short step.
std::vector<double> eddy_viscosity(Simulation& sim)
{
    const Parameters& p = sim.parameters();
    const double length = p.lattice.n[1] * p.lattice.h[1];
    const auto before =
        values_at(p.lattice, Quantity::Dye, [&](double, double y, double) { return dye_at(y, length); });
    sim.set(Quantity::Dye, before);
    sim.start();
    sim.advance_to(p.dt);
    auto nu = all(sim, Quantity::Dye);
    const double lambda = std::pow(2 * std::sin(M_PI / p.lattice.n[1]) / p.lattice.h[1], 2);
    for (size_t c = 0; c < nu.size(); ++c) nu[c] = (before[c] - nu[c]) / (3 * lambda * p.dt * (before[c] - 2));
    return nu;
}

/// Interior eddy viscosity of a wind with shear S = 0.02/s along z under the stratification n2 [1/s^2].
double sheared_viscosity(double n2)
{
    const double shear = 0.02, slope = n2 * 300 / 9.81;
    Parameters p = tracer_box({4, 5, 9}, {200, 300, 720});
    p.buoyancy = true;
    auto sim = Simulation::make(p, {"shear", {0, 720}, {300, 300 + slope * 720}, {0, 0}, {0, shear * 720}, {0, 0}, 0});
    const auto nu = eddy_viscosity(*sim);
    const size_t plane = 20;
    for (size_t c = 2 * plane; c < 7 * plane; ++c) EXPECT_NEAR(nu[c], nu[4 * plane], 1e-6 * std::abs(nu[4 * plane]));
    return nu[4 * plane];
}

TEST(Subgrid, EddyViscosityFollowsShearAndTheRichardsonNumber)
{
    // |S| = du/dz; delta^3 = 50 x 60 x 80 m^3. Exact in the discretisation: linear
    // profiles. Tolerance: rounding of dye over one step of 1e-3 s, 1e-16 / 1e-8.
    const double s2 = 0.02 * 0.02, mixing = std::pow(coefficient * std::cbrt(50.0 * 60 * 80), 2);
    for (const double richardson : {0.0, 0.1, 0.3, -0.5, -3.0})
        EXPECT_NEAR(sheared_viscosity(richardson * s2) / (mixing * std::sqrt(s2 * (1 - 3 * richardson))), 1, 1e-6)
            << richardson;
    // None from the critical Richardson number, Pr = 1/3, on.
    EXPECT_GT(sheared_viscosity(0.33 * s2), 0.05 * mixing * std::sqrt(s2));
    EXPECT_EQ(sheared_viscosity(0.34 * s2), 0);
    EXPECT_EQ(sheared_viscosity(2 * s2), 0);
}

TEST(Subgrid, EddyViscosityOfStrainingCells)
{
    // u = sin(pi x) cos(pi z), w = -cos(pi x) sin(pi z): no shear, |S|^2 = 2 (u_x^2 + w_z^2) = (2 pi cos cos)^2, the
    // difference quotient of sines exactly sin(pi h / 2) / (h / 2).
    Parameters p = tracer_box({16, 4, 16}, {1, 1, 1});
    p.lattice.side[0] = Side::Wall;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [](double x, double, double z) {
                 return std::sin(M_PI * x) * std::cos(M_PI * z);
             }));
    sim->set(Quantity::W, values_at(p.lattice, Quantity::W, [](double x, double, double z) {
                 return -std::cos(M_PI * x) * std::sin(M_PI * z);
             }));
    const auto nu = eddy_viscosity(*sim);
    const double h = 1 / 16.0, mixing = std::pow(coefficient * std::cbrt(h * h * 0.25), 2);
    const auto exact = values_at(p.lattice, Quantity::Dye, [&](double x, double, double z) {
        return mixing * std::sqrt(2.0) * std::sqrt(2.0) * std::sin(M_PI * h / 2) / (h / 2) *
               std::abs(std::cos(M_PI * x) * std::cos(M_PI * z));
    });
    EXPECT_LT(largest_difference(nu, exact), 1e-6 * largest(exact));
}

TEST(Subgrid, StressOfAParallelFlowIsThatOfItsLocalShear)
{
    // u = sin(k y): stress nu S = (c_s delta)^2 |S| S, so du/dt = -2 (c_s delta)^2 k^3 |cos(k y)| sin(k y). Second
    // order: (k h)^2 = 1e-2 at 64 cells a wave.
    for (const Quantity along : {Quantity::U, Quantity::V}) {
        const bool u = along == Quantity::U;
        Parameters p = bare({u ? 2 : 64, u ? 64 : 2, 2}, {u ? 40. : 1280, u ? 1280. : 40, 40});
        p.subgrid = true, p.smagorinsky = coefficient;
        p.time_scheme = TimeScheme::Euler, p.dt = 0.1;
        auto sim = Simulation::make(p, Sounding::uniform(300));
        const double k = 2 * M_PI / 1280, mixing = std::pow(coefficient * 20, 2);
        const auto before =
            values_at(p.lattice, along, [&](double x, double y, double) { return std::sin(k * (u ? y : x)); });
        sim->set(along, before);
        sim->start();
        sim->advance_to(p.dt);
        auto rate = all(*sim, along);
        for (size_t c = 0; c < rate.size(); ++c) rate[c] = (rate[c] - before[c]) / p.dt;
        const double scale = 2 * mixing * k * k * k;
        const auto exact = values_at(p.lattice, along, [&](double x, double y, double) {
            const double phase = k * (u ? y : x);
            return -scale * std::abs(std::cos(phase)) * std::sin(phase);
        });
        EXPECT_LT(largest_difference(rate, exact), 0.02 * scale);
        EXPECT_GT(largest(exact), 0.49 * scale);
    }
}

TEST(Subgrid, EnergyGoesAtViscosityTimesSquaredStrain)
{
    // Straining cells with momentum: dE/dt = -mean(nu |S|^2) = -(c_s delta)^2 (2 pi)^3 mean(|cos cos|^3), mean |cos|^3
    // = 4 / (3 pi). What the advection loses is taken off by a run without mixing. Second order, (pi h)^2 = 1e-2.
    double loss[2];
    for (const bool on : {false, true}) {
        Parameters p = bare({32, 1, 32}, {1, 1, 1}, Side::Wall);
        p.subgrid = on, p.smagorinsky = coefficient;
        p.time_scheme = TimeScheme::Euler, p.dt = 1e-3;
        auto sim = Simulation::make(p, Sounding::uniform(300));
        sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [](double x, double, double z) {
                     return std::sin(M_PI * x) * std::cos(M_PI * z);
                 }));
        sim->set(Quantity::W, values_at(p.lattice, Quantity::W, [](double x, double, double z) {
                     return -std::cos(M_PI * x) * std::sin(M_PI * z);
                 }));
        sim->start();
        const double before = sim->budget().kinetic;
        sim->advance_to(p.dt);
        loss[on] = (before - sim->budget().kinetic) / p.dt;
    }
    const double mixing = std::pow(coefficient / 32, 2);
    const double exact = mixing * std::pow(2 * M_PI, 3) * std::pow(4 / (3 * M_PI), 2);
    EXPECT_NEAR((loss[1] - loss[0]) / exact, 1, 0.02);
}

}  // namespace
}  // namespace vdbcloud::sim
