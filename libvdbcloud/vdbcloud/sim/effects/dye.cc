// Dye: a scalar that the air carries and that acts on nothing, e.g. smoke.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

namespace vdbcloud::sim::effect {

namespace {

template<typename T>
void add(Air<T>& air)
{
    air.allocate(air.dye, Quantity::Dye);
}

}  // namespace

Effect dye()
{
    return {"dye",
            "dye with stages",
            {{"dye", "the air carries a passive scalar: smoke", [](Parameters& p) -> bool& { return p.dye; }}},
            [](const Parameters& p) { return p.dye; },
            nullptr,
            [](const Parameters& p) { return state_arrays(p); },
            {add<float>, add<double>}};
}

}  // namespace vdbcloud::sim::effect
