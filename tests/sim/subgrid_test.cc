// Sub-grid mixing after Smagorinsky and Lilly against closed forms: nu = (c_s delta)^2 |S| sqrt(1 - Ri / Pr), Pr = 1/3.
#include "air.h"

#include "vdbcloud/core/random.h"

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

/// One Euler step of a periodic box of random wind and dye with sub-grid mixing, less the step without: for each
/// quantity what mixing alone changes.
std::vector<double> mixed(const Parameters& p, Quantity q)
{
    std::vector<double> after[2];
    for (const bool on : {false, true}) {
        Parameters run = p;
        run.subgrid = on;
        auto sim = Simulation::make(run, Sounding::uniform(300));
        uint64_t draw = 0;
        for (const Quantity set : {Quantity::U, Quantity::V, Quantity::W, Quantity::Dye})
            sim->set(set, values_at(p.lattice, set, [&](double, double, double z) {
                         const double random = uniform(hash_bits(29, draw++));
                         return set == Quantity::W && z == 0 ? 0 : set == Quantity::Dye ? 1 + random : random - 0.5;
                     }));
        sim->start();
        sim->advance_to(p.dt);
        after[on] = all(*sim, q);
    }
    for (size_t c = 0; c < after[0].size(); ++c) after[1][c] -= after[0][c];
    return after[1];
}

TEST(Subgrid, RowsOfRandomWindMixDyeAsCellsOneByOne)
{
    // The formula cell by cell, where floor and lid are far: |S|^2 of normal strains and of the mean of squares on
    // edges.
    Parameters p = tracer_box({7, 6, 9}, {140, 90, 270});
    p.dt = 1e-2;
    const auto& n = p.lattice.n;
    const auto& h = p.lattice.h;
    uint64_t draw = 0;
    std::vector<double> f[4];
    for (const Quantity q : {Quantity::U, Quantity::V, Quantity::W, Quantity::Dye})
        f[q == Quantity::Dye ? 3 : int(q)] = values_at(p.lattice, q, [&](double, double, double z) {
            const double random = uniform(hash_bits(29, draw++));
            return q == Quantity::W && z == 0 ? 0 : q == Quantity::Dye ? 1 + random : random - 0.5;
        });
    using Cell = std::array<int, 3>;
    const auto at = [&](int q, Cell c) {
        const int i = (c[0] + n[0]) % n[0], j = (c[1] + n[1]) % n[1];
        return f[q][size_t((c[2] * n[1] + j) * n[0] + i)];
    };
    const auto moved = [](Cell c, int axis, int by) {
        c[size_t(axis)] += by;
        return c;
    };
    const auto slope = [&](int q, Cell c, int axis) {  // below the value of cell c
        return (at(q, c) - at(q, moved(c, axis, -1))) / h[size_t(axis)];
    };
    const double mixing = std::pow(coefficient * std::cbrt(h[0] * h[1] * h[2]), 2);
    const auto viscosity = [&](Cell c) {
        double squared = 0;
        for (int a = 0; a < 3; ++a) {
            squared += 2 * std::pow(slope(a, moved(c, a, 1), a), 2);
            for (int b = a + 1; b < 3; ++b)
                for (const int da : {0, 1})
                    for (const int db : {0, 1}) {
                        const Cell edge = moved(moved(c, a, da), b, db);
                        squared += 0.25 * std::pow(slope(a, edge, b) + slope(b, edge, a), 2);
                    }
        }
        return mixing * std::sqrt(squared);
    };
    const auto change = mixed(p, Quantity::Dye);
    for (int k = 3; k < n[2] - 3; ++k)
        for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
                const Cell c{i, j, k};
                double rate = 0;
                for (int a = 0; a < 3; ++a)
                    for (const int side : {0, 1}) {
                        const Cell face = moved(c, a, side);
                        const double nu = 0.5 * (viscosity(face) + viscosity(moved(face, a, -1)));
                        rate += (side ? 3 : -3) * nu * slope(3, face, a) / h[size_t(a)];
                    }
                // Rounding of dye of 2 in a step, 4e-16, over what it changes by.
                ASSERT_NEAR(change[size_t((k * n[1] + j) * n[0] + i)], p.dt * rate, 2e-14) << i << ' ' << j << ' ' << k;
                ASSERT_GT(largest(change), 1e-6);
            }
}

}  // namespace
}  // namespace vdbcloud::sim
