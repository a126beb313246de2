// Profiles and series against fields of known statistics.
#include "vdbcloud/sim/statistics.h"

#include "air.h"
#include "shapes.h"

#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <sstream>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// The values of a column by its name.
std::vector<double> column(const Sample& s, const std::string& name)
{
    for (size_t c = 0; c < profile_columns().size(); ++c)
        if (profile_columns()[c].name == name) return s.profiles[c];
    ADD_FAILURE() << name;
    return {};
}

double number(const Sample& s, const std::string& name)
{
    for (size_t c = 0; c < series_columns().size(); ++c)
        if (series_columns()[c].name == name) return s.series[c];
    ADD_FAILURE() << name;
    return 0;
}

/// Air without clouds that carries heat and water, and whose q_s is far above.
Parameters moist(std::array<int, 3> n, std::array<double, 3> size)
{
    Parameters p = bare(n, size);
    p.moisture = true, p.q_surface = 0.5;
    p.moist = {SaturationBy::Height, true, false, false};
    return p;
}

Sample sample_of(Simulation& sim) { return take_sample(sim, sim.budget()); }

TEST(Statistics, CovariancesOfSineWavesAreHalfTheProductOfTheirAmplitudes)
{
    // w at faces and its products are exact sums over whole waves; values at faces are means of two levels.
    Parameters p = moist({16, 8, 6}, {1600, 800, 600});
    auto sim = Simulation::make(p, Sounding::uniform(300));
    const double k = 2 * M_PI / 1600, shift = 0.4;
    const auto wave = [&](double mean, double amplitude, double phase) {
        return [=](double x, double, double z) { return mean + amplitude * (1 + z / 100) * std::sin(k * x + phase); };
    };
    sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta, wave(301, 0.2, 0)));
    sim->set(Quantity::Water, values_at(p.lattice, Quantity::Water, wave(0.01, 1e-4, M_PI / 3)));
    sim->set(Quantity::W, values_at(p.lattice, Quantity::W, [&](double x, double, double z) {
                 return z == 0 ? 0 : 0.3 + 2 * std::sin(k * x) + std::sin(2 * k * x + shift);
             }));
    sim->set(Quantity::V, values_at(p.lattice, Quantity::V, wave(-3, 0.5, 0)));
    const Sample s = sample_of(*sim);
    for (size_t l = 0; l < 6; ++l) {
        const double centre = 1.5 + double(l), face = 1 + double(l);  // of 1 + z / 100
        EXPECT_NEAR(column(s, "theta_l")[l], 301, 1e-10);
        EXPECT_NEAR(column(s, "theta_l2")[l], 0.02 * centre * centre, 1e-10);
        EXPECT_NEAR(column(s, "q_t2")[l], 0.5e-8 * centre * centre, 1e-15);
        EXPECT_NEAR(column(s, "v")[l], -3, 1e-12);
        EXPECT_NEAR(column(s, "v2")[l], 0.125 * centre * centre, 1e-12);
        EXPECT_NEAR(column(s, "w2")[l], l == 0 ? 0 : 2.5, 1e-12);
        // <sin^2 a sin(2a + s)> = -sin(s) / 4
        EXPECT_NEAR(column(s, "w3")[l], l == 0 ? 0 : -3 * std::sin(shift), 1e-12);
        EXPECT_NEAR(column(s, "w_theta_l")[l], l == 0 ? 0 : 0.2 * face, 1e-10);
        EXPECT_NEAR(column(s, "w_q_t")[l], l == 0 ? 0 : 1e-4 * face * std::cos(M_PI / 3), 1e-14);
        EXPECT_NEAR(column(s, "v_w")[l], l == 0 ? 0 : 0.5 * face, 1e-12);
        EXPECT_NEAR(column(s, "u_w")[l], 0, 1e-15);
        EXPECT_NEAR(column(s, "w_q_l")[l], 0, 0);
        const double squares = l == 0 || l == 5 ? 1.25 : 2.5;  // the lid is still
        EXPECT_NEAR(column(s, "tke")[l], 0.5 * (0.125 * centre * centre + squares), 1e-12);
    }
    EXPECT_NEAR(number(s, "w2_max"), 2.5, 1e-12);
    // u is on faces half a cell upwind of w, which is averaged to them.
    sim->set(Quantity::U, values_at(p.lattice, Quantity::U, wave(1, 0.5, 0)));
    EXPECT_NEAR(column(sample_of(*sim), "u_w")[3], 0.5 * 4 * std::cos(k * 50), 1e-12);
}

TEST(Statistics, CloudFractionCoverAndWaterPathCountCells)
{
    Parameters p = moist({10, 4, 5}, {1000, 400, 500});
    p.q_surface = 0.02, p.q_scale_height = 1e9;  // q_s = 0.02
    auto sim = Simulation::make(p, Sounding::uniform(300));
    std::vector<double> water(p.lattice.cells(), 0.01);
    // Level 1: 8 cells of cloud and 2 hardly saturated ones; level 2: 4 cells, 2 of them above those of level 1.
    for (size_t c = 0; c < 8; ++c) water[40 + c] = 0.021;
    for (size_t c = 8; c < 10; ++c) water[40 + c] = 0.02 + 1e-6;
    for (size_t c = 6; c < 8; ++c) water[80 + c] = 0.023;
    for (size_t c = 20; c < 22; ++c) water[80 + c] = 0.022;
    sim->set(Quantity::Water, water);
    const Sample s = sample_of(*sim);
    const double q_s = sim->column().level[1].q_height;
    EXPECT_NEAR(q_s, 0.02, 1e-8);
    EXPECT_EQ(column(s, "cloud_fraction"), (std::vector<double>{0, 0.2, 0.1, 0, 0}));
    EXPECT_EQ(column(s, "saturated_fraction"), (std::vector<double>{0, 0.25, 0.1, 0, 0}));
    EXPECT_NEAR(column(s, "q_l")[1], 0.2e-3 + 0.05e-6, 1e-8);
    EXPECT_NEAR(number(s, "cloud_cover"), 0.25, 1e-15);  // 8 columns and 2 more
    EXPECT_NEAR(number(s, "saturated_cover"), 0.30, 1e-15);
    EXPECT_NEAR(number(s, "lwp"), 1.16 * 100 * (0.2e-3 + 0.05e-6 + 0.25e-3), 1e-6);
    EXPECT_EQ(number(s, "cloud_base"), 150);
    EXPECT_EQ(number(s, "cloud_top"), 250);
    EXPECT_EQ(number(s, "cloud_fraction_max"), 0.2);
    // theta_v: latent heat, weight of vapour and of cloud.
    const double warm = 300 + 2.5e6 / 1004 * 1e-3;
    EXPECT_NEAR(column(s, "theta_v")[1],
                0.75 * 300 * (1 + 0.608 * 0.01) + 0.05 * (300 + 2.5e6 / 1004 * 1e-6) * (1 + 0.608 * 0.02) +
                    0.2 * warm * (1 + 0.608 * 0.02 - 1e-3),
                2e-4);
}

TEST(Statistics, WaterPathHasTheDensityOfEachLevel)
{
    Parameters p = moist({2, 3, 20}, {200, 100, 8000});
    p.anelastic = true, p.q_surface = 0.02, p.q_scale_height = 1e9;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::Water, std::vector<double>(p.lattice.cells(), 0.021));
    const Sample s = sample_of(*sim);
    double path = 0;
    for (size_t k = 0; k < 20; ++k) {
        EXPECT_NEAR(column(s, "q_l")[k], 1e-3, 1e-6);
        path += 1.16 * sim->column().rho_centre[k] * 400 * column(s, "q_l")[k];
    }
    EXPECT_LT(path, 0.8 * 1.16 * 8) << "air gets thinner";
    EXPECT_NEAR(number(s, "lwp"), path, 1e-12);
}

TEST(Statistics, StressHasTheShearAlongItsOwnAxis)
{
    // -nu (dv/dz + dw/dy); between walls the mean of dw/dy over 5 cells of 20 m is the difference of 4 of them over
    // 100.
    Parameters p = bare({4, 5, 3}, {400, 100, 300}, Side::Periodic, Side::Wall);
    p.viscosity = 2;
    auto sim = Simulation::make(p, Sounding::uniform(300));
    sim->set(Quantity::W, values_at(p.lattice, Quantity::W, [](double, double y, double) { return 0.01 * y; }));
    EXPECT_NEAR(column(sample_of(*sim), "subgrid_v_w")[1], -2 * 0.01 * 80 / 100, 1e-12);
    EXPECT_NEAR(column(sample_of(*sim), "subgrid_u_w")[1], 0, 1e-12);
}

TEST(Statistics, SubgridFluxesAreThoseOfTheEddyViscosityAndTheSurface)
{
    // Uniform shear S in neutral air: nu = (c_s delta)^2 S between floor and lid, whose mirror images have none.
    Parameters p = moist({6, 5, 12}, {600, 500, 1200});
    p.subgrid = true, p.viscosity = 2, p.diffusivity = 3;
    p.surface.friction_velocity = 0.3, p.floor.heat = 0.02, p.floor.moisture = 3e-5;
    const double shear = 0.01, nu = std::pow(0.17 * 100, 2) * shear;
    auto sim = Simulation::make(
        p, {"shear", {0, 1200}, {300, 300}, {0.012, 0.012 - 2e-6 * 1200}, {4, 4 + shear * 1200}, {0, 0}, 0});
    sim->start();
    const Sample s = sample_of(*sim);
    for (size_t k = 2; k < 11; ++k) {
        EXPECT_NEAR(column(s, "subgrid_u_w")[k], -(nu + 2) * shear, 1e-12) << k;
        EXPECT_NEAR(column(s, "subgrid_w_q_t")[k], (3 * nu + 3) * 2e-6, 1e-15) << k;
        EXPECT_NEAR(column(s, "subgrid_w_theta_l")[k], 0, 1e-12);
    }
    EXPECT_NEAR(column(s, "subgrid_w_theta_l")[0], 0.02, 1e-15);
    EXPECT_NEAR(column(s, "subgrid_w_q_t")[0], 3e-5, 1e-18);
    EXPECT_NEAR(column(s, "subgrid_u_w")[0], -0.09, 1e-14);
    EXPECT_NEAR(number(s, "surface_theta_flux"), 0.02, 1e-15);
    EXPECT_NEAR(number(s, "friction_velocity"), 0.3, 1e-14);
}

TEST(Statistics, BodiesHaveNoPart)
{
    // A step that fills the two lowest levels whole and the third where x < 800: there air has a wave of half the box.
    Parameters p = moist({16, 4, 6}, {1600, 400, 600});
    p.buoyancy = p.moist.latent_heat = false;
    p.colliders = {
        body([](const Point& at, double) { return std::min(at[2] - 200, std::max(at[0] - 800, at[2] - 300)); })};
    auto sim = Simulation::make(p, Sounding::uniform(300));
    const auto wave = [](double inside, double mean, double amplitude) {
        return [=](double x, double, double z) {
            return z < 200 || (z < 300 && x < 800) ? inside : mean + amplitude * std::sin(2 * M_PI * x / 800);
        };
    };
    sim->set(Quantity::Theta, values_at(p.lattice, Quantity::Theta, wave(700, 301, 0.2)));
    sim->set(Quantity::Water, values_at(p.lattice, Quantity::Water, wave(0.4, 0.01, 0.002)));
    const Sample s = sample_of(*sim);
    for (const char* name : {"theta_l", "q_t", "cloud_fraction", "theta_l2", "u", "tke"})
        for (size_t k = 0; k < 6; ++k) EXPECT_EQ(std::isnan(column(s, name)[k]), k < 2) << name << " " << k;
    for (size_t k = 2; k < 6; ++k) {
        EXPECT_NEAR(column(s, "theta_l")[k], 301, 1e-10) << k;
        EXPECT_NEAR(column(s, "theta_l2")[k], 0.02, 1e-10) << k;
        EXPECT_NEAR(column(s, "q_t2")[k], 2e-6, 1e-14) << k;
    }
    // A face is air where both cells are: none at the step's top, half of those above its riser.
    for (const char* name : {"w2", "w_theta_l", "subgrid_w_q_t"})
        for (size_t k = 1; k < 6; ++k) EXPECT_EQ(std::isnan(column(s, name)[k]), k < 3) << name << " " << k;
    for (const char* name : {"lwp", "tke_path", "w2_max", "cloud_cover"}) EXPECT_EQ(number(s, name), 0) << name;
}

TEST(Statistics, DependOnNoThreadsAndChangeNoBitsAlsoAfterACheckpoint)
{
    Parameters p = moist({12, 9, 20}, {1200, 900, 2000});
    p.precision = Precision::Float, p.buoyancy = p.subgrid = true, p.coriolis = 1e-3;
    p.moist = {};
    p.surface = {0, 1e-3, 1e-3, 1e-3, 303};
    p.large_scale.z = {0}, p.large_scale.w = {-0.05}, p.large_scale.theta = {-1e-4}, p.large_scale.water = {-1e-7};
    p.bubbles = {{{600, 450, 500}, 500, 400, 2, 9e-3, 0}};
    const Sounding air{"air", {0, 2000}, {300, 306}, {0.016, 0.008}, {5, 8}, {1, -1}, 0};
    std::vector<double> w[4];
    std::vector<Sample> samples;
    for (const int run : {0, 1, 2, 3}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, run == 1 ? 1 : 2);
        auto sim = Simulation::make(p, air);
        for (int t = 30; t <= 120; t += 30) {
            sim->advance_to(t);
            if (run < 2) samples.push_back(sample_of(*sim));
            if (run < 3 || t != 60) continue;
            std::stringstream state;
            sim->save(state);
            sim = Simulation::make(p, air);
            sim->restore(state);
        }
        w[run] = all(*sim, Quantity::W);
    }
    EXPECT_EQ(w[0], w[1]);
    EXPECT_EQ(w[0], w[2]);
    EXPECT_EQ(w[0], w[3]);
    for (size_t n = 0; n < 4; ++n) {
        EXPECT_EQ(samples[n].profiles, samples[n + 4].profiles);
        EXPECT_EQ(samples[n].series, samples[n + 4].series);
    }
    EXPECT_GT(number(samples[3], "cloud_cover"), 0);
}

TEST(ProfileMeans, AverageTheSamplesOfEachPeriod)
{
    ProfileMeans means(60);
    const auto profiles = [](double x) { return Profiles(profile_columns().size(), {x, 2 * x}); };
    EXPECT_FALSE(means.add(20, profiles(1)));
    EXPECT_FALSE(means.add(40, profiles(2)));
    EXPECT_TRUE(means.add(60, profiles(6)));
    EXPECT_EQ(means.current().samples, 3);
    EXPECT_NEAR(means.current().mean[4][1], 6, 1e-14);
    EXPECT_FALSE(means.add(80, profiles(10)));
    EXPECT_EQ(means.current().start, 60);
    EXPECT_EQ(means.current().samples, 1);
    EXPECT_EQ(means.current().mean[0][0], 10);
    // A run that continues from the bytes has equal bits.
    ProfileMeans again(60);
    again.restore(means.bytes(), 2);
    for (ProfileMeans* m : {&means, &again}) m->add(100, profiles(0.1));
    EXPECT_EQ(means.bytes(), again.bytes());
    EXPECT_THROW(ProfileMeans(30).restore(means.bytes(), 2), InputError);
    EXPECT_THROW(again.restore(means.bytes(), 3), InputError);
    // A sample after a pause of more than a period begins another one.
    means.add(301, profiles(4));
    EXPECT_EQ(means.current().start, 300);
    EXPECT_EQ(means.current().samples, 1);
}

}  // namespace
}  // namespace vdbcloud::sim
