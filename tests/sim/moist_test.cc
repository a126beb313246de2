// Moist thermodynamics and convection against closed forms.
#include "air.h"

#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace vdbcloud::sim {
namespace {

using namespace test;

Thermodynamics moist_air() { return {Constants{}, MoistTerms{}, true}; }

TEST(Saturation, MatchesBolton)
{
    const Thermodynamics thermo = moist_air();
    for (double t = 200; t <= 320; t += 7.3)
        for (const double p : {1e5, 8e4, 5e4}) {
            const double e = 611.2 * std::exp(17.67 * (t - 273.15) / (t - 29.65)), eps = 287.05 / 461.5;
            const double q = eps * e / (p - (1 - eps) * e);
            double slope;
            EXPECT_NEAR(thermo.saturation(t, p, &slope) / q, 1, 1e-14);
            const double step = 1e-3;
            const double numeric = (thermo.saturation(t + step, p) - thermo.saturation(t - step, p)) / (2 * step);
            EXPECT_NEAR(slope / numeric, 1, 1e-6);
        }
}

TEST(Saturation, CloudWaterSatisfiesSaturationAdjustment)
{
    // q_l = q_t - q_s(T) with T = exner theta_l + (L/cp) q_l: what is found must satisfy it to round-off.
    const Thermodynamics thermo = moist_air();
    const Constants c;
    for (int sample = 0; sample < 2000; ++sample) {
        const auto random = [&](int which, double low, double high) {
            return low + (high - low) * uniform(hash_bits(9, uint64_t(sample), uint64_t(which)));
        };
        Level level;
        level.exner = random(0, 0.7, 1);
        level.pressure = 1e5 * std::pow(level.exner, c.cp / c.r_dry);
        const double theta_l = random(1, -20, 20), q_t = random(2, 0, 0.04);
        const double q_l = thermo.cloud_water(level, theta_l, q_t);
        const double t = (theta_l + c.theta0) * level.exner + c.latent_heat / c.cp * q_l;
        EXPECT_NEAR(q_l, std::max(0.0, q_t - thermo.saturation(t, level.pressure)), 1e-15);
        // Single precision: within its own rounding of the temperature, times the slope of saturation.
        const float tf = float(theta_l), qf = float(q_t);
        float lf = 0;
        thermo.cloud_row(level, &tf, &qf, &lf, 1);
        double slope;
        thermo.saturation(t, level.pressure, &slope);
        EXPECT_NEAR(lf, thermo.cloud_water(level, tf, qf), std::max(1e-7, 1e-4 * slope));
    }
}

TEST(Saturation, CloudWaterDoesNotDependOnPositionInRow)
{
    const Thermodynamics thermo = moist_air();
    std::vector<float> theta(37, 1.5f), water(37, 0.03f), cloud(37);
    thermo.cloud_row(Level{}, theta.data(), water.data(), cloud.data(), 37);
    for (const float q : cloud) EXPECT_EQ(q, cloud[0]);
    EXPECT_GT(cloud[0], 0);
}

Parameters moist_box(int n, Precision precision)
{
    Parameters p = bare({n, 1, n}, {4000, 4000, 4000});
    p.precision = precision;
    p.buoyancy = p.moisture = true;
    p.moist.by = SaturationBy::Height;
    p.scalar_scheme = ScalarScheme::Limited5;
    return p;
}

/// Largest difference of velocities between an everywhere saturated run and its dry twin, over the largest velocity.
/// The bubble of 1 K overturns within 300 s and rolls up. `sounding_water` is what the environment says, from which
/// fields are counted.
double twin_difference(Precision precision, double end, double sounding_water)
{
    Parameters moist = moist_box(32, precision);
    const double q_t = 0.05;  // above saturation everywhere
    const double heat = moist.constants.latent_heat / moist.constants.cp;
    Parameters dry = moist;
    dry.moisture = false;
    const auto theta = [&](double shift) {
        return values_at(moist.lattice, Quantity::Theta, [&, shift](double x, double, double z) {
            const double r = std::hypot(x - 1900, z - 1200) / 700;
            return 300 - shift + (r < 1 ? std::pow(std::cos(M_PI / 2 * r), 2) : 0) + 1e-3 * z;
        });
    };
    Sounding wet{"wet", {0}, {300 - heat * sounding_water}, {sounding_water}, {0}, {0}, 0};
    auto a = Simulation::make(moist, wet), b = Simulation::make(dry, Sounding::uniform(300));
    a->set(Quantity::Theta, theta(heat * q_t));
    a->set(Quantity::Water, std::vector<double>(moist.lattice.cells(), q_t));
    b->set(Quantity::Theta, theta(0));
    a->start(), b->start();
    a->advance_to(end), b->advance_to(end);
    EXPECT_GT(a->budget().cloud_base, 0);
    EXPECT_LT(a->budget().cloud_base, 100);
    const auto w = all(*a, Quantity::W);
    EXPECT_GT(largest(w), 0.1);
    return std::max(largest_difference(w, all(*b, Quantity::W)),
                    largest_difference(all(*a, Quantity::U), all(*b, Quantity::U))) /
           largest(w);
}

TEST(MoistFlow, SaturatedFlowEqualsItsDryTwin)
{
    EXPECT_LT(twin_difference(Precision::Double, 1000, 0.05), 1e-6);
    EXPECT_LT(twin_difference(Precision::Float, 1000, 0.05), 1e-6);
    // Counted from another value, all of theta_l - 50 K - and its latent heat meet in single precision: 4e-6 K of each
    // against 1 K, growing as the bubble rolls up.
    EXPECT_LT(twin_difference(Precision::Double, 1000, 0.03), 1e-6);
    EXPECT_LT(twin_difference(Precision::Float, 1000, 0.03), 1e-3);
}

/// Growth of one mode in a layer of constant N^2 < 0, saturated (so the moist value rules) or dry.
double growth_error(bool saturated, double friction)
{
    const double n2 = -1e-5, height = 2000, width = 3000, k = 2 * M_PI / width, m = M_PI / height;
    Parameters p = bare({48, 1, 32}, {width, width, height});
    p.buoyancy = true;
    p.friction_time = friction;
    const double slope = n2 * 300 / 9.81;
    Sounding s{"layer", {0, height}, {300, 300 + slope * height}, {0, 0}, {0, 0}, {0, 0}, 0};
    const double heat = p.constants.latent_heat / p.constants.cp;
    if (saturated) {
        // theta_l rises so that theta = theta_l + (L/cp)(q_t - q_s(z)) has the same gradient everywhere: stable dry,
        // and unstable by what the vapour gives. Saturation is linear enough only if taken as it is, so build theta_l
        // from it.
        p.moisture = true;
        p.moist.by = SaturationBy::Height;
        p.q_scale_height = 4000;
        const double q_t = 0.03;
        s = {"layer", {}, {}, {}, {}, {}, 0};
        for (int i = 0; i <= 400; ++i) {
            const double z = height * i / 400, q_s = 0.02 * std::exp(-z / 4000);
            s.z.push_back(z), s.water.push_back(q_t), s.u.push_back(0), s.v.push_back(0);
            s.theta.push_back(300 + slope * z - heat * (q_t - q_s) + heat * (0.02 - q_s));
        }
        // A rising parcel keeps theta_l, so what it feels is the gradient of theta_l: slope, by construction.
        for (size_t i = 0; i < s.theta.size(); ++i) s.theta[i] = 300 - heat * q_t + slope * s.z[i];
    }
    p.dt = 4;
    auto sim = Simulation::make(p, s);
    const double rate0 = std::sqrt(-n2) * k / std::hypot(k, m), drag = 1 / friction;
    const double rate = -drag / 2 + std::sqrt(drag * drag / 4 + rate0 * rate0);
    const auto mode = [&](double x, double, double z) { return std::cos(k * x) * std::sin(m * z); };
    // The growing mode: theta' = -slope w / rate.
    const double a = 1e-5;
    sim->set(Quantity::W,
             values_at(p.lattice, Quantity::W, [&](double x, double y, double z) { return a * mode(x, y, z); }));
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, [&](double x, double, double z) {
                 return -a * m / k * std::sin(k * x) * std::cos(m * z);
             }));
    std::vector<double> theta = values_at(
        p.lattice, Quantity::Theta, [&](double x, double y, double z) { return -slope * a * mode(x, y, z) / rate; });
    const auto base = all(*sim, Quantity::Theta);
    for (size_t i = 0; i < theta.size(); ++i) theta[i] += base[i];
    sim->set(Quantity::Theta, theta);
    sim->start();
    const double before = sim->budget().kinetic, t = 4 / rate0;
    sim->advance_to(t);
    return std::log(sim->budget().kinetic / before) / (2 * t) / rate - 1;
}

TEST(MoistFlow, ConvectiveGrowthRatesMatchLinearTheory)
{
    EXPECT_NEAR(growth_error(false, never), 0, 0.01);
    EXPECT_NEAR(growth_error(false, 200), 0, 0.01);
    EXPECT_NEAR(growth_error(true, never), 0, 0.01);
    EXPECT_NEAR(growth_error(true, 200), 0, 0.01);
}

/// A moist warm bubble in dry-neutral air under a humid sounding.
std::unique_ptr<Simulation> bubble(SaturationBy by, Precision precision, int n = 40)
{
    Parameters p = moist_box(n, precision);
    p.moist.by = by;
    p.bubbles.push_back({{2000, 0, 500}, 500, 450, 1.5, 1e-3, 0});
    return Simulation::make(p, {"layer", {0, 4000}, {300, 304}, {0.012, 0.012}, {0, 0}, {0, 0}, 0});
}

TEST(MoistFlow, CloudBaseLiesAtTheLiftingLevel)
{
    // q_t is 12 g/kg around the bubble and up to 13 within: base lies between the two lifting levels, to a cell.
    auto sim = bubble(SaturationBy::Height, Precision::Double);
    const double scale = 4000 / std::log(10.0), dz = 100;
    const double low = scale * std::log(0.02 / 0.013), high = scale * std::log(0.02 / 0.012);
    Parameters p = sim->parameters();
    sim->advance_to(60);
    // Above the lifting level the layer itself is saturated from the start: its base is exact.
    EXPECT_GE(sim->budget().cloud_base, low - dz / 2 - 1e-6);
    EXPECT_LE(sim->budget().cloud_base, high + dz);  // the first cell whose centre is above
    // One parcel, by temperature: from the level where q_s(T) of the dry adiabat meets q_t, found by bisection.
    const Thermodynamics& thermo = sim->thermodynamics();
    Parameters q = p;
    q.moist.by = SaturationBy::Temperature;
    q.bubbles = {{{2000, 0, 500}, 800, 450, 1, 0, 0}};
    q.lattice = {{64, 1, 80}, {50, 50, 25}, {Side::Periodic, Side::Periodic}};
    const double water = 0.014;
    auto moist =
        Simulation::make(q, {"mixed", {0, 700, 2000}, {300, 300, 303}, {water, water, 0.004}, {0, 0, 0}, {0, 0, 0}, 0});
    moist->advance_to(600);
    double lift = 0;
    for (double a = 0, b = 2000; b - a > 1e-6;) {
        lift = 0.5 * (a + b);
        const double exner = 1 - 9.81 * lift / (1004 * 300 * (1 + 0.608 * water)),
                     pressure = 1e5 * std::pow(exner, 1004 / 287.05);
        (thermo.saturation(300 * exner, pressure) > water ? a : b) = lift;
    }
    ASSERT_GT(moist->budget().cloud_max, 1e-4);
    // The bubble is 1 K warmer and mixes with drier air above: its base is at most that warmth (125 m/K) higher.
    EXPECT_GE(moist->budget().cloud_base, lift - 25);
    EXPECT_LE(moist->budget().cloud_base, lift + 125 + 25);
}

TEST(MoistFlow, CondensateStaysBelowItsAdiabaticCeiling)
{
    for (const SaturationBy by : {SaturationBy::Height, SaturationBy::Temperature}) {
        auto sim = bubble(by, Precision::Double);
        const auto& level = sim->column().level;
        sim->start();
        const Reference from = sim->thermodynamics().reference();
        const double wettest = sim->budget().water_max - from.water, coldest = sim->budget().theta_min - from.theta;
        const double warmest = sim->budget().theta_max;
        sim->advance_to(500);
        const auto cloud = all_cloud(*sim);
        double most = 0;
        for (size_t c = 0; c < cloud.size(); ++c) {
            const Level& l = level[c / 40];
            ASSERT_LE(cloud[c], sim->thermodynamics().cloud_water(l, coldest, wettest) + 1e-12);
            most = std::max(most, cloud[c]);
        }
        EXPECT_GT(most, 1e-3);
        EXPECT_LE(sim->budget().theta_max, warmest + 1e-9);
    }
}

TEST(MoistFlow, BudgetsCloseAndScalarsKeepTheirBounds)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = bare({24, 24, 24}, {2400, 2400, 2400});
        p.precision = precision;
        p.buoyancy = p.moisture = true;
        p.moist = {};
        p.scalar_scheme = ScalarScheme::Limited5;
        p.bubbles.push_back({{1200, 1200, 500}, 600, 450, 2, 2e-3, 0});
        p.noise = {0.1, 1e-4, 1000, 3};
        auto sim =
            Simulation::make(p, {"s", {0, 800, 2400}, {300, 300, 306}, {0.014, 0.013, 0}, {0, 0, 0}, {0, 0, 0}, 0});
        sim->advance_to(600);
        const Budget b = sim->budget();
        const bool single = precision == Precision::Float;
        EXPECT_GT(b.steps, 50);
        EXPECT_GT(b.w_max, 3);
        EXPECT_GT(b.cloud_max, 5e-4);
        EXPECT_LT(std::abs(b.water_drift), single ? 2e-6 : 1e-12);
        EXPECT_LT(std::abs(b.theta_drift), single ? 2e-6 : 1e-12);
        EXPECT_LT(b.divergence, single ? 1e-5 : 1e-12);
        EXPECT_LT(b.new_extrema, single ? 4 * 1.2e-7 : 1e-14);
        EXPECT_GE(b.water_min, 0);
        EXPECT_EQ(b.fault, "");
    }
}

TEST(MoistFlow, SaturatedAirAtRestStaysAtRest)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        Parameters p = moist_box(16, precision);
        p.moist.by = SaturationBy::Temperature;
        auto sim = Simulation::make(p, {"fog", {0, 4000}, {285, 320}, {0.03, 0.03}, {0, 0}, {0, 0}, 0});
        sim->advance_to(3600);
        EXPECT_GT(sim->budget().cloud_max, 1e-3);
        EXPECT_LE(sim->budget().speed_max, precision == Precision::Float ? 1e-5 : 1e-12);
    }
}

TEST(MoistFlow, SymmetricStartStaysSymmetric)
{
    for (const Precision precision : {Precision::Float, Precision::Double}) {
        auto sim = bubble(SaturationBy::Temperature, precision);
        sim->advance_to(400);
        const auto w = all(*sim, Quantity::W);
        double odd = 0;
        for (int k = 0; k < 40; ++k)
            for (int i = 0; i < 40; ++i)
                odd = std::max(odd, std::abs(w[size_t(k * 40 + i)] - w[size_t(k * 40 + 39 - i)]));
        EXPECT_LT(odd, (precision == Precision::Float ? 1e-4 : 1e-10) * largest(w));
    }
}

/// Cloud in a wave of water that a uniform wind carries while it diffuses: q_t = mean + a exp(-kappa k^2 t) sin k(x - U
/// t), an exact solution, with q_l = max(q_t - q_s(z), 0). Returns the mean error of q_l over its mean.
double moving_cloud_error(int n, double mean)
{
    const double length = 4000, k = 2 * M_PI / length, wind = 10, kappa = 2000, end = 100, a = 2e-3;
    Parameters p = bare({n, 1, 2}, {length, length, 200});
    p.momentum = false, p.moisture = true;
    p.moist.by = SaturationBy::Height;
    p.q_scale_height = 4000;
    p.diffusivity = kappa;
    p.dt = 20000.0 / (n * n);
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {mean}, {wind}, {0}, 0});
    const auto water = [&](double t) {
        return values_at(p.lattice, Quantity::Water, [&, t](double x, double, double) {
            // Means over a cell, which is what cells hold.
            const double cell = std::sin(k * length / n / 2) / (k * length / n / 2);
            return mean + a * cell * std::exp(-kappa * k * k * t) * std::sin(k * (x - wind * t));
        });
    };
    sim->set(Quantity::Water, water(0));
    sim->start();
    sim->advance_to(end);
    const auto cloud = all_cloud(*sim), exact = water(end);
    double error = 0, sum = 0;
    for (size_t c = 0; c < cloud.size(); ++c) {
        const double q_l = std::max(0.0, exact[c] - sim->column().level[c / size_t(n)].q_height);
        error += std::abs(cloud[c] - q_l), sum += q_l;
    }
    EXPECT_GT(sum, 0);
    return error / sum;
}

TEST(MoistFlow, AdvectedDiffusingCloudConvergesAtSecondOrder)
{
    for (const double mean : {0.03, 0.0195}) {  // everywhere saturated; saturated on the crests only
        const double coarse = moving_cloud_error(16, mean), middle = moving_cloud_error(32, mean),
                     fine = moving_cloud_error(64, mean);
        EXPECT_GT(std::log2(coarse / middle), 1.7) << mean;
        EXPECT_GT(std::log2(middle / fine), 1.8) << mean;
    }
}

/// A rising, smooth, moist flow that is below saturation at first, to time `end` in steps of dt.
std::vector<double> lifted(double end, double dt, double& cloud)
{
    Parameters p = bare({24, 1, 24}, {2400, 2400, 2400});
    p.buoyancy = p.moisture = true;
    p.moist.by = SaturationBy::Height;
    p.q_scale_height = 1700;
    p.viscosity = p.diffusivity = 10;
    p.dt = dt;
    Sounding s{"moist", {}, {}, {}, {}, {}, 0};
    for (int i = 0; i <= 240; ++i) {
        s.z.push_back(10 * i), s.theta.push_back(300), s.u.push_back(0), s.v.push_back(0);
        s.water.push_back(0.96 * 0.02 * std::exp(-10 * i / 1700.0));
    }
    auto sim = Simulation::make(p, s);
    sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta, [](double x, double, double z) {
                 return 300 + 0.3 * std::cos(2 * M_PI * x / 2400) * std::sin(M_PI * z / 2400);
             }));
    sim->start();
    sim->advance_to(end);
    cloud = sim->budget().cloud_max;
    EXPECT_EQ(sim->budget().steps, uint64_t(std::lround(end / dt)));
    return all(*sim, Quantity::W);
}

TEST(MoistFlow, OrderInTimeIsThreeBeforeCloudFormsAndLowerAfter)
{
    // Saturation has a kink, which cells cross within steps: a third-order formula needs smooth tendencies.
    double cloud;
    const auto order = [&](double end) {
        const auto exact = lifted(end, 0.125, cloud);
        return std::log2(rms(lifted(end, 4, cloud), exact) / rms(lifted(end, 2, cloud), exact));
    };
    const double dry = order(80);
    EXPECT_EQ(cloud, 0);
    EXPECT_NEAR(dry, 3, 0.25);
    const double wet = order(260);
    EXPECT_GT(cloud, 1e-5);
    EXPECT_GT(wet, 0.8);
    EXPECT_LT(wet, 2.7);
    RecordProperty("order_after_onset", std::to_string(wet));
    std::printf("order in dt: %.2f before the first cloud, %.2f after\n", dry, wet);
}

}  // namespace
}  // namespace vdbcloud::sim
