// What heats, moistens and starts the air, against closed forms: floor, radiation, bubbles, noise, dye.
#include "air.h"

#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

namespace vdbcloud::sim {
namespace {

using namespace test;

/// Still air that carries heat, water and dye.
Parameters still(std::array<int, 3> n, std::array<double, 3> size)
{
    Parameters p = bare(n, size);
    p.momentum = false, p.moisture = p.dye = true;
    p.moist = {SaturationBy::Height, true, true, true};
    return p;
}

/// What a field gained between the start and `time`.
std::vector<double> gain(Simulation& sim, Quantity q, double time)
{
    const auto before = all(sim, q);
    sim.advance_to(time);
    auto after = all(sim, q);
    for (size_t c = 0; c < after.size(); ++c) after[c] -= before[c];
    return after;
}

TEST(Floor, UniformFluxesWarmAndMoistenTheLowestCellsUntilTheyEnd)
{
    // Flux x time / dz; the last step that begins before the end counts whole: 12 steps of 1 s.
    Parameters p = still({4, 3, 5}, {400, 300, 250});
    p.floor.heat = 0.3, p.floor.moisture = 2e-4, p.floor.until = 12, p.dt = 1;
    for (const Quantity q : {Quantity::Theta, Quantity::Water}) {
        auto sim = Simulation::make(p, Sounding::uniform(300));
        const auto gained = gain(*sim, q, 40);
        for (size_t c = 0; c < gained.size(); ++c) {
            const double flux = q == Quantity::Theta ? 0.3 : 2e-4;
            EXPECT_NEAR(gained[c], c < 12 ? flux * 12 / 50 : 0, 1e-12) << c;
        }
    }
}

TEST(Floor, PatchesAreGaussianAndTheMapMultipliesUniformFluxesOnly)
{
    Parameters p = still({8, 6, 3}, {800, 600, 150});
    p.floor.heat = 0.1, p.floor.moisture = 1e-4;
    p.floor.patches = {{{250, 350}, 180, 0.4, 3e-4, 2}, {{650, 50}, 90, -0.2, 0, 0}};
    for (int c = 0; c < 48; ++c) p.floor.map.push_back(0.25 * (c % 5));
    p.dt = 1;
    for (const bool anelastic : {false, true}) {
        p.anelastic = anelastic;
        for (const Quantity q : {Quantity::Theta, Quantity::Water, Quantity::Dye}) {
            auto sim = Simulation::make(p, Sounding::uniform(300));
            const double rho = sim->column().rho_centre[0];
            EXPECT_EQ(rho < 1, anelastic);
            const auto gained = gain(*sim, q, 10);
            for (int j = 0; j < 6; ++j)
                for (int i = 0; i < 8; ++i) {
                    const auto bell = [&](double x, double y, double radius) {
                        const double dx = 100 * (i + 0.5) - x, dy = 100 * (j + 0.5) - y;
                        return std::exp(-(dx * dx + dy * dy) / (radius * radius));
                    };
                    const double map = 0.25 * ((j * 8 + i) % 5), one = bell(250, 350, 180), two = bell(650, 50, 90);
                    const double flux = q == Quantity::Theta   ? 0.1 * map + 0.4 * one - 0.2 * two
                                        : q == Quantity::Water ? 1e-4 * map + 3e-4 * one
                                                               : 2 * one;
                    EXPECT_NEAR(gained[size_t(j * 8 + i)], flux * 10 / 50 / rho, 1e-12 * (1 + std::abs(flux)));
                }
        }
    }
}

/// Heating of every cell in one second by long-wave radiation [K/s], under cloud water by level.
std::vector<double> radiated(const Parameters& given, const std::vector<double>& cloud, std::vector<Level>& levels)
{
    Parameters p = given;
    p.time_scheme = TimeScheme::Euler, p.dt = 1;
    auto sim = Simulation::make(p, {"air", {0}, {290}, {0}, {0}, {0}, 0});
    levels = sim->column().level;
    std::vector<double> water;
    const size_t plane = size_t(p.lattice.n[0]) * size_t(p.lattice.n[1]);
    for (size_t k = 0; k < levels.size(); ++k)
        for (size_t c = 0; c < plane; ++c) water.push_back(levels[k].q_height + (cloud[k] > 0 ? cloud[k] : -1e-3));
    sim->set(Quantity::Water, water);
    sim->start();
    return gain(*sim, Quantity::Theta, 1);
}

TEST(Radiation, AThickCloudLosesTheWholeFluxInItsTopCell)
{
    // 5 g/kg in cells of 100 m: kappa LWP is 49 a cell, so all of F is lost in the first below the top.
    Parameters p = still({2, 2, 10}, {200, 200, 1000});
    p.radiation = 70;
    std::vector<Level> levels;
    const auto rate = radiated(p, {0, 0, 5e-3, 5e-3, 5e-3, 5e-3, 5e-3, 0, 0, 0}, levels);
    for (size_t c = 0; c < rate.size(); ++c) {
        const size_t k = c / 4;
        // Net flux / (rho cp dz), of theta: over the Exner function. Height mode has its own Exner, near 1.
        const double expected = k == 6 ? -70 / (1.16 * 1004 * 100 * levels[k].exner) : 0;
        EXPECT_NEAR(rate[c], expected, 1e-12) << k;  // rounding of 290 K is 6e-14
    }
    EXPECT_LT(rate[24], -5e-4);
}

TEST(Radiation, AThinCloudCoolsAsFluxDivergesAlongItsWaterPath)
{
    for (const bool anelastic : {false, true}) {
        Parameters p = still({2, 2, 10}, {200, 200, 2000});
        p.radiation = 40, p.radiation_kappa = 130, p.anelastic = anelastic;
        const std::vector<double> cloud{0, 0, 1e-5, 4e-5, 3e-5, 0, 0, 6e-5, 2e-5, 0};
        std::vector<Level> levels;
        const auto rate = radiated(p, cloud, levels);
        const Column column = make_column(p, {"air", {0}, {290}, {0}, {0}, {0}, 0});
        double path = 0, integral = 0;  // water above [kg/m^2], heat lost [W/m^2]
        for (size_t k = 10; k-- > 0;) {
            const double rho = 1.16 * column.rho_centre[k], below = path + rho * cloud[k] * 200;
            const double lost = 40 * (std::exp(-130 * path) - std::exp(-130 * below));
            EXPECT_NEAR(rate[4 * k], -lost / (rho * 1004 * 200 * levels[k].exner), 1e-12) << k;
            integral += rate[4 * k] * rho * 1004 * 200 * levels[k].exner;
            path = below;
        }
        EXPECT_NEAR(integral, -40 * (1 - std::exp(-130 * path)), 1e-6);
        EXPECT_LT(integral, -20);
    }
}

TEST(Bubbles, AreCosineSquaredAndAddUp)
{
    Parameters p = still({10, 8, 12}, {1000, 800, 1200});
    p.bubbles = {{{420, 370, 510}, 300, 200, 2, 1e-3, 3}, {{550, 450, 650}, 250, 350, -1, -5e-4, 0}};
    auto sim = Simulation::make(p, {"air", {0}, {300}, {0.01}, {0}, {0}, 0});
    const auto amount = [&](double first, double second) {
        return values_at(p.lattice, Quantity::Theta, [&](double x, double y, double z) {
            double sum = 0;
            for (const auto& [b, strength] : {std::pair{p.bubbles[0], first}, {p.bubbles[1], second}}) {
                const double dx = (x - b.centre[0]) / b.radius, dy = (y - b.centre[1]) / b.radius,
                             dz = (z - b.centre[2]) / b.height, r = std::sqrt(dx * dx + dy * dy + dz * dz);
                if (r < 1) sum += strength * 0.5 * (1 + std::cos(M_PI * r));
            }
            return sum;
        });
    };
    const auto theta = all(*sim, Quantity::Theta), water = all(*sim, Quantity::Water), dye = all(*sim, Quantity::Dye);
    const auto warm = amount(2, -1), wet = amount(1e-3, -5e-4), smoke = amount(3, 0);
    ASSERT_GT(largest(warm), 1);
    for (size_t c = 0; c < theta.size(); ++c) {
        EXPECT_NEAR(theta[c], 300 + warm[c], 1e-12) << c;
        EXPECT_NEAR(water[c], 0.01 + wet[c], 1e-16) << c;
        EXPECT_NEAR(dye[c], smoke[c], 1e-14) << c;
    }
}

TEST(Noise, IsUniformWithinItsAmplitudeAndBelowItsHeight)
{
    Parameters p = still({24, 24, 20}, {2400, 2400, 2000});
    p.noise = {0.2, 1e-4, 1000, 7};
    auto sim = Simulation::make(p, {"air", {0}, {300}, {0.01}, {0}, {0}, 0});
    const auto theta = all(*sim, Quantity::Theta), water = all(*sim, Quantity::Water);
    double sum = 0, squares = 0, product = 0, low = 0, high = 0;
    const size_t noisy = theta.size() / 2;  // centres below 1000 m
    for (size_t c = 0; c < theta.size(); ++c) {
        const double a = (theta[c] - 300) / 0.2, b = (water[c] - 0.01) / 1e-4;
        if (c >= noisy) {
            EXPECT_NEAR(a, 0, 1e-12);
            EXPECT_NEAR(b, 0, 1e-12);
            continue;
        }
        sum += a, squares += a * a, product += a * b, low = std::min(low, a), high = std::max(high, a);
        EXPECT_LE(std::abs(b), 1 + 1e-12);
    }
    const double n = double(noisy);
    EXPECT_GE(low, -1 - 1e-12);
    EXPECT_LE(high, 1 + 1e-12);
    EXPECT_LT(low, -0.99);
    EXPECT_GT(high, 0.99);
    // Five standard errors of n = 5760 uniform draws: of the mean, of the mean square 1/3, of the correlation 0.
    EXPECT_NEAR(sum / n, 0, 5 * std::sqrt(1 / 3.0 / n));
    EXPECT_NEAR(squares / n, 1 / 3.0, 5 * std::sqrt((1 / 5.0 - 1 / 9.0) / n));
    EXPECT_NEAR(product / n, 0, 5 / 3.0 / std::sqrt(n));
    // Another seed is another noise.
    p.noise.seed = 8;
    const auto other = all(*Simulation::make(p, {"air", {0}, {300}, {0.01}, {0}, {0}, 0}), Quantity::Theta);
    EXPECT_GT(rms(theta, other), 0.2 * 0.5 * std::sqrt(2 / 3.0) * std::sqrt(0.5));
}

TEST(Dye, MovesWithTheWindAndMovesNothing)
{
    // A wave of dye in a wind of 10 m/s, once around: fifth-order fluxes damp it by (k h)^6 / 60 a cell.
    Parameters p = bare({32, 1, 2}, {3200, 3200, 200});
    p.momentum = false, p.dye = true, p.dt = 0.5;
    auto sim = Simulation::make(p, {"wind", {0}, {300}, {0}, {10}, {0}, 0});
    const auto wave = [&](double t) {
        return values_at(p.lattice, Quantity::Dye,
                         [t](double x, double, double) { return 2 + std::sin(2 * M_PI * (x - 10 * t) / 3200); });
    };
    sim->set(Quantity::Dye, wave(0));
    sim->start();
    sim->advance_to(250);
    const double kh = 2 * M_PI / 32;
    EXPECT_LT(largest_difference(all(*sim, Quantity::Dye), wave(250)), 1.5 * 25 * std::pow(kh, 6) / 60);
    // A bubble with dye and the same without rise alike, bit for bit.
    std::vector<double> w[2];
    for (const bool dyed : {false, true}) {
        Parameters q = bare({12, 1, 12}, {1200, 1200, 1200});
        q.buoyancy = true, q.dye = dyed;
        q.bubbles = {{{600, 0, 400}, 300, 300, 1, 0, 5}};
        auto thermal = Simulation::make(q, Sounding::uniform(300));
        thermal->advance_to(100);
        w[dyed] = all(*thermal, Quantity::W);
    }
    EXPECT_GT(largest(w[0]), 0.1);
    EXPECT_EQ(w[0], w[1]);
}

}  // namespace
}  // namespace vdbcloud::sim
