#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/refuse.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace vdbcloud::sim {

std::string Range::text() const
{
    std::ostringstream text;
    const bool above = low > -any_finite, below = high < any_finite;
    if (above && below)
        open ? text << "above " << low << ", up to " << high : text << low << ".." << high;
    else if (above)
        text << (open ? "above " : "") << low << (open ? "" : " or above");
    else
        text << "a finite number";
    return text.str();
}

std::string Setting::key() const
{
    std::string key = name;
    std::replace(key.begin(), key.end(), '-', '_');
    return key;
}

bool Setting::on(const Parameters& p) const { return flag(const_cast<Parameters&>(p)); }

double Setting::number(const Parameters& p) const { return value(const_cast<Parameters&>(p)); }

void Setting::check(const Parameters& p) const
{
    if (kind == Kind::Switch || range.holds(number(p))) return;
    std::string words = name;
    std::replace(words.begin(), words.end(), '-', ' ');
    refuse(words, number(p), range.text() + (unit.empty() ? "" : " ") + unit);
}

Effect changeable(Effect effect)
{
    effect.can_change = true;
    return effect;
}

const std::vector<Effect>& effects()
{
    static const std::vector<Effect> table = [] {
        std::vector<Effect> list;
        for (const EffectMaker make : effect_table) list.push_back(make());
        return list;
    }();
    return table;
}

const std::vector<Setting>& constant_settings()
{
    static const std::vector<Setting> list{
        {"q-surface", "saturation by height: A of q_s = A exp(-z/H)", "kg/kg", above_zero(1),
         [](Parameters& p) -> double& { return p.q_surface; }},
        {"q-scale-height", "saturation by height: H; 0 takes the height of the box / ln 10", "m", from_zero(1e12),
         [](Parameters& p) -> double& { return p.q_scale_height; }},
        {"gravity", "gravity", "m/s^2", from_zero(1000), [](Parameters& p) -> double& { return p.constants.g; }},
        {"theta0", "potential temperature of the base state", "K", allowed_theta,
         [](Parameters& p) -> double& { return p.constants.theta0; }},
        {"latent-heat-of", "latent heat L of condensation", "J/kg", from_zero(1e8),
         [](Parameters& p) -> double& { return p.constants.latent_heat; }},
        {"cp",
         "specific heat of air at constant pressure",
         "J/(kg K)",
         {100, 1e6},
         [](Parameters& p) -> double& { return p.constants.cp; }},
        {"r-dry", "gas constant of dry air", "J/(kg K)", Range{50, 1e4},
         [](Parameters& p) -> double& { return p.constants.r_dry; }},
        {"r-vapour", "gas constant of water vapour", "J/(kg K)", Range{50, 1e4},
         [](Parameters& p) -> double& { return p.constants.r_vapour; }},
        {"pressure", "pressure at the floor where the sounding gives none", "Pa", Range{1, 1e8},
         [](Parameters& p) -> double& { return p.constants.surface_pressure; }},
        {"rho0", "density of air at the floor", "kg/m^3", Range{1e-3, 1e3},
         [](Parameters& p) -> double& { return p.constants.rho0; }},
    };
    return list;
}

const std::vector<Setting>& noise_settings()
{
    static const std::vector<Setting> list{
        {"noise", "amplitude of uniform noise on the first temperature", "K", from_zero(100),
         [](Parameters& p) -> double& { return p.noise.theta; }},
        {"noise-water", "amplitude of uniform noise on the first water", "kg/kg", from_zero(0.1),
         [](Parameters& p) -> double& { return p.noise.water; }},
        {"noise-below",
         "height below which there is noise",
         "m",
         {-never, never},
         [](Parameters& p) -> double& { return p.noise.below; }},
    };
    return list;
}

const std::vector<Setting>& numeric_settings()
{
    static const std::vector<Setting> list{
        {"cfl",
         "Courant number that sets the step: t (|u|/dx + |v|/dy + |w|/dz) stays below it, where t is 0.55 dt with rk3 "
         "and dt with other schemes",
         "", above_zero(0.75), [](Parameters& p) -> double& { return p.cfl; }},
        {"dt", "time step, split where it is above a limit; 0 takes the longest that the limits allow", "s",
         from_zero(1e6), [](Parameters& p) -> double& { return p.dt; }},
        {"dt-max", "longest time step", "s", above_zero(1e12), [](Parameters& p) -> double& { return p.dt_max; }},
    };
    return list;
}

}  // namespace vdbcloud::sim
