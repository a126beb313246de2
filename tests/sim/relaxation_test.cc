// Relaxation as an exact factor: it limits no step, adds to friction, and keeps the order of the stages.
#include "air.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

const Sounding breeze{"breeze", {0}, {300}, {0}, {5}, {-2}, 0};

/// Wind after `t` of a flow that begins uniform, u at every level; steps of `dt`.
struct Uniform {
    std::vector<double> u, v;
    uint64_t steps;
};
Uniform blown(Parameters p, double t)
{
    auto sim = Simulation::make(p, breeze);
    sim->set(Quantity::U, std::vector<double>(p.lattice.cells(), 8));
    sim->set(Quantity::V, std::vector<double>(p.lattice.cells(), 1));
    sim->start();
    sim->advance_to(t);
    Uniform result{{}, {}, sim->budget().steps};
    const size_t plane = size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]);
    const auto u = all(*sim, Quantity::U), v = all(*sim, Quantity::V);
    for (size_t c = 0; c < u.size(); c += plane) result.u.push_back(u[c]), result.v.push_back(v[c]);
    return result;
}

TEST(Relaxation, SpongeFrictionAndWindRelaxationAddTheirRatesExactly)
{
    // dU/dt = -U/t_f - (s + 1/tau) (U - U_env): rest U_env (s + 1/tau) / R, R = 1/t_f + s + 1/tau. One step of any
    // length.
    for (const TimeScheme scheme : {TimeScheme::Euler, TimeScheme::Rk2, TimeScheme::Rk3})
        for (const double sponge : {0.0, 0.05, 400.0}) {
            const double t_f = 70, tau = 45, t = 30;
            Parameters p = bare({4, 5, 10}, {400, 500, 1000});
            p.time_scheme = scheme;
            p.friction_time = t_f, p.wind_relaxation = tau, p.sponge = sponge, p.sponge_depth = 1, p.cfl = 0.75;
            const Uniform wind = blown(p, t);
            EXPECT_LE(wind.steps, uint64_t(std::ceil(t / (0.75 * 100 / 9.0))));  // 8 + 1 m/s in cells of 100 m
            for (size_t k = 0; k < wind.u.size(); ++k) {
                const double z = (double(k) + 0.5) / 10;
                const double back = sponge * std::pow(std::sin(M_PI / 2 * z), 2) + 1 / tau, rate = back + 1 / t_f;
                const double left = std::exp(-rate * t);
                EXPECT_NEAR(wind.u[k], 5 * back / rate * (1 - left) + 8 * left, 1e-12) << k << ' ' << sponge;
                EXPECT_NEAR(wind.v[k], -2 * back / rate * (1 - left) + 1 * left, 1e-12) << k << ' ' << sponge;
            }
        }
}

/// Wind and heat of a flow in a box under everything that relaxes the air, after 64 s in steps of dt.
std::vector<double> relaxed_flow(Parameters p, double dt)
{
    p.dt = dt, p.dt_max = 1e9;
    const Sounding s{"stable", {0, 2000}, {300, 304}, {0, 0}, {2, 4}, {0, 0}, 0};
    auto sim = Simulation::make(p, s);
    const double k = 2 * M_PI / 2000, m = M_PI / 1000;
    auto u = values_at(p.lattice, Quantity::U,
                       [&](double x, double, double z) { return 3 + 2 * std::sin(k * x) * std::cos(m * z); });
    sim->set(Quantity::U, u);
    auto theta = all(*sim, Quantity::Theta);
    const auto warm = values_at(p.lattice, Quantity::Theta,
                                [&](double x, double, double z) { return 0.5 * std::cos(k * x) * std::sin(m * z); });
    for (size_t c = 0; c < theta.size(); ++c) theta[c] += warm[c];
    sim->set(Quantity::Theta, theta);
    sim->start();
    sim->advance_to(64);
    std::vector<double> state = all(*sim, Quantity::U);
    for (const Quantity q : {Quantity::W, Quantity::Theta})
        for (const double value : all(*sim, q)) state.push_back(q == Quantity::Theta ? value - 300 : value);
    return state;
}

double order_in_time(const Parameters& p)
{
    const auto exact = relaxed_flow(p, 0.25);
    const double coarse = rms(relaxed_flow(p, 4), exact), fine = rms(relaxed_flow(p, 2), exact);
    EXPECT_GT(coarse, 1e-7);
    return std::log2(coarse / fine);
}

TEST(Relaxation, StagesKeepThirdOrderWithPressureAndTransport)
{
    Parameters p = bare({20, 1, 10}, {2000, 2000, 1000});
    p.buoyancy = true;
    p.wind_relaxation = 100, p.friction_time = 200;
    EXPECT_NEAR(order_in_time(p), 3, 0.2);
    // Rates that differ from cell to cell do not commute with the pressure: as a plain factor they have order 1.
    p.sponge = 0.04, p.sponge_depth = 0.6;
    EXPECT_NEAR(order_in_time(p), 3, 0.3);
    p.wind_relaxation = never, p.lattice.side[0] = Side::Open, p.side_relaxation = 30, p.side_cells = 5;
    EXPECT_GT(order_in_time(p), 2.7);  // not asymptotic yet: the error falls faster
}

TEST(Relaxation, FastRatesLimitNoStep)
{
    // Rates of 1000 per second: the steps are those of the wind, and the air is the environment's where the rates act.
    for (const bool huge : {false, true})
        for (const Precision precision : {Precision::Float, Precision::Double}) {
            Parameters p = bare({12, 10, 8}, {1200, 1000, 800}, Side::Open, Side::Open);
            p.precision = precision, p.buoyancy = p.dye = true, p.constants.g = 0,
            p.scalar_scheme = ScalarScheme::Limited5;
            if (huge) p.time_scheme = TimeScheme::HugeStep, p.dt = 20;
            p.side_cells = 3, p.side_relaxation = 1e9;
            Parameters stiff = p;
            stiff.side_relaxation = 1e-3, stiff.sponge = 1e3, stiff.wind_relaxation = 1e-3;
            std::unique_ptr<Simulation> sims[2];
            for (const int fast : {0, 1}) {
                auto& sim = sims[fast] = Simulation::make(fast ? stiff : p, breeze);
                sim->set(Quantity::U, std::vector<double>(p.lattice.cells(), 8));
                sim->set(Quantity::Theta, std::vector<double>(p.lattice.cells(), 303));
                sim->set(Quantity::Dye, std::vector<double>(p.lattice.cells(), 1));
                sim->start();
                sim->advance_to(60);
                const Budget b = sim->budget();  // throws if a value is not finite
                if (!huge) {
                    EXPECT_LT(std::abs(b.theta_drift), precision == Precision::Float ? 2e-6 : 1e-12);
                }
            }
            EXPECT_LE(sims[1]->budget().steps, sims[0]->budget().steps);
            EXPECT_GE(sims[1]->budget().steps, 3u);
            const double ulps = precision == Precision::Float ? 1e-4 : 1e-11;
            // Eddies of the jump of 3 m/s at the sides remain inside; nothing is faster than at the start.
            for (const double u : all(*sims[1], Quantity::U)) ASSERT_NEAR(u, 5, 3);
            const auto theta = all(*sims[1], Quantity::Theta), dye = all(*sims[1], Quantity::Dye);
            for (int j = 0; j < 10; ++j)
                for (int i = 0; i < 12; ++i) {
                    const bool near_side = i < 3 || i >= 9 || j < 3 || j >= 7;
                    const size_t c = size_t(12 * j + i);
                    if (near_side) {
                        ASSERT_NEAR(theta[c], 300, ulps);
                    }
                    ASSERT_GE(dye[c], 0);
                    ASSERT_LE(dye[c], 1 + ulps);
                    if (near_side) {
                        ASSERT_NEAR(dye[c], 0, ulps);
                    }
                }
        }
}

TEST(Relaxation, EqualsFirstOrderDecayForSlowRates)
{
    // What returns in a year loses t / tau of its distance in a minute.
    Parameters p = bare({4, 5, 6}, {400, 500, 600});
    p.wind_relaxation = 3.15e7;
    const Uniform wind = blown(p, 60);
    for (const double u : wind.u) EXPECT_NEAR((8 - u) / 3 / (60 / 3.15e7), 1, 1e-5);
}

TEST(Floor, FluxesEndExactlyAtTheirTime)
{
    // The box gains flux x until / height whatever the steps and frames are; times that rounding splits are one time.
    const double flux = 0.2, height = 800;
    for (const TimeScheme scheme : {TimeScheme::Rk3, TimeScheme::Euler, TimeScheme::HugeStep})
        for (const double until : {0.3, 37.0, 60.0, 89.99999999999, 200.0}) {
            Parameters p = bare({6, 1, 8}, {600, 600, height});
            p.buoyancy = true, p.time_scheme = scheme;
            p.floor.heat = flux, p.floor.until = until;
            auto sim = Simulation::make(p, Sounding::uniform(300));
            sim->start();
            const double before = sim->budget().theta_mean;
            for (const double frame : {0.1 + 0.2, 60.0, 90.0, 120.0}) {
                sim->advance_to(frame);
                const double gained = flux * std::min(until, frame) / height;
                EXPECT_NEAR((sim->budget().theta_mean - before) / gained, 1, 1e-9) << until << " at " << frame;
                EXPECT_EQ(sim->time(), frame);
            }
        }
}

}  // namespace
}  // namespace vdbcloud::sim
