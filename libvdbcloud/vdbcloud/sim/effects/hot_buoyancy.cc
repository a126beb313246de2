// Buoyancy of hot dry gas, g (theta - theta_env) / theta, which a density of 1 / theta gives. It equals the Boussinesq
// g theta'/theta0 for small deviations and stays below g for any, where that would grow without bound.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::sim::effect {

Effect hot_buoyancy()
{
    return {"buoyancy of hot gas",
            "",
            {{"hot-buoyancy",
              "buoyancy g (T - T_env) / T in place of g (T - T_env) / theta0: for dry air that is many kelvin hotter "
              "than its environment",
              [](Parameters& p) -> bool& { return p.moist.hot; }}},
            [](const Parameters& p) { return p.moist.hot; },
            [](const Parameters& p) {
                if (p.moist.hot && (!p.buoyancy || p.moisture))
                    throw InputError("buoyancy of hot gas: expected buoyancy, and no moisture");
            }};
}

}  // namespace vdbcloud::sim::effect
