// The parts of the equations themselves that can be off: see docs/cloudsim.md. Their terms are the solver's own.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

namespace vdbcloud::sim::effect {

Effect momentum()
{
    return {"momentum and pressure",
            "u, v, w with stages, pressure, transforms",
            {{"momentum", "the air moves by its forces; off: the sounding's wind blows for ever, but not at walls",
              [](Parameters& p) -> bool& { return p.momentum; }}},
            [](const Parameters& p) { return p.momentum; }};
}

Effect buoyancy()
{
    return {"buoyancy",
            "theta_l with stages",
            {{"buoyancy", "warm air rises", [](Parameters& p) -> bool& { return p.buoyancy; }}},
            [](const Parameters& p) { return p.buoyancy; }};
}

namespace {

template<typename T>
void add_water(Air<T>& air)
{
    air.allocate(air.water, Quantity::Water);
}

}  // namespace

Effect moisture()
{
    return {"moisture",
            "q_t with stages, condensation",
            {{"moisture", "the air carries water, and cloud forms", [](Parameters& p) -> bool& { return p.moisture; }}},
            [](const Parameters& p) { return p.moisture; },
            nullptr,
            [](const Parameters& p) { return state_arrays(p); },
            {add_water<float>, add_water<double>}};
}

Effect latent_heat()
{
    return {"latent heat",
            "",
            {{"latent-heat", "condensation warms the air", [](Parameters& p) -> bool& { return p.moist.latent_heat; }}},
            [](const Parameters& p) { return p.moisture && p.moist.latent_heat; }};
}

Effect vapour()
{
    return {"vapour in buoyancy",
            "",
            {{"vapour", "vapour is lighter than air", [](Parameters& p) -> bool& { return p.moist.vapour; }}},
            [](const Parameters& p) { return p.moisture && p.moist.vapour; }};
}

Effect loading()
{
    return {"cloud water in buoyancy",
            "",
            {{"loading", "cloud and rain weigh on the air", [](Parameters& p) -> bool& { return p.moist.loading; }}},
            [](const Parameters& p) { return p.moisture && p.moist.loading; }};
}

Effect anelastic()
{
    return {"anelastic base state",
            "a profile",
            {{"anelastic", "density of the base state falls with height: for boxes higher than 3 km",
              [](Parameters& p) -> bool& { return p.anelastic; }}},
            [](const Parameters& p) { return p.anelastic; }};
}

}  // namespace vdbcloud::sim::effect
