// The dry flow against closed forms: orders of convergence, exact decay, exact waves.
#include "air.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Decaying cells in a box without friction at its walls: u = sin(pi x) cos(pi z), exact for Navier-Stokes.
double taylor_green_error(int n)
{
    const double nu = 0.02, t = 0.5;
    Parameters p = bare({n, 1, n}, {1, 1, 1}, Side::Wall);
    p.viscosity = nu;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    const auto u = [](double x, double, double z) { return std::sin(M_PI * x) * std::cos(M_PI * z); };
    const auto w = [](double x, double, double z) { return -std::cos(M_PI * x) * std::sin(M_PI * z); };
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, u));
    sim->set(Quantity::W, values_at(p.lattice, Quantity::W, w));
    sim->start();
    sim->advance_to(t);
    std::vector<double> exact = values_at(p.lattice, Quantity::W, w);
    for (double& v : exact) v *= std::exp(-2 * nu * M_PI * M_PI * t);
    return rms(all(*sim, Quantity::W), exact);
}

TEST(Flow, TaylorGreenCellsConvergeAtSecondOrder)
{
    const double coarse = taylor_green_error(16), middle = taylor_green_error(32), fine = taylor_green_error(64);
    EXPECT_LT(fine, 3e-4);
    EXPECT_GT(std::log2(coarse / middle), 1.8);
    EXPECT_GT(std::log2(middle / fine), 1.8);
}

/// One standing internal wave mode between rigid lids: omega = N k / sqrt(k^2 + m^2). Small, so that it is linear.
struct Wave {
    double k = 2 * M_PI * 2 / 3000, m = M_PI / 1500, n2 = 4e-4, amplitude = 1e-4;
    double omega() const { return std::sqrt(n2) * k / std::hypot(k, m); }
    Sounding sounding() const
    {
        const double slope = n2 * 300 / 9.81;
        return {"wave", {-1000, 4000}, {300 - 1000 * slope, 300 + 4000 * slope}, {0, 0}, {0, 0}, {0, 0}, 0};
    }
    double w(double x, double z) const { return amplitude * std::cos(k * x) * std::sin(m * z); }
};

std::unique_ptr<Simulation> wave_box(const Wave& wave, int n, ScalarScheme scheme)
{
    Parameters p = bare({2 * n, 1, n}, {3000, 3000, 1500});
    p.buoyancy = true;
    p.scalar_scheme = scheme;
    p.dt = 1;  // N dt = 0.02: the error is the grid's
    auto sim = Simulation::make(p, wave.sounding());
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [&](double x, double, double z) {
                 return -wave.amplitude * wave.m / wave.k * std::sin(wave.k * x) * std::cos(wave.m * z);
             }));
    sim->set(Quantity::W, values_at(p.lattice, Quantity::W, [&](double x, double, double z) { return wave.w(x, z); }));
    sim->start();
    return sim;
}

double wave_error(int n, ScalarScheme scheme)
{
    const Wave wave;
    auto sim = wave_box(wave, n, scheme);
    const double t = 0.7 * 2 * M_PI / wave.omega();
    sim->advance_to(t);
    const auto exact = values_at(sim->parameters().lattice, Quantity::W,
                                 [&](double x, double, double z) { return wave.w(x, z) * std::cos(wave.omega() * t); });
    return rms(all(*sim, Quantity::W), exact) / wave.amplitude;
}

TEST(Flow, StandingInternalWaveConvergesAtSecondOrder)
{
    for (const ScalarScheme scheme : {ScalarScheme::Plain5, ScalarScheme::Limited5}) {
        const double coarse = wave_error(16, scheme), middle = wave_error(32, scheme), fine = wave_error(64, scheme);
        EXPECT_LT(fine, 5e-3) << int(scheme);
        EXPECT_GT(std::log2(coarse / middle), 1.8) << int(scheme);
        EXPECT_GT(std::log2(middle / fine), 1.8) << int(scheme);
    }
}

TEST(Flow, InternalWaveFrequencyMatchesDispersionRelation)
{
    // Where the projection of w on the mode passes zero for the first time, at a quarter of the period.
    const Wave wave;
    auto sim = wave_box(wave, 32, ScalarScheme::Limited5);
    const auto mode =
        values_at(sim->parameters().lattice, Quantity::W, [&](double x, double, double z) { return wave.w(x, z); });
    const auto projected = [&] {
        const auto w = all(*sim, Quantity::W);
        double sum = 0;
        for (size_t i = 0; i < w.size(); ++i) sum += w[i] * mode[i];
        return sum;
    };
    double before = projected(), t = 0;
    for (;;) {
        sim->advance_to(t + 2);
        const double now = projected();
        if (now <= 0) {
            t += 2 * before / (before - now);
            break;
        }
        before = now, t += 2;
    }
    EXPECT_NEAR(M_PI / 2 / t / wave.omega(), 1.0, 5e-3);
}

/// A smooth convecting flow with friction, to a fixed time in `steps` equal steps.
std::vector<double> convect(TimeScheme scheme, int steps)
{
    Parameters p = bare({16, 1, 16}, {1600, 1600, 1600});
    p.buoyancy = true;
    p.friction_time = 300;
    p.viscosity = p.diffusivity = 5;
    p.time_scheme = scheme;
    const double end = 160;
    p.dt = end / steps;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta, [](double x, double, double z) {
                 return 300 + 0.5 * std::cos(2 * M_PI * x / 1600) * std::sin(M_PI * z / 1600) + 2e-3 * z;
             }));
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [](double x, double, double z) {
                 return 2 * std::sin(2 * M_PI * x / 1600 + 1) * std::cos(M_PI * z / 1600);
             }));
    sim->start();
    sim->advance_to(end);
    EXPECT_EQ(sim->budget().steps, uint64_t(steps)) << "the step was split: the test needs a smaller step";
    return all(*sim, Quantity::W);
}

TEST(Flow, TimeSchemesKeepTheirOrderWithFrictionAndPressure)
{
    const auto exact = convect(TimeScheme::Rk3, 512);
    const struct {
        TimeScheme scheme;
        double order;
    } cases[] = {{TimeScheme::Euler, 1}, {TimeScheme::Rk2, 2}, {TimeScheme::Rk3, 3}};
    for (const auto& c : cases) {
        const double coarse = rms(convect(c.scheme, 16), exact), fine = rms(convect(c.scheme, 32), exact);
        EXPECT_NEAR(std::log2(coarse / fine), c.order, 0.2) << "order " << c.order;
    }
}

TEST(Flow, FrictionAloneDecaysExactlyForAnyStep)
{
    for (const TimeScheme scheme : {TimeScheme::Euler, TimeScheme::Rk2, TimeScheme::Rk3, TimeScheme::HugeStep})
        for (const double dt : {1.0, 40.0, 1000.0}) {
            Parameters p = bare({8, 8, 8}, {800, 800, 800});
            p.friction_time = 35;
            p.time_scheme = scheme;
            p.dt = dt;
            auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {3}, {-2}, 0});
            sim->start();
            sim->advance_to(1000);
            const auto u = all(*sim, Quantity::U), v = all(*sim, Quantity::V);
            EXPECT_NEAR(u[77] / (3 * std::exp(-1000.0 / 35)), 1, 1e-11) << int(scheme) << ' ' << dt;
            EXPECT_NEAR(v[13] / (-2 * std::exp(-1000.0 / 35)), 1, 1e-11) << int(scheme) << ' ' << dt;
        }
}

TEST(Flow, TinyFrictionTimeStopsTheAir)
{
    Parameters p = bare({8, 8, 8}, {800, 800, 800});
    p.friction_time = 1e-9;
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {3}, {-2}, 0});
    sim->advance_to(10);
    EXPECT_EQ(largest(all(*sim, Quantity::U)), 0);
}

TEST(Flow, StratifiedAirAtRestStaysAtRest)
{
    const Wave wave;
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = bare({16, 12, 20}, {1600, 1200, 2000});
        p.buoyancy = true;
        p.precision = precision;
        p.scalar_scheme = ScalarScheme::Limited5;
        auto sim = Simulation::make(p, wave.sounding());
        sim->advance_to(3600);
        EXPECT_LE(sim->budget().speed_max, precision == Precision::Float ? 1e-5 : 1e-12);
    }
}

TEST(Flow, InviscidKineticEnergyDoesNotGrow)
{
    // Fifth-order upwind fluxes dissipate: without buoyancy kinetic energy does not grow.
    Parameters p = bare({24, 24, 24}, {1, 1, 1});
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [](double x, double y, double z) {
                 return std::sin(2 * M_PI * x) * std::cos(2 * M_PI * y) * std::cos(M_PI * z);
             }));
    sim->set(Quantity::V, values_at(p.lattice, Quantity::V, [](double x, double y, double z) {
                 return -std::cos(2 * M_PI * x) * std::sin(2 * M_PI * y) * std::cos(M_PI * z);
             }));
    sim->start();
    double before = sim->budget().kinetic;
    ASSERT_GT(before, 0.05);
    for (int i = 1; i <= 10; ++i) {
        sim->advance_to(0.2 * i);
        const double now = sim->budget().kinetic;
        EXPECT_LE(now, before * (1 + 1e-12));
        EXPECT_LT(sim->budget().divergence, 1e-12);
        before = now;
    }
}

/// Kinetic energy, and potential energy -g/theta0 theta z, means over the box [m^2/s^2].
double energy(const Simulation& sim, double& kinetic)
{
    const Lattice& l = sim.parameters().lattice;
    const auto theta = all(sim, Quantity::Theta);
    double potential = 0;
    for (size_t c = 0; c < theta.size(); ++c) {
        const double z = (double(c / (size_t(l.n[0]) * size_t(l.n[1]))) + 0.5) * l.h[2];
        potential -= 9.81 / 300 * (theta[c] - 300) * z / double(theta.size());
    }
    kinetic = sim.budget().kinetic;
    return kinetic + potential;
}

TEST(Flow, SumOfKineticAndPotentialEnergyDoesNotGrow)
{
    // A thermal in neutral air turns potential energy into motion; a wave in stable air turns it back and forth.
    for (const bool stable : {false, true}) {
        Parameters p = bare({48, 1, 48}, {3000, 3000, 3000});
        p.buoyancy = true;
        p.bubbles.push_back({{1500, 0, 900}, 700, 700, 1, 0, 0});
        const double top = stable ? 309 : 300;
        auto sim = Simulation::make(p, {"air", {0, 3000}, {300, top}, {0, 0}, {0, 0}, {0, 0}, 0});
        sim->start();
        double kinetic, most = 0;
        const double start = energy(*sim, kinetic);
        for (int i = 1; i <= 20; ++i) {
            sim->advance_to(30 * i);
            const double now = energy(*sim, kinetic);
            most = std::max(most, kinetic);
            EXPECT_LT(now - start, 1e-3 * most) << (stable ? "stable " : "neutral ") << 30 * i << " s";
            EXPECT_GT(now - start, -0.3 * most);
        }
        EXPECT_GT(most, 1e-3);
    }
}

TEST(Flow, AnelasticFlowConservesWeightedTheta)
{
    Parameters p = bare({24, 1, 40}, {6000, 6000, 10000});
    p.buoyancy = p.anelastic = true;
    p.scalar_scheme = ScalarScheme::Limited5;
    p.bubbles.push_back({{3000, 0, 2000}, 1500, 1500, 2, 0, 0});
    auto sim = Simulation::make(p, Sounding::uniform(300));
    EXPECT_LT(sim->column().rho_face.back(), 0.5);
    sim->advance_to(600);
    const Budget b = sim->budget();
    EXPECT_GT(b.w_max, 5);
    EXPECT_LT(std::abs(b.theta_drift), 1e-12);
    EXPECT_LT(b.divergence, 1e-12);
    EXPECT_LT(b.new_extrema, 1e-12);
}

}  // namespace
}  // namespace vdbcloud::sim
