// Manufactured solution: sources of momentum, heat and water make a given moist flow a solution. Advection, pressure,
// buoyancy of vapour and cloud, saturation by temperature, friction, viscosity and diffusion together must converge to
// it with their order in h and in dt.
#include "air.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Value, time derivative, gradient and Laplacian of a smooth function at a point.
struct Jet {
    double f = 0, t = 0, x = 0, y = 0, z = 0, laplacian = 0;
};
Jet operator+(const Jet& a, const Jet& b)
{
    return {a.f + b.f, a.t + b.t, a.x + b.x, a.y + b.y, a.z + b.z, a.laplacian + b.laplacian};
}

struct At {
    double x, y, z, t;
};

/// c trig(ax + phase) trig(by) trig(mz) cos(wt + shift), where each trig is a cosine, or a sine where asked.
struct Mode {
    double c, a, b, m, w, phase_x = 0, phase_y = 0, phase_z = 0, shift = 0;  // a phase of -pi/2 makes a sine

    Jet at(const At& p) const
    {
        const double px = a * p.x + phase_x, py = b * p.y + phase_y, pz = m * p.z + phase_z, pt = w * p.t + shift;
        const double cx = std::cos(px), cy = std::cos(py), cz = std::cos(pz), ct = std::cos(pt),
                     f = c * cx * cy * cz * ct;
        return {f,
                -w * c * cx * cy * cz * std::sin(pt),
                -a * c * std::sin(px) * cy * cz * ct,
                -b * c * cx * std::sin(py) * cz * ct,
                -m * c * cx * cy * std::sin(pz) * ct,
                -(a * a + b * b + m * m) * f};
    }
};

constexpr double sine = -M_PI / 2, length = 2000, height = 1000, end = 60;

/// The given flow: solenoidal, with a pressure of its own, in a wind; saturated everywhere, or on the crests of a wave
/// of water only.
struct Flow {
    bool deep, straddling;
    double a = 2 * M_PI / length, b = deep ? 2 * M_PI / length : 0, m = M_PI / height, w = 2 * M_PI / 300;
    double friction = 400, nu = 20, kappa = 30, wind = 3;

    // a U + b V + m W = 0.
    Jet u(const At& p) const
    {
        Jet j = Mode{2, a, b, m, w, sine + 0.3}.at(p);
        j.f += wind;
        return j;
    }
    Jet v(const At& p) const { return deep ? Mode{1, a, b, m, w, 0.3, sine}.at(p) : Jet{}; }
    Jet up(const At& p) const { return Mode{-(2 * a + (deep ? b : 0)) / m, a, b, m, w, 0.3, 0, sine}.at(p); }
    Jet pressure(const At& p) const { return Mode{1.5, a, b, m, w, 1.1, 0.4, 0, 0.7}.at(p); }
    Jet theta(const At& p) const
    {
        Jet j = Mode{0.4, a, b, m, w, 0.9, 0.2, 0, 0.3}.at(p) + Mode{0.2, 2 * a, 0, m, 2 * w, 0.1}.at(p);
        j.f += 295;
        return j;
    }
    Jet water(const At& p) const
    {
        Jet j = Mode{2e-3, a, b, m, w, 2.1, 1.2, 0, 1.3}.at(p);
        j.f += straddling ? 0.0146 : 0.03;
        return j;
    }

    Sounding sounding() const { return {"given", {0}, {295}, {water({}).f}, {wind}, {0}, 0}; }
    Parameters parameters(int n) const
    {
        Parameters p = bare({n, deep ? n : 1, n / 2}, {length, length, height});
        p.buoyancy = p.moisture = true;
        p.moist = {};  // by temperature, with latent heat, vapour and loading
        p.friction_time = friction, p.viscosity = nu, p.diffusivity = kappa;
        return p;
    }

    /// Buoyancy at any height, to a function of it: g (theta/theta0 + 0.608 q_v - q_l), in a column of one theta_l and
    /// one q_t.
    double buoyancy(const At& p, const Parameters& q) const
    {
        const Constants& k = q.constants;
        const double theta_v = 295 * (1 + 0.608 * sounding().water[0]);
        Level level;
        level.exner = 1 - k.g * p.z / (k.cp * theta_v);
        level.pressure = 1e5 * std::pow(level.exner, k.cp / k.r_dry);
        level.heat = k.latent_heat / k.cp / level.exner;
        const double q_t = water(p).f,
                     q_l = Thermodynamics(k, q.moist, true).cloud_water(level, theta(p).f - k.theta0, q_t);
        return k.g * ((theta(p).f + level.heat * q_l) / k.theta0 + 0.608 * (q_t - q_l) - q_l);
    }

    double transported(const Jet& j, const At& p) const { return j.t + u(p).f * j.x + v(p).f * j.y + up(p).f * j.z; }

    /// Rates that make it a solution.
    std::unique_ptr<Simulation> simulation(const Parameters& p) const
    {
        auto sim = Simulation::make(p, sounding());
        const Flow flow = *this;
        const auto add = [&](Quantity q, auto rate) {
            if (!sim->has(q)) return;
            sim->add_source(q, [rate](double x, double y, double z, double t) { return rate(At{x, y, z, t}); });
        };
        const auto moved = [flow](const Jet& j, const At& at, double push) {
            return flow.transported(j, at) + j.f / flow.friction - flow.nu * j.laplacian + push;
        };
        add(Quantity::U, [=](const At& at) { return moved(flow.u(at), at, flow.pressure(at).x); });
        add(Quantity::V, [=](const At& at) { return moved(flow.v(at), at, flow.pressure(at).y); });
        add(Quantity::W,
            [=](const At& at) { return moved(flow.up(at), at, flow.pressure(at).z - flow.buoyancy(at, p)); });
        add(Quantity::Theta,
            [=](const At& at) { return flow.transported(flow.theta(at), at) - flow.kappa * flow.theta(at).laplacian; });
        add(Quantity::Water,
            [=](const At& at) { return flow.transported(flow.water(at), at) - flow.kappa * flow.water(at).laplacian; });
        for (const Quantity q : {Quantity::U, Quantity::V, Quantity::W, Quantity::Theta, Quantity::Water})
            if (sim->has(q)) sim->set(q, given(q, p, 0));
        sim->start();
        return sim;
    }

    std::vector<double> given(Quantity q, const Parameters& p, double t) const
    {
        return values_at(p.lattice, q, [&](double x, double y, double z) {
            const At at{x, y, z, t};
            return (q == Quantity::U       ? u(at)
                    : q == Quantity::V     ? v(at)
                    : q == Quantity::W     ? up(at)
                    : q == Quantity::Theta ? theta(at)
                                           : water(at))
                .f;
        });
    }
};

/// Root mean square errors at `end`, of velocity [of 1 m/s], theta_l [1 K], q_t and q_l [1 g/kg].
struct Errors {
    double speed, theta, water, cloud;
};

Errors errors(const Flow& flow, int n)
{
    const Parameters p = flow.parameters(n);
    auto sim = flow.simulation(p);
    sim->advance_to(end);
    const auto error = [&](Quantity q) { return sim->has(q) ? rms(all(*sim, q), flow.given(q, p, end)) : 0.0; };
    const auto theta = flow.given(Quantity::Theta, p, end), water = flow.given(Quantity::Water, p, end);
    const Thermodynamics& thermo = sim->thermodynamics();
    std::vector<double> cloud;
    size_t dry = 0;
    for (size_t c = 0; c < theta.size(); ++c) {
        const Level& level = sim->column().level[c / (theta.size() / size_t(p.lattice.n[2]))];
        cloud.push_back(
            thermo.cloud_water(level, theta[c] - thermo.reference().theta, water[c] - thermo.reference().water));
        dry += cloud.back() == 0;
    }
    EXPECT_LT(std::abs(sim->budget().water_drift), 1e-11);  // sources included
    EXPECT_EQ(sim->budget().fault, "");
    if (flow.straddling)
        EXPECT_TRUE(dry > cloud.size() / 10 && dry < cloud.size() * 9 / 10) << dry;
    else
        EXPECT_EQ(dry, 0u);
    return {std::hypot(error(Quantity::U), error(Quantity::V), error(Quantity::W)), error(Quantity::Theta),
            1e3 * error(Quantity::Water), 1e3 * rms(all_cloud(*sim), cloud)};
}

void expect_order(const char* what, const Flow& flow, int n, double order)
{
    const Errors coarse = errors(flow, n), fine = errors(flow, 2 * n);
    const auto rate = [](double a, double b) { return std::log2(a / b); };
    const double speed = rate(coarse.speed, fine.speed), theta = rate(coarse.theta, fine.theta);
    const double water = rate(coarse.water, fine.water), cloud = rate(coarse.cloud, fine.cloud);
    std::printf("| %s | %d to %d | %.2f | %.2f | %.2f | %.2f | %.1e |\n", what, n, 2 * n, speed, theta, water, cloud,
                fine.speed);
    EXPECT_GT(speed, order) << what;
    EXPECT_GT(theta, order) << what;
    EXPECT_GT(water, order) << what;
    EXPECT_GT(cloud, order) << what;
    EXPECT_LT(fine.speed, 0.02) << what;
}

TEST(Manufactured, MoistFlowConvergesAtSecondOrderInSpace)
{
    expect_order("slice, saturated", {false, false}, 16, 1.8);
    expect_order("slice, saturated", {false, false}, 32, 1.9);
    expect_order("box, saturated", {true, false}, 12, 1.7);
    // A kink of buoyancy on the edges of cloud, which move: second order in the mean, as it is continuous.
    expect_order("slice, cloud on crests", {false, true}, 16, 1.7);
    expect_order("slice, cloud on crests", {false, true}, 32, 1.7);
}

double time_order(TimeScheme scheme, bool straddling)
{
    const Flow flow{false, straddling};
    const auto run = [&](TimeScheme with, int steps) {
        Parameters p = flow.parameters(16);
        p.time_scheme = with, p.dt = end / steps;
        auto sim = flow.simulation(p);
        sim->advance_to(end);
        EXPECT_EQ(sim->budget().steps, uint64_t(steps)) << "the step was split: the test needs a smaller one";
        std::vector<double> state = all(*sim, Quantity::W);
        for (const double value : all(*sim, Quantity::Theta)) state.push_back(value);
        for (const double value : all(*sim, Quantity::Water)) state.push_back(1e3 * value);
        return state;
    };
    const auto exact = run(TimeScheme::Rk3, 240);
    const double order = std::log2(rms(run(scheme, 15), exact) / rms(run(scheme, 30), exact));
    std::printf("order in dt%s: %.2f\n", straddling ? ", cloud on crests" : "", order);
    return order;
}

TEST(Manufactured, MoistFlowKeepsTheOrderOfItsStagesInTime)
{
    EXPECT_NEAR(time_order(TimeScheme::Euler, false), 1, 0.2);
    EXPECT_NEAR(time_order(TimeScheme::Rk2, false), 2, 0.2);
    EXPECT_NEAR(time_order(TimeScheme::Rk3, false), 3, 0.3);
    // Cells that become saturated or dry within a step cost the third order, not the second.
    const double crests = time_order(TimeScheme::Rk3, true);
    EXPECT_GT(crests, 1.6);
    EXPECT_LT(crests, 3);
}

TEST(Manufactured, RefusesASourceForAMissingField)
{
    auto sim = Simulation::make(bare({8, 8, 8}, {800, 800, 800}), Sounding::uniform(300));
    EXPECT_ANY_THROW(sim->add_source(Quantity::Water, [](double, double, double, double) { return 0.0; }));
}

}  // namespace
}  // namespace vdbcloud::sim
