// Rayleigh damping below the lid, so that waves are not reflected: Klemp and Lilly 1978. Velocities only: budgets stay.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>

namespace vdbcloud::sim::effect {

namespace {

/// dV/dt = -r(z) (V - V_env), r = rate sin^2(pi/2 (z - start) / (lid - start)) above start = lid (1 - depth).
template<typename T>
void add(Air<T>& air)
{
    const Parameters& p = air.parameters;
    if (!p.momentum) return;
    const int nz = air.lattice.n[2];
    const double dz = air.lattice.h[2], lid = nz * dz, start = lid * (1 - p.sponge_depth);
    const auto rate = [&](double z) {
        return z <= start ? 0 : p.sponge * std::pow(std::sin(pi / 2 * (z - start) / (lid - start)), 2);
    };
    for (int c = 0; c < 3; ++c) {
        Variable<T>& v = air.wind[size_t(c)];
        if (!v) continue;
        std::vector<double>& rates = air.relax(v).level;
        for (int k = 0; k < nz; ++k) rates.push_back(rate((c == 2 ? k : k + 0.5) * dz));
    }
}

}  // namespace

Effect sponge()
{
    return changeable({"sponge",
                       "",
                       {{"sponge", "damping rate of waves at the lid; 0 is off", "1/s", from_zero(1e3),
                         [](Parameters& p) -> double& { return p.sponge; }},
                        {"sponge-depth", "part of the height, below the lid, that damps", "", above_zero(1),
                         [](Parameters& p) -> double& { return p.sponge_depth; }}},
                       [](const Parameters& p) { return p.sponge > 0; },
                       nullptr,
                       nullptr,
                       {add<float>, add<double>}});
}

}  // namespace vdbcloud::sim::effect
