#include "vdbcloud/sim/presets.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/sim/large_scale.h"
#include "vdbcloud/sim/sounding.h"

#include <cmath>
#include <utility>

namespace vdbcloud::sim {

const std::vector<std::pair<std::string, std::string>>& sounding_tables();  // data/soundings, made by CMake

namespace {

/// A box with periodic sides, noise, a sponge below the lid, and the simulated time.
Preset begin(std::array<int, 3> cells, double h, double dz, const Noise& noise, double sponge, double depth,
             double minutes, double every)
{
    Preset s;
    s.parameters.lattice = {cells, {h, h, dz}, {Side::Periodic, Side::Periodic}};
    s.parameters.noise = noise;
    s.parameters.sponge = sponge, s.parameters.sponge_depth = depth;
    s.minutes = minutes, s.every = every;
    return s;
}

/// A warm field among cooler ones feeds one cloud; moist bubbles start it within minutes and give it turrets.
Preset cumulus()
{
    Preset s = begin({128, 128, 128}, 32, 30, {0.2, 1e-4, 800, 1}, 0.02, 0.15, 20, 10);
    Parameters& p = s.parameters;
    p.floor.heat = 0.03, p.floor.moisture = 3e-5;
    p.floor.patches = {{{2050, 1950}, 1250, 0.14, 1.2e-4, 0}};
    p.bubbles = {{{1700, 2000, 400}, 600, 450, 0.7, 1.3e-3, 0},
                 {{2350, 2250, 350}, 500, 400, 0.6, 1.1e-3, 0},
                 {{2150, 1500, 350}, 450, 350, 0.5, 1e-3, 0},
                 {{1350, 1650, 300}, 350, 300, 0.5, 1e-3, 0},
                 {{2750, 1800, 300}, 400, 300, 0.5, 9e-4, 0}};
    return s;
}

Preset congestus()
{
    Preset s = begin({128, 128, 160}, 64, 60, {0.2, 1e-4, 1000, 1}, 0.02, 0.15, 30, 10);
    Parameters& p = s.parameters;
    p.anelastic = p.rain = true;
    p.floor.heat = 0.04, p.floor.moisture = 5e-5;
    p.floor.patches = {{{3700, 4100}, 1400, 0.4, 3.5e-4, 0}, {{5000, 3700}, 900, 0.35, 3e-4, 0}};
    p.bubbles = {{{3700, 4050, 500}, 1200, 600, 0.9, 1.2e-3, 0},
                 {{4900, 3800, 450}, 900, 500, 0.7, 1e-3, 0},
                 {{4200, 5000, 400}, 800, 500, 0.6, 9e-4, 0}};
    return s;
}

Preset stratocumulus()
{
    Preset s = begin({128, 128, 96}, 25, 12.5, {0.1, 2.5e-5, 840, 1}, 0.02, 0.2, 60, 30);
    Parameters& p = s.parameters;
    p.radiation = 70;
    p.floor.heat = 0.012, p.floor.moisture = 4e-5;
    return s;
}

Preset fog()
{
    Preset s = begin({128, 128, 64}, 8, 4, {0.1, 5e-5, 90, 1}, 0.02, 0.3, 30, 15);
    Parameters& p = s.parameters;
    p.radiation = 40, p.radiation_kappa = 130;
    p.floor.heat = -0.003;
    return s;
}

Preset smoke()
{
    Preset s = begin({128, 64, 128}, 5, 5, {0.05, 0, 300, 1}, 0.05, 0.15, 5, 2);
    Parameters& p = s.parameters;
    p.moisture = false, p.dye = true;
    p.floor.patches = {{{120, 160}, 18, 25, 0, 8}};
    return s;
}

/// A camp fire: gas that burns above four heaps of wood, and its smoke.
Preset fire()
{
    Preset s = begin({64, 64, 96}, 0.05, 0.05, {5, 0, 1, 1}, 2, 0.2, 0.1, 0.0416666666666666667);
    Parameters& p = s.parameters;
    p.lattice.side = {Side::Open, Side::Open};
    p.side_relaxation = 1;
    p.moisture = false, p.dye = p.combustion.on = p.moist.hot = true;
    p.combustion = {true, 0.25, 6000, 1, 500, 2000};
    p.cooling = 3000, p.cooling_temperature = 2000;
    p.floor.patches = {{{1.6, 1.6}, 0.45, 25, 0, 0, 0.1},
                       {{1.3, 1.8}, 0.2, 40, 0, 0, 0.16},
                       {{1.9, 1.45}, 0.2, 40, 0, 0, 0.16},
                       {{1.75, 1.9}, 0.15, 40, 0, 0, 0.16}};
    s.smoke_extinction = 4;
    return s;
}

/// Siebesma et al. 2003: trade-wind cumulus without rain.
Preset bomex()
{
    Preset s = begin({64, 64, 75}, 100, 40, {0.1, 2.5e-5, 1600, 1}, 0.01, 0.2, 360, 60);
    Parameters& p = s.parameters;
    p.anelastic = p.subgrid = true;
    p.floor.heat = 8e-3, p.floor.moisture = 5.2e-5;
    p.surface.friction_velocity = 0.28;
    p.coriolis = 0.376e-4;
    p.large_scale = large_scale_named("bomex");
    return s;
}

/// vanZanten et al. 2011: trade-wind cumulus that rains, over a sea of one temperature.
Preset rico()
{
    Preset s = begin({128, 128, 100}, 100, 40, {0.1, 2.5e-5, 740, 1}, 0.01, 0.125, 1440, 60);
    Parameters& p = s.parameters;
    p.anelastic = p.subgrid = p.rain = true;
    p.surface = {0, 1.229e-3, 1.094e-3, 1.133e-3, 299.8};
    p.coriolis = 0.45e-4;
    p.large_scale = large_scale_named("rico");
    p.large_scale.carries_wind = false;
    return s;
}

/// Section 5.1 as printed: 10 x 10 x 20 points, forward differences, saturation by height, L/cp = 2500 K, no weight of
/// vapour and water. Upwind in space, as centred differences with forward steps are unstable.
Preset paper()
{
    Preset s = begin({10, 10, 20}, 200, 200, {0.2, 6e-4, 1000, 1}, 0, 0.2, 20, 10);
    Parameters& p = s.parameters;
    p.lattice.side = {Side::Wall, Side::Wall};
    p.moist = {SaturationBy::Height, true, false, false};
    p.constants.latent_heat = 2500 * p.constants.cp;
    p.friction_time = 600;
    p.time_scheme = TimeScheme::Euler;
    p.scalar_scheme = ScalarScheme::Upwind;
    p.momentum_scheme = MomentumScheme::Upwind;
    p.dt = 1;
    p.floor.patches = {{{900, 1050}, 900, 0.3, 3e-4, 0}};
    p.bubbles = {{{800, 950, 450}, 900, 600, 0.9, 1.4e-3, 0}, {{1300, 1200, 400}, 500, 500, 0.8, 1.1e-3, 0}};
    return s;
}

constexpr std::pair<const char*, Preset (*)()> presets[] = {
    {"cumulus", cumulus}, {"congestus", congestus}, {"stratocumulus", stratocumulus},
    {"fog", fog},         {"smoke", smoke},         {"fire", fire},
    {"bomex", bomex},     {"rico", rico},           {"paper", paper}};

}  // namespace

const std::vector<std::string>& preset_names()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const auto& [name, make] : presets) list.push_back(name);
        return list;
    }();
    return names;
}

Sounding sounding_named(const std::string& name)
{
    std::string names;
    for (const auto& [known, table] : sounding_tables()) {
        if (known == name) return read_sounding(name, table);
        names += (names.empty() ? "" : ", ") + known;
    }
    throw InputError("sounding '" + printable(name) + "': expected a file, or one of " + names);
}

Preset preset(const std::string& name)
{
    for (const auto& [known, make] : presets)
        if (known == name) {
            Preset s = make();
            s.sounding = sounding_named(name);
            return s;
        }
    std::string names;
    for (const std::string& known : preset_names()) names += (names.empty() ? "" : ", ") + known;
    throw InputError("preset '" + printable(name) + "': expected one of " + names);
}

void apply(Accuracy accuracy, Parameters& p)
{
    // All that an accuracy is about: a preset's own schemes and step give way.
    const Parameters own;
    p.precision = own.precision, p.cfl = own.cfl, p.dt = own.dt;
    p.time_scheme = own.time_scheme, p.scalar_scheme = own.scalar_scheme, p.momentum_scheme = own.momentum_scheme;
    switch (accuracy) {
    case Accuracy::Small: p.time_scheme = TimeScheme::Rk2, p.scalar_scheme = ScalarScheme::Koren, p.cfl = 0.5; break;
    case Accuracy::Accurate: p.precision = Precision::Double, p.cfl = 0.3; break;
    default: break;
    }
}

void rescale_forcing(Parameters& p, const Lattice& before)
{
    const auto factor = [&](size_t d) { return p.lattice.n[d] * p.lattice.h[d] / (before.n[d] * before.h[d]); };
    // An axis of one cell has no extent: bubbles and patches are cut through their centres.
    const double along[] = {p.lattice.flat(0) ? never : factor(0), p.lattice.flat(1) ? never : factor(1)};
    const double narrowest = std::min(along[0], along[1]), horizontal = std::isfinite(narrowest) ? narrowest : 1;
    for (Patch& patch : p.floor.patches) {
        patch.centre = {patch.centre[0] * factor(0), patch.centre[1] * factor(1)};
        patch.radius *= horizontal;
    }
    for (Bubble& b : p.bubbles) {
        b.centre[0] *= factor(0), b.centre[1] *= factor(1);
        b.radius *= horizontal;
    }
}

}  // namespace vdbcloud::sim
