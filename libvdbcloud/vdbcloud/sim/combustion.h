#pragma once
// How fuel burns in one cell. Private to sim/.
#include "vdbcloud/sim/air.h"

#include <cmath>

namespace vdbcloud::sim {

/// Temperature of a cell over its potential temperature, as frames have it.
template<typename T>
double exner_of(const Air<T>& air, int k)
{
    return air.parameters.moist.by == SaturationBy::Temperature ? air.column.level[size_t(k)].exner : 1;
}

/// Fuel that can burn in a cell of `temperature` [K]: none below ignition, and no more than heats it to the flame's
/// temperature.
inline double burnable(const Combustion& c, double fuel, double temperature)
{
    if (!(temperature > c.ignition)) return 0;
    return std::min(std::max(0.0, fuel), std::max(0.0, c.flame - temperature) / c.heat);
}

/// Heat that fuel gives to the air of row (j, k) [K/s].
template<typename T>
void flame_row(const Air<T>& air, int j, int k, double* out)
{
    const Combustion& c = air.parameters.combustion;
    const T *theta = air.theta.a[0].row(j, k), *fuel = air.fuel.a[0].row(j, k);
    const double from = air.reference(Quantity::Theta), exner = exner_of(air, k);
    for (int i = 0; i < air.lattice.n[0]; ++i)
        out[i] = c.heat / c.time * burnable(c, double(fuel[i]), (double(theta[i]) + from) * exner);
}

}  // namespace vdbcloud::sim
