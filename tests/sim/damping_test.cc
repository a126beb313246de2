// What damps, mixes or relaxes the air and what it carries, against closed forms: rates, profiles and targets.
#include "air.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Every column of a field as one value a level; fails if a level is not uniform to rounding.
std::vector<double> levels_of(const Simulation& sim, Quantity q)
{
    const Lattice& l = sim.parameters().lattice;
    const size_t plane = size_t(l.n[0]) * size_t(l.n[1]);
    const auto values = all(sim, q);
    std::vector<double> column;
    for (size_t k = 0; k < size_t(l.n[2]); ++k) {
        column.push_back(values[k * plane]);
        for (size_t c = 0; c < plane; ++c) EXPECT_NEAR(values[k * plane + c], column.back(), 1e-12);
    }
    return column;
}

const Sounding breeze{"breeze", {0}, {300}, {0}, {5}, {-2}, 0};

std::vector<double> uniform_wind(const Lattice& l, double speed) { return std::vector<double>(l.cells(), speed); }

// A return to the environment is an exact factor: what is left is the rounding of some hundred stages.
constexpr double rounding = 1e-12;

// Third-order stages of dt leave exp(-rate t) of mixing with a relative error of t rate (rate dt)^3 / 24.
double rk3_error(double rate, double dt, double t) { return t * rate * std::pow(rate * dt, 3) / 24 + 1e-12; }

TEST(Sponge, HorizontalWindDecaysToTheEnvironmentsWithSineSquaredRates)
{
    const double rate = 0.05, depth = 0.4, t = 40;
    Parameters p = bare({4, 5, 20}, {400, 500, 2000});
    p.sponge = rate, p.sponge_depth = depth, p.dt = 0.5;
    auto sim = Simulation::make(p, breeze);
    sim->set(Quantity::U, uniform_wind(p.lattice, 8));
    sim->set(Quantity::V, uniform_wind(p.lattice, 1));
    sim->start();
    sim->advance_to(t);
    const auto u = levels_of(*sim, Quantity::U), v = levels_of(*sim, Quantity::V);
    for (size_t k = 0; k < 20; ++k) {
        const double z = (double(k) + 0.5) * 100, start = 2000 * (1 - depth);
        const double r = z <= start ? 0 : rate * std::pow(std::sin(M_PI / 2 * (z - start) / (2000 - start)), 2);
        EXPECT_NEAR((u[k] - 5) / 3, std::exp(-r * t), rounding) << k;
        EXPECT_NEAR((v[k] + 2) / 3, std::exp(-r * t), rounding) << k;
    }
    EXPECT_LT((u[19] - 5) / 3, 0.2);
}

/// Kinetic energy that a flow of small amplitude loses in one short step [m^2/s^2 per s], means over cells.
double energy_loss(Parameters p, const std::vector<double>& u, const std::vector<double>& w)
{
    p.time_scheme = TimeScheme::Euler;
    p.dt = 1e-3;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::U, u);
    sim->set(Quantity::W, w);
    sim->start();
    const double before = sim->budget().kinetic;
    sim->advance_to(p.dt);
    return (before - sim->budget().kinetic) / p.dt;
}

TEST(Sponge, VerticalWindDecaysWithTheRatesOfItsFaces)
{
    // Narrow cells of air: w is 20 times u, so energy goes as sum of rate w^2. The pressure does no work.
    const double rate = 0.05, k = 2 * M_PI / 200, m = M_PI / 2000, a = 1e-6;
    Parameters p = bare({16, 1, 20}, {200, 200, 2000});
    const auto w = values_at(p.lattice, Quantity::W,
                             [&](double x, double, double z) { return a * std::cos(k * x) * std::sin(m * z); });
    const auto u = values_at(p.lattice, Quantity::U, [&](double x, double, double z) {
        return -a * m / k * std::sin(k * x) * std::cos(m * z);
    });
    p.sponge = rate, p.sponge_depth = 1;
    Parameters off = p;
    off.sponge = 0;
    double expected = 0;
    const auto r = [&](double z) { return rate * std::pow(std::sin(M_PI / 2 * z / 2000), 2); };
    for (size_t c = 0; c < w.size(); ++c) {
        const double z = double(c / 16) * 100;
        expected += (r(z) * w[c] * w[c] + r(z + 50) * u[c] * u[c]) / double(w.size());
    }
    ASSERT_NEAR(energy_loss(off, u, w) / expected, 0, 1e-3);
    // The start is projected: to second order in the spacing, (k h)^2 / 24 = 0.6 %, the flow that was given.
    EXPECT_NEAR(energy_loss(p, u, w) / expected, 1, 0.01);
}

TEST(WindRelaxation, MeanWindApproachesTheEnvironmentsExponentiallyAndEddiesStay)
{
    const double tau = 50, t = 100;
    Parameters p = bare({6, 16, 4}, {600, 1600, 400});
    p.wind_relaxation = tau, p.dt = 1;
    auto sim = Simulation::make(p, {"jet", {0}, {300}, {0}, {5}, {0}, 0});
    const auto eddy = [](double, double y, double) { return std::sin(2 * M_PI * y / 1600); };
    auto u = values_at(p.lattice, Quantity::U, eddy);
    for (double& value : u) value += 2;
    sim->set(Quantity::U, u);
    sim->start();
    sim->advance_to(t);
    // A jet along x that changes along y alone carries nothing of itself: eddies keep their shape to rounding.
    auto exact = values_at(p.lattice, Quantity::U, eddy);
    for (double& value : exact) value += 5 - 3 * std::exp(-t / tau);
    EXPECT_LT(largest_difference(all(*sim, Quantity::U), exact), 3 * rounding);
    // The other component.
    auto cross = Simulation::make(p, {"cross", {0}, {300}, {0}, {0}, {-4}, 0});
    cross->set(Quantity::V, uniform_wind(p.lattice, 1));
    cross->start();
    cross->advance_to(t);
    for (const double v : levels_of(*cross, Quantity::V)) EXPECT_NEAR(v, -4 + 5 * std::exp(-t / tau), 5 * rounding);
}

TEST(WindRelaxation, AHugeStepTakesTheExactFactor)
{
    Parameters p = bare({6, 6, 4}, {600, 600, 400});
    p.wind_relaxation = 5, p.time_scheme = TimeScheme::HugeStep, p.dt = 60;
    auto sim = Simulation::make(p, breeze);
    sim->set(Quantity::U, uniform_wind(p.lattice, -3));
    sim->start();
    sim->advance_to(60);
    for (const double u : levels_of(*sim, Quantity::U)) EXPECT_NEAR(u, 5 - 8 * std::exp(-60 / 5.0), rounding);
}

/// Share of `depth` cells of an open side that a centre or face at `position` cells from the lower end relaxes with.
double side_weight(double position, int n, double depth)
{
    const double inside = std::min(position, n - position);
    return inside >= depth ? 0 : std::pow(std::cos(M_PI / 2 * inside / depth), 2);
}

TEST(SideRelaxation, ScalarsReturnToTheEnvironmentWithCosineSquaredRates)
{
    const double tau = 20, depth = 4, t = 30;
    Parameters p = bare({12, 3, 4}, {1200, 300, 400}, Side::Open);
    p.momentum = false, p.moisture = p.dye = true;
    p.moist.by = SaturationBy::Height;
    p.side_relaxation = tau, p.side_cells = depth, p.dt = 0.5;
    const Sounding s{"humid", {0, 400}, {300, 304}, {0.012, 0.008}, {0, 0}, {0, 0}, 0};
    auto sim = Simulation::make(p, s);
    const auto shifted = [&](Quantity q, double by) {
        auto values = all(*sim, q);
        for (double& v : values) v += by;
        return values;
    };
    const auto theta = all(*sim, Quantity::Theta), water = all(*sim, Quantity::Water);
    sim->set(Quantity::Theta, shifted(Quantity::Theta, 2));
    sim->set(Quantity::Water, shifted(Quantity::Water, 1e-3));
    sim->set(Quantity::Dye, shifted(Quantity::Dye, 3));
    sim->start();
    sim->advance_to(t);
    const auto warm = all(*sim, Quantity::Theta), wet = all(*sim, Quantity::Water), dye = all(*sim, Quantity::Dye);
    for (size_t c = 0; c < dye.size(); ++c) {
        const double left = std::exp(-side_weight(double(c % 12) + 0.5, 12, depth) * t / tau);
        EXPECT_NEAR((warm[c] - theta[c]) / 2, left, rounding) << c;
        EXPECT_NEAR((wet[c] - water[c]) / 1e-3, left, rounding) << c;
        EXPECT_NEAR(dye[c] / 3, left, rounding) << c;
    }
    EXPECT_LT(dye[0], 1);
    EXPECT_NEAR(dye[5], 3, 1e-12);
}

TEST(SideRelaxation, WindAlongAnOpenSideReturnsToTheEnvironments)
{
    const double tau = 20, depth = 4, t = 30;
    for (const bool open_x : {true, false}) {
        Parameters p = bare({open_x ? 12 : 3, open_x ? 3 : 12, 4}, {1200, 1200, 400},
                            open_x ? Side::Open : Side::Periodic, open_x ? Side::Periodic : Side::Open);
        p.side_relaxation = tau, p.side_cells = depth, p.dt = 0.5;
        auto sim = Simulation::make(p, {"along", {0}, {300}, {0}, {open_x ? 0. : -1}, {open_x ? -1. : 0}, 0});
        const Quantity along = open_x ? Quantity::V : Quantity::U;
        sim->set(along, uniform_wind(p.lattice, 4));
        sim->start();
        sim->advance_to(t);
        const auto wind = all(*sim, along);
        for (int i = 0; i < 12; ++i) {
            const double left = std::exp(-side_weight(i + 0.5, 12, depth) * t / tau);
            EXPECT_NEAR((wind[size_t(open_x ? i : 3 * i)] + 1) / 5, left, rounding) << i;
        }
    }
}

TEST(SideRelaxation, WindThroughAndUpAnOpenSideLosesEnergyAtItsRate)
{
    const double rate = 1 / 20.0, a = 1e-6, depth = 6;
    Parameters p = bare({24, 1, 24}, {2400, 2400, 2400}, Side::Open);
    const double k = 2 * M_PI / 2400, m = M_PI / 2400;
    const auto w = values_at(p.lattice, Quantity::W,
                             [&](double x, double, double z) { return a * std::cos(k * x) * std::sin(m * z); });
    const auto u = values_at(p.lattice, Quantity::U, [&](double x, double, double z) {
        return -a * m / k * std::sin(k * x) * std::cos(m * z);
    });
    p.side_relaxation = 1 / rate, p.side_cells = depth;
    double expected = 0;
    for (size_t c = 0; c < w.size(); ++c) {
        const double i = double(c % 24);
        expected += rate * (side_weight(i, 24, depth) * u[c] * u[c] + side_weight(i + 0.5, 24, depth) * w[c] * w[c]) /
                    double(w.size());
    }
    // Second order in the spacing: the projected start differs from the given one by (k h)^2 / 24 = 0.3 %; open sides
    // set the pressure to 0, which the given flow does not need.
    EXPECT_NEAR(energy_loss(p, u, w) / expected, 1, 0.02);
}

TEST(OpenSides, AirThatFlowsInIsTheEnvironments)
{
    // Dye 1 in a wind of 10 m/s for 20 s: 200 m of the box are new air, by the flux through the open sides.
    for (const double wind : {10.0, -10.0}) {
        Parameters p = bare({32, 1, 2}, {1600, 1600, 100}, Side::Open);
        p.momentum = false, p.dye = true, p.side_cells = 0;
        p.scalar_scheme = ScalarScheme::Limited5;
        auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {wind}, {0}, 0});
        sim->set(Quantity::Dye, std::vector<double>(64, 1.0));
        sim->start();
        sim->advance_to(20);
        const auto dye = all(*sim, Quantity::Dye);
        double mean = 0;
        for (const double d : dye) mean += d / 64;
        EXPECT_NEAR(mean, 1 - 200.0 / 1600, 1e-12);
        EXPECT_LT(dye[wind > 0 ? 0 : 31], 0.01);
        EXPECT_NEAR(dye[wind > 0 ? 31 : 0], 1, 1e-12);
    }
}

/// cos(kx x) cos(ky y) cos(kz z), an eigenvector of the discrete Laplacian on cells between rigid lids.
struct Mode {
    double kx = 2 * M_PI / 800, ky = 2 * M_PI / 1200, kz = M_PI / 600;
    double operator()(double x, double y, double z) const
    {
        return std::cos(kx * x) * std::cos(ky * y) * std::cos(kz * z);
    }
    /// -eigenvalue, sum of (2 sin(k h / 2) / h)^2 [1/m^2]
    double lambda(const std::array<double, 3>& h) const
    {
        const auto one = [](double k, double spacing) { return std::pow(2 * std::sin(k * spacing / 2) / spacing, 2); };
        return one(kx, h[0]) + one(ky, h[1]) + one(kz, h[2]);
    }
};

TEST(Diffusion, ModesOfHeatWaterAndDyeDecayWithTheDiscreteEigenvalue)
{
    const double kappa = 30, t = 60;
    const Mode mode;
    Parameters p = bare({8, 10, 6}, {800, 1200, 600});
    p.momentum = false, p.moisture = p.dye = true;
    p.moist.by = SaturationBy::Height;
    p.diffusivity = kappa, p.dt = 2;
    auto sim = Simulation::make(p, {"air", {0}, {300}, {0.01}, {0}, {0}, 0});
    const auto field = [&](double mean, double amplitude) {
        return values_at(p.lattice, Quantity::Dye,
                         [&](double x, double y, double z) { return mean + amplitude * mode(x, y, z); });
    };
    sim->set(Quantity::Theta, field(300, 2));
    sim->set(Quantity::Water, field(0.01, 1e-3));
    sim->set(Quantity::Dye, field(3, 1));
    sim->start();
    sim->advance_to(t);
    const double rate = kappa * mode.lambda(p.lattice.h), left = std::exp(-rate * t);
    ASSERT_LT(left, 0.9);
    const double tolerance = rk3_error(rate, p.dt, t);
    EXPECT_LT(largest_difference(all(*sim, Quantity::Theta), field(300, 2 * left)), 2 * tolerance);
    EXPECT_LT(largest_difference(all(*sim, Quantity::Water), field(0.01, 1e-3 * left)), 1e-3 * tolerance);
    EXPECT_LT(largest_difference(all(*sim, Quantity::Dye), field(3, left)), tolerance);
}

TEST(Viscosity, ParallelFlowsDecayWithTheDiscreteEigenvalue)
{
    // u(y, z), and v(x, z): no part of the wind carries any other, so that viscosity acts alone.
    const double nu = 40, t = 60;
    Mode mode;
    for (const Quantity along : {Quantity::U, Quantity::V}) {
        Parameters p = bare({8, 10, 6}, {800, 1200, 600});
        (along == Quantity::U ? mode.kx : mode.ky) = 0;
        p.viscosity = nu, p.dt = 2;
        auto sim = Simulation::make(p, Sounding::uniform(300));
        const auto flow = [&](double amplitude) {
            return values_at(p.lattice, along, [&](double x, double y, double z) { return amplitude * mode(x, y, z); });
        };
        sim->set(along, flow(1));
        sim->start();
        sim->advance_to(t);
        const double rate = nu * mode.lambda(p.lattice.h), left = std::exp(-rate * t);
        ASSERT_LT(left, 0.9);
        EXPECT_LT(largest_difference(all(*sim, along), flow(left)), rk3_error(rate, p.dt, t));
        mode = {};
    }
}

}  // namespace
}  // namespace vdbcloud::sim
