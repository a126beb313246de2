// The mean wind of every level returns to the environment's; eddies are left alone.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

template<typename T>
void add(Air<T>& air)
{
    if (!air.parameters.momentum) return;
    for (const size_t c : {0, 1})
        if (air.wind[c]) air.relax(air.wind[c]).mean = 1 / air.parameters.wind_relaxation;
}

}  // namespace

Effect wind_relaxation()
{
    return changeable(
        {"wind relaxation",
         "level means",
         {Setting::time("wind-relaxation", "time in which the mean wind of a level returns to the sounding's",
                        above_zero(never), [](Parameters& p) -> double& { return p.wind_relaxation; })},
         [](const Parameters& p) { return std::isfinite(p.wind_relaxation); },
         nullptr,
         nullptr,
         {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
