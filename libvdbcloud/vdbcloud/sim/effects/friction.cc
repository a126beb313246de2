// Friction: a drag -V/t, which stages of a step take as the factor exp(-dt/t), exact alone for any dt.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

template<typename T>
void add(Air<T>& air)
{
    air.friction_time = air.parameters.friction_time;
}

}  // namespace

Effect friction()
{
    return changeable({"friction",
                       "",
                       {Setting::time("friction-time", "time t of the drag -V/t on the wind", above_zero(never),
                                      [](Parameters& p) -> double& { return p.friction_time; })},
                       [](const Parameters& p) { return std::isfinite(p.friction_time); },
                       nullptr,
                       nullptr,
                       {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
