// Flow around bodies: the potential start around a ball, no leaks, and what it carries.
#include "air.h"
#include "shapes.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/openness.h"

#include <gtest/gtest.h>

#include <numeric>
#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

constexpr double radius = 100, wind_speed = 5;

Sounding wind(double u) { return {"wind", {0}, {300}, {0}, {u}, {0}, 0}; }
Sounding stratified() { return {"stable", {0, 1000}, {300, 310}, {0, 0}, {0, 0}, {0, 0}, 0}; }

/// A ball in the middle of a cube of ten radii.
Parameters around_ball(int n)
{
    Parameters p = bare({n, n, n}, {10 * radius, 10 * radius, 10 * radius});
    p.colliders = {ball({5 * radius, 5 * radius, 5 * radius}, radius)};
    return p;
}

/// A hill across the box.
std::shared_ptr<const Shape> hill(double height, double length)
{
    return std::make_shared<ClosedForm>(
        true, [=](const Point& x, double) { return x[2] - height * std::pow(std::sin(M_PI * x[0] / length), 2); },
        everywhere);
}

/// Root mean square error of the flow outside 1.4 radii and within 2.5, against the potential flow around a ball in air
/// without end, relative to the wind.
double error_of_start(const Simulation& sim)
{
    const Lattice& l = sim.parameters().lattice;
    double sum = 0, count = 0;
    for (const auto& [q, axis] : {std::pair{Quantity::U, 0}, {Quantity::V, 1}, {Quantity::W, 2}}) {
        const auto values = all(sim, q);
        const auto exact = values_at(l, q, [axis = axis](double a, double b, double c) {
            const double x[] = {a - 5 * radius, b - 5 * radius, c - 5 * radius}, r = std::hypot(x[0], x[1], x[2]);
            const double dipole = std::pow(radius / r, 3) / 2;
            return r < 1.4 * radius || r > 2.5 * radius
                       ? NAN
                       : wind_speed * ((axis == 0 ? 1 + dipole : 0) - 3 * dipole * x[0] * x[axis] / (r * r));
        });
        for (size_t i = 0; i < values.size(); ++i)
            if (!std::isnan(exact[i])) sum += std::pow(values[i] - exact[i], 2), ++count;
    }
    return std::sqrt(sum / count) / wind_speed;
}

/// Flux through the whole box along x over that of the undisturbed wind.
double mean_flux(const Simulation& sim)
{
    // Far from the ball all faces are open.
    const auto u = all(sim, Quantity::U);
    const Lattice& l = sim.parameters().lattice;
    double sum = 0;
    for (size_t c = 0; c < u.size(); c += size_t(l.n[0])) sum += u[c];
    return sum / (double(l.n[1]) * l.n[2]) / wind_speed;
}

TEST(Colliders, PlanesOpenFacesByTheirShares)
{
    // A floor of 130 m and a wall beyond y = 37 m, in cells of 20 x 10 x 50 m.
    Parameters p = bare({4, 5, 6}, {80, 50, 300});
    p.moisture = true, p.moist.by = SaturationBy::Height;
    const auto body = [](const std::function<double(const Point&)>& distance) {
        return std::make_shared<ClosedForm>(
            true, [=](const Point& x, double) { return distance(x); }, everywhere);
    };
    p.colliders = {body([](const Point& x) { return x[2] - 130; }), body([](const Point& x) { return 37 - x[1]; })};
    const Openness<double> open(p);
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(open.face[0](i, 0, 2), 0.4, 1e-12);
        EXPECT_NEAR(open.face[0](i, 3, 5), 0.7, 1e-12);
        EXPECT_NEAR(open.face[2](i, 3, 5), 0.7, 1e-12);
        EXPECT_EQ(open.face[2](i, 0, 2), 0);
        EXPECT_EQ(open.face[2](i, 0, 3), 1);
        EXPECT_EQ(open.face[1](i, 3, 5), 1);
        EXPECT_EQ(open.face[1](i, 4, 5), 0);
        EXPECT_EQ(open.face[1](i, 5, 5), 1) << "the first face again, of a periodic axis";
        EXPECT_EQ(open.ground[size_t(i)], 2);
    }
    // Cells within bodies keep the air of the environment.
    auto sim = Simulation::make(p, {"moist", {0, 300}, {300, 303}, {0.01, 0.004}, {0, 0}, {0, 0}, 0});
    sim->start();
    for (const size_t k : {0, 1}) {
        const double z = 25 + 50 * double(k);
        EXPECT_NEAR(all(*sim, Quantity::Water)[20 * k], 0.01 - 0.006 * z / 300, 1e-12);
        EXPECT_NEAR(all(*sim, Quantity::Theta)[20 * k], 300 + 3 * z / 300, 1e-9);
    }
}

TEST(Colliders, TheStartAroundABallIsPotentialFlow)
{
    double error[2], mass[2];
    size_t run = 0;
    for (const int n : {24, 48}) {
        auto sim = Simulation::make(around_ball(n), wind(wind_speed));
        sim->start();
        // Air within the ball is gone, and half as much again is the added mass: 1.5 of the share of the volume.
        error[run] = error_of_start(*sim), mass[run] = (1 - mean_flux(*sim)) / (4 * M_PI / 3 * 1e-3);
        EXPECT_LT(sim->budget().divergence, 1e-12);
        EXPECT_LE(sim->pressure_iterations(), 40u);
        // The flow is the same before and behind: no drag.
        const auto u = all(*sim, Quantity::U);
        double skew = 0;
        for (int k = 0; k < n; ++k)
            for (int j = 0; j < n; ++j)
                for (int i = 1; i < n; ++i)
                    skew =
                        std::max(skew, std::abs(u[size_t((k * n + j) * n + i)] - u[size_t((k * n + j) * n + n - i)]));
        EXPECT_LT(skew, 1e-9);
        ++run;
    }
    EXPECT_LT(error[1], 0.003) << "4.8 cells a radius";
    EXPECT_GT(error[0] / error[1], 2.6) << "images of the ball, 0.1 % of the wind, are in both";
    EXPECT_NEAR(mass[1], 1.5, 0.04);
    EXPECT_GT((1.5 - mass[0]) / (1.5 - mass[1]), 3) << "order 1.6 or more: flat pieces cut off a part of the ball";
}

TEST(Colliders, PotentialFlowHasNoDrag)
{
    // d'Alembert: while the wake is young, the flow loses momentum by the errors of transport near the surface alone.
    auto sim = Simulation::make(around_ball(40), wind(wind_speed));
    sim->start();
    const double before = mean_flux(*sim), time = 0.2 * radius / wind_speed;
    sim->advance_to(time);
    const double force = (before - mean_flux(*sim)) * wind_speed * 1e3 * radius * radius * radius / time;
    const double drag = force / (0.5 * wind_speed * wind_speed * M_PI * radius * radius);
    EXPECT_LT(std::abs(drag), 0.15);
}

TEST(Colliders, NoJetsBlowThroughSlits)
{
    // Potential flow has 1.5 of the wind at the side of a ball, and a wake is slower.
    auto sim = Simulation::make(around_ball(24), wind(wind_speed));
    for (const double radii : {1, 4, 10}) {
        sim->advance_to(radii * radius / wind_speed);
        EXPECT_LT(sim->budget().speed_max, 1.65 * wind_speed) << radii;
    }
}

TEST(Colliders, NothingLeaksAndDyeAndHeatAreKept)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = bare({32, 12, 20}, {640, 240, 400}, Side::Periodic, Side::Wall);
        p.precision = precision, p.scalar_scheme = ScalarScheme::Limited5;
        p.buoyancy = p.dye = true;
        p.colliders = {ball({310, 115, 150}, 70), hill(90, 640)};
        p.bubbles = {{{150, 120, 200}, 90, 90, 1, 0, 2}, {{310, 115, 150}, 60, 60, 0, 0, 9}};
        auto sim = Simulation::make(p, wind(4));
        sim->start();
        EXPECT_NEAR(all(*sim, Quantity::Dye)[size_t((7 * 12 + 5) * 32 + 15)], 0, 0) << "within the ball";
        sim->advance_to(60);
        const Budget b = sim->budget();
        EXPECT_EQ(b.fault, "");
        EXPECT_GT(b.steps, 10u);
        EXPECT_LT(std::abs(b.dye_drift), precision == Precision::Float ? 1e-6 : 1e-12);
        EXPECT_LT(std::abs(b.theta_drift), precision == Precision::Float ? 1e-6 : 1e-12);
        EXPECT_LT(b.new_extrema, precision == Precision::Float ? 1e-4 : 1e-9);
        for (const double value : all(*sim, Quantity::Dye)) ASSERT_GE(value, 0);
        EXPECT_EQ(all(*sim, Quantity::Dye)[size_t((7 * 12 + 5) * 32 + 15)], 0) << "none gets in";
        EXPECT_EQ(all(*sim, Quantity::U)[size_t((7 * 12 + 5) * 32 + 15)], 0);
    }
}

TEST(Colliders, AirAtRestStaysAtRestOverTerrain)
{
    for (const Side side : {Side::Periodic, Side::Open, Side::Wall}) {
        Parameters p = bare({20, 6, 16}, {2000, 600, 1000}, side, Side::Periodic);
        p.buoyancy = true, p.anelastic = side == Side::Open;
        p.colliders = {hill(400, 2000)};
        auto sim = Simulation::make(p, stratified());
        sim->advance_to(600);
        for (const Quantity q : {Quantity::U, Quantity::V, Quantity::W}) EXPECT_EQ(largest(all(*sim, q)), 0);
    }
}

TEST(Colliders, ABodyBeyondTheBoxChangesNothing)
{
    for (const Side side : {Side::Periodic, Side::Open, Side::Wall}) {
        Parameters p = bare({16, 12, 14}, {160, 120, 140}, side, Side::Open);
        p.buoyancy = true;
        p.bubbles = {{{80, 60, 50}, 40, 40, 2, 0, 0}};
        auto free = Simulation::make(p, wind(side == Side::Wall ? 0 : 1));
        p.colliders = {ball({80, 60, -500}, 100)};
        auto beside = Simulation::make(p, wind(side == Side::Wall ? 0 : 1));
        free->advance_to(20), beside->advance_to(20);
        for (const Quantity q : {Quantity::U, Quantity::V, Quantity::W})
            EXPECT_LT(largest_difference(all(*free, q), all(*beside, q)), 1e-9);
        EXPECT_EQ(free->pressure_iterations(), 0u);
        EXPECT_GT(free->budget().w_max, 0.1);
    }
}

TEST(Colliders, HeatOfTheFloorEntersAboveTheGround)
{
    Parameters p = bare({12, 4, 10}, {1200, 400, 1000});
    p.buoyancy = true, p.floor.heat = 0.1, p.time_scheme = TimeScheme::Euler, p.dt = 1;
    p.colliders = {std::make_shared<ClosedForm>(
        true, [](const Point& x, double) { return std::max(x[2] - 300, std::abs(x[0] - 600) - 200); }, everywhere)};
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->advance_to(1);
    const auto theta = all(*sim, Quantity::Theta);
    for (int k = 0; k < 10; ++k)
        for (int i = 0; i < 12; ++i)
            EXPECT_NEAR(theta[size_t(k * 48 + i)] - 300, k == (i >= 4 && i < 8 ? 3 : 0) ? 1e-3 : 0, 1e-9)
                << i << " " << k;
}

TEST(Colliders, ContinueFromACheckpointWithEqualBits)
{
    Parameters p = bare({16, 8, 12}, {320, 160, 240});
    p.precision = Precision::Float, p.buoyancy = p.dye = true, p.scalar_scheme = ScalarScheme::Limited5;
    p.colliders = {ball({160, 80, 100}, 50)};
    p.bubbles = {{{80, 80, 100}, 60, 60, 1, 0, 1}};
    auto once = Simulation::make(p, wind(3)), half = Simulation::make(p, wind(3)), again = Simulation::make(p, wind(3));
    half->advance_to(20);
    std::stringstream state;
    half->save(state), again->restore(state);
    once->advance_to(20), once->advance_to(40), again->advance_to(40);
    for (const Quantity q : {Quantity::U, Quantity::W, Quantity::Theta, Quantity::Dye})
        EXPECT_EQ(all(*once, q), all(*again, q));
}

TEST(Colliders, WhatWouldPassThroughThemIsRefused)
{
    const auto refused = [](const std::function<void(Parameters&)>& change) {
        Parameters p = around_ball(8);
        EXPECT_NO_THROW(check(p, wind(0)));
        change(p);
        EXPECT_THROW(check(p, wind(0)), InputError);
    };
    refused([](Parameters& p) { p.momentum = false; });
    refused([](Parameters& p) { p.time_scheme = TimeScheme::HugeStep; });
    refused([](Parameters& p) { p.viscosity = 1; });
    refused([](Parameters& p) { p.subgrid = true; });
    refused([](Parameters& p) { p.rain = p.moisture = true; });
    refused([](Parameters& p) { p.frame = {1, 0}; });
    refused([](Parameters& p) { p.wind_relaxation = 60; });
    refused([](Parameters& p) { p.colliders = {mask([](const Point&, double) { return 1.0; })}; });
}

}  // namespace
}  // namespace vdbcloud::sim
